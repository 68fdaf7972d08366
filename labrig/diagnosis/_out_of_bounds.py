"""Names whose formula fits only outside its physical bounds, where another's fits as well within its own."""

from collections.abc import Collection, Iterator, Mapping, Sequence

from labrig.diagnosis._candidates import Candidate, plausible
from labrig.diagnosis._formula import good_enough
from labrig.diagnosis._parameters import refined
from labrig.effects import is_family

_BOUNDED = {"pressure", "field"}
"""Kinds of terms whose coefficients have bounds; a free pattern is of any size."""


def out_of_bounds(found: Mapping[str, Sequence[Candidate]], names: Collection[str]) -> frozenset[str]:
    """One of these names and all others that it is not told apart from; none where its formula is within its bounds.

    A lag by a sixth of each change, say, is no delay, of which most lags, and may be creep: both are one function, and
    evidence does not know how large either is. `found` are the forms of each effect, fitted alone, so only one name is
    asked about.
    """
    if len(names) != 1 or not (own := _formulas(found.get(name := next(iter(names)), ()))):
        return frozenset()
    best = max(own, key=lambda c: c.score.gain)
    for forms in (filter(_is_bounded, own), _off_grid(own)):  # most are within as they stand, which is quick
        as_good = [one for one in forms if good_enough(one, best)]
        if any(map(_within, as_good)):
            return frozenset()
    if not as_good:
        return frozenset()
    others = {
        other
        for other, forms in found.items()
        if other != name
        and any(good_enough(one, best) and _within(one) for one in _off_grid(_formulas(forms)))
    }
    return frozenset({name, *others}) if others else frozenset()


def _formulas(forms: Sequence[Candidate]) -> list[Candidate]:
    return [c for c in forms if not is_family(c.variant.form)]


def _off_grid(formulas: Sequence[Candidate]) -> Iterator[Candidate]:
    """Of each form whose coefficients have bounds the best one, moved off the search's grid."""
    forms: dict[str, Candidate] = {}
    for one in sorted(formulas, key=lambda c: -c.score.gain):
        if _is_bounded(one):
            forms.setdefault(one.variant.form, one)
    for one in forms.values():
        regression = one.columns.regression
        yield refined(regression, regression.context, one.alone, 0).parts[0]


def _is_bounded(one: Candidate) -> bool:
    return all(term.kind in _BOUNDED for term in one.variant.terms)


def _within(one: Candidate) -> bool:
    return plausible(one.effect, one.variant, one.columns, one.score)
