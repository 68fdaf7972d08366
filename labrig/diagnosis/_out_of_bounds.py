"""Names whose formula fits only outside its physical bounds, where another's fits as well within its own."""

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence

from labrig._text import listed
from labrig.diagnosis._candidates import Candidate, plausible
from labrig.diagnosis._formula import good_enough
from labrig.diagnosis._parameters import off_grid
from labrig.effects import is_family

_BOUNDED = {"pressure", "field"}
"""Kinds of terms whose coefficients have bounds; a free pattern is of any size."""

_MOVED = 3
"""Best ones of each form that are moved off the grid, which may stop at the grid's ends; numerical."""


def in_place_of(
    found: Mapping[str, Sequence[Candidate]],
    names: Collection[str],
    taken_back: Collection[str] = (),
    together: Collection[str] = (),
) -> frozenset[str]:
    """The effects that may be there in place of the one that is named, or was taken back; none where a formula of what
    is named is within its bounds.

    A lag by a sixth of each change, say, is no delay, of which most lags, and may be creep: both are one function, and
    evidence does not know how large either is. `found` are the forms of each effect, fitted alone, so only one name is
    asked about, and none where several act `together`: alone it takes what the others explain, too.
    """
    if len(names) + len(taken_back) != 1 or len(together) > 1:
        return frozenset()
    (name,) = (*names, *taken_back)
    if not (own := _formulas(found.get(name, ()))):
        return frozenset()
    best = max(own, key=lambda c: c.score.gain)
    if names:
        as_good: list[Candidate] = []
        # most are within as they stand, which is quick
        for forms in (filter(is_bounded, own), _off_grid(own)):
            as_good = [one for one in forms if good_enough(one, best)]
            if any(map(_within, as_good)):
                return frozenset()
        if not as_good:
            return frozenset()
    return frozenset(
        other
        for other, forms in found.items()
        if other != name
        and any(good_enough(one, best) and _within(one) for one in _off_grid(_formulas(forms)))
    )


def said_of(names: Collection[str], others: Collection[str]) -> list[str]:
    """A line on why what is named is not sure: what may be there in its place."""
    if not others:
        return []
    name, instead = listed(sorted(names)), listed(sorted(others), "or")
    return [
        f"{name} fits only by values outside what is physical for it, and {instead} as well by values within: either "
        f"may be there (labrig effects show {next(iter(names))} has the bounds)"
    ]


def _formulas(forms: Sequence[Candidate]) -> list[Candidate]:
    return [c for c in forms if not is_family(c.variant.form)]


def _off_grid(formulas: Sequence[Candidate]) -> Iterator[Candidate]:
    """Of each form whose coefficients have bounds the best ones, moved off the search's grid."""
    seen: Counter[str] = Counter()
    for one in sorted(filter(is_bounded, formulas), key=lambda c: -c.score.gain):
        seen[one.variant.form] += 1
        if seen[one.variant.form] > _MOVED:
            continue
        yield off_grid(one)


def is_bounded(one: Candidate) -> bool:
    """Whether all coefficients of a form have bounds."""
    return all(term.kind in _BOUNDED for term in one.variant.terms)


def _within(one: Candidate) -> bool:
    return plausible(one.effect, one.variant, one.columns, one.score)
