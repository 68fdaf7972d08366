"""Formulas of two effects that are one function of what was measured: which of them it is the data do not say."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from labrig._text import listed
from labrig.arrays import Floats
from labrig.diagnosis._candidates import Candidate, plausible
from labrig.diagnosis._out_of_bounds import is_bounded
from labrig.diagnosis._parameters import off_grid
from labrig.effects import is_family

_APART = 3.0
"""Standard deviations, over all that was measured together, by which two formulas have to differ to be told apart: of a
test of one against the other (J. Neyman, E. S. Pearson, Phil. Trans. R. Soc. A 231 (1933) 289) one in fifteen errs."""
_NEAR = 0.1
"""Share of the square of the whole change by which two may differ to be compared off the search's grid; numerical."""


def same_as(found: Mapping[str, Sequence[Candidate]], names: Collection[str]) -> frozenset[str]:
    """The one effect that is sure, and those with a formula that says the same of everything that was measured.

    Evidence may prefer one of them by far, for it asks how narrow a family is that a formula lies in; what was measured
    has no part in that. None where several are sure, whose formulas are `found` alone, or where a family's weights are
    the best form.
    """
    if len(names) != 1:
        return frozenset()
    (name,) = names
    best = next(iter(found.get(name, ())), None)
    if best is None or is_family(best.variant.form):
        return frozenset()
    as_it_fits = [_change(best), _change(off_grid(best))]
    others = frozenset(
        other
        for other, forms in found.items()
        if other != name and any(_is_same(best, as_it_fits, one) for one in forms)
    )
    return others | {name} if others else others


def said_of_same(names: Collection[str]) -> list[str]:
    """A line on why none of the names is sure."""
    if not names:
        return []
    return [
        f"formulas of {listed(sorted(names))} say the same of all that was measured: which of them it is these data "
        "cannot tell, and what is known of the rig, or the next experiment, may"
    ]


def _is_same(best: Candidate, as_it_fits: Sequence[Floats], one: Candidate) -> bool:
    """Whether a formula changes the same as the `best` of another, each as it stands or moved to where it fits best, by
    values that are physical for it: a lag of the whole motion is a delay, and no creep. A free pattern of the sensors
    has no such bounds, and can stand for anything.
    """
    near = np.sqrt(_NEAR) * _apart(best, as_it_fits[0])
    if (
        is_family(one.variant.form)
        or not is_bounded(one)
        or _apart(best, as_it_fits[0] - _change(one)) > near
    ):
        return False
    others = [_change(o) for o in (one, off_grid(one)) if plausible(o.effect, o.variant, o.columns, o.score)]
    return any(_apart(best, own - other) < _APART for own in as_it_fits for other in others)


def _change(one: Candidate) -> Floats:
    """What a form, fitted to all blocks, changes, (S, K)."""
    return one.columns.field(one.score.beta)


def _apart(best: Candidate, change: Floats) -> float:
    """How many standard deviations a change (S, K) of all that was measured is."""
    return float(np.sqrt(best.columns.regression.square(change).sum()))
