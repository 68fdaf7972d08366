"""A law of the chambers' own pressures that has no name of its own, beside an effect that has.

Where one law does as well as another, so would the base's own with another curve: what chambers do with their own
pressure is then an error of the base that these data have no name for. What stands beside it is sure, and is the
answer.
"""

from dataclasses import replace

from labrig.diagnosis._base_form import beside_form
from labrig.diagnosis._candidates import fit
from labrig.diagnosis._limit import is_law
from labrig.diagnosis._search import Search
from labrig.diagnosis._verdict import rivals_of


def without_ties(searched: Search) -> Search:
    """What was found without a law that ties with others, which is judged as the base's own."""
    chosen = searched.chosen
    laws = [part for part in chosen.parts if is_law(part)] if chosen else []
    if chosen is None or searched.wrong_form or len(laws) != 1 or len(chosen.parts) == 1:
        return searched
    if beside_form(chosen.columns.streams) is None:
        return searched
    law = laws[0].effect.name
    alike = [rival for rival in rivals_of(searched) if rival.alike]
    names = {part.effect.name for forms in searched.found.values() for part in forms if is_law(part)}
    if not alike or any(rival.instead_of != law or rival.effect not in names for rival in alike):
        return searched
    return replace(
        searched,
        chosen=fit([part for part in chosen.parts if part is not laws[0]]),
        static_ground=replace(searched.static_ground, found={}),
        judged=chosen,
        wrong_form=True,
        could_be=tuple(sorted({law, *(rival.effect for rival in alike)})),
    )
