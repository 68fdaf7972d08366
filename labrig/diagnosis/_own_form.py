"""A law of the chambers' own pressures that has no name of its own, beside an effect that has.

Where one law does as well as another, and an error of form of the base as well as either, what chambers do with their
own pressure is an error of the base that these data have no name for. What stands beside it is sure, and is the answer.
"""

from dataclasses import replace

from labrig.diagnosis._base_form import NEARLY_ALL, beside_form, on
from labrig.diagnosis._candidates import fit, square_of
from labrig.diagnosis._limit import is_law
from labrig.diagnosis._search import Search
from labrig.diagnosis._verdict import rivals_of


def without_ties(searched: Search) -> Search:
    """What was found without a law that ties with others and with the base's own error of form."""
    chosen = searched.chosen
    laws = [part for part in chosen.parts if is_law(part)] if chosen else []
    if chosen is None or searched.wrong_form or len(laws) != 1 or len(chosen.parts) == 1:
        return searched
    streams = chosen.columns.streams
    kept = fit([part for part in chosen.parts if part is not laws[0]])
    beside = beside_form(streams)
    judged = on(beside, kept) if beside else None
    if beside is None or judged is None:
        return searched
    by_form = square_of(beside, beside.residual - judged.heldout)
    by_law, without = (square_of(streams, streams.residual - f.heldout) for f in (chosen, kept))
    if by_form - by_law > NEARLY_ALL * (without - by_law):
        return searched
    alike = [rival for rival in rivals_of(searched) if rival.alike]
    names = {part.effect.name for forms in searched.found.values() for part in forms if is_law(part)}
    tied = alike and all(r.instead_of == laws[0].effect.name and r.effect in names for r in alike)
    if not tied:
        return searched
    ground = replace(searched.static_ground, streams=beside, found={})
    could_be = tuple(sorted({laws[0].effect.name, *(r.effect for r in alike)}))
    return replace(
        searched,
        chosen=on(streams, judged),
        static_ground=ground,
        judged=judged,
        wrong_form=True,
        could_be=could_be,
    )
