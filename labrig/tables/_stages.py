"""What was set beside the inputs, though nothing calls it so: a stage, a length, a weight's lever."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.tables import _names as names
from labrig.tables._held import is_noisy
from labrig.tables._inputs import find_held
from labrig.tables._names import Name
from labrig.tables._units import like

_LEVELS, _FEWEST = 5, 3
"""Different values from which on a column was set; fewer may be names of days or of specimens, but for so many that
have a unit and come again.
"""
_AGAIN = 2
"""How often each value is set, in the mean, where values come again."""
_FOLLOWS = 0.5
"""Share of its variance from which on a column follows the inputs, so that it was measured, and filled down."""
_TWICE = 0.999
"""The same share from which on what was set is said by another column as well, and does not just follow it."""
_Rows = NDArray[np.bool_]


def find_stages(rest: Sequence[Name], inputs: Sequence[Name], values: Mapping[str, Floats]) -> list[Name]:
    """The columns of `rest` that stand exactly still in holds, at many places that the inputs do not say, and jump only
    where a new hold may begin; none where nothing trembles, since everything may be written once a hold then.

    Where values come again, each of their jumps may begin a hold: a campaign sets each pressure at each place.
    """
    trembles = any(is_noisy(values[n.column]) for n in rest)
    if not trembles or not inputs or not find_held(list(inputs), values):
        return []
    u = np.column_stack([values[n.column] for n in inputs])
    begins = np.r_[True, (np.diff(u, axis=0) != 0).any(axis=1)]
    said = names.MEASURED | names.AMBIENT | names.TURNED | names.LOAD | names.SIDE | names.FORCE | _WEIGHTS
    able = [n for n in find_held(list(rest), values) if not n.has(said) and not _is_force(n)]
    found = [n for n in able if _is_set(n, values[n.column], begins)]
    found = [n for n in found if _explained(values[n.column], u, []) < _FOLLOWS]
    while found:
        own = [values[n.column] for n in found]
        share = [_explained(v, u, [w for w in own if w is not v]) for v in own]
        share = [part if part < _TWICE else 0.0 for part in share]
        if max(share) < _FOLLOWS:
            break
        del found[int(np.argmax(share))]
    return found


_WEIGHTS = {"mass", "weight", "temperature", "temp"}


def _is_set(n: Name, own: Floats, begins: _Rows) -> bool:
    """Whether a column (n,) jumps from place to place only where a hold begins, by the inputs or by itself."""
    jumps = np.r_[False, np.diff(own) != 0]
    levels = len(np.unique(own[np.isfinite(own)]))
    again = int(jumps.sum()) + 1 >= _AGAIN * levels
    if levels < (_FEWEST if again and n.unit is not None else _LEVELS):
        return False
    return (again or not (jumps & ~begins).any()) and parts_holds(jumps, begins)


def _is_force(n: Name) -> bool:
    return n.unit is not None and (like(n.unit, "N") or like(n.unit, "N*m"))


def parts_holds(jumps: _Rows, begins: _Rows) -> bool:
    """Whether the jumps of a column within what the inputs hold leave holds of the usual length: a sensor's do not."""
    starts = np.flatnonzero(begins | jumps)
    length = np.diff(np.r_[starts, len(begins)])
    inside = (jumps & ~begins)[starts]
    beside = inside | np.r_[inside[1:], False]
    return not beside.any() or bool(length[beside].min() > np.median(length) / 2)


def _explained(own: Floats, u: Floats, others: Sequence[Floats]) -> float:
    """The share of the variance of a column (n,) that a parabola of the inputs (n, C) and of others (n,) takes."""
    u = np.column_stack([u, *others])
    known = np.isfinite(u).all(axis=1) & np.isfinite(own)
    x = np.column_stack([np.ones(known.sum()), u[known], u[known] ** 2])
    y = own[known] - own[known].mean()
    left = y - x @ np.linalg.lstsq(x, y, rcond=None)[0]
    return 1.0 - float((left**2).sum()) / max(float((y**2).sum()), 1e-300)
