"""What was set beside the inputs, though nothing calls it so: a stage, a length, a weight's lever."""

from collections.abc import Mapping, Sequence

import numpy as np

from labrig.arrays import Floats
from labrig.tables import _names as names
from labrig.tables._inputs import find_held, is_noisy
from labrig.tables._names import Name

_LEVELS = 5
"""Different values from which on a column was set; fewer may be names of days or of specimens."""
_FOLLOWS = 0.5
"""Share of its variance from which on a column follows the inputs, so that it was measured, and filled down."""


def find_stages(rest: Sequence[Name], inputs: Sequence[Name], values: Mapping[str, Floats]) -> list[Name]:
    """The columns of `rest` that stand exactly still in holds, at many places that the inputs do not say, and jump only
    where a new hold may begin; none where nothing trembles, since everything may be written once a hold then.
    """
    trembles = any(is_noisy(values[n.column]) for n in rest)
    if not trembles or not inputs or not find_held(list(inputs), values):
        return []
    u = np.column_stack([values[n.column] for n in inputs])
    begins = np.r_[False, (np.diff(u, axis=0) != 0).any(axis=1)]
    said = names.MEASURED | names.AMBIENT | names.TURNED | names.LOAD | names.SIDE | names.FORCE | _WEIGHTS
    out = []
    for n in find_held(list(rest), values):
        own = values[n.column]
        jumps = np.r_[False, np.diff(own) != 0]
        if n.has(said) or len(np.unique(own[np.isfinite(own)])) < _LEVELS or (jumps & ~begins).any():
            continue
        if not _follow(own, u):
            out.append(n)
    return out


_WEIGHTS = {"mass", "weight", "temperature", "temp"}


def _follow(own: Floats, u: Floats) -> bool:
    """Whether a column (n,) is a parabola of the inputs (n, C), mostly."""
    known = np.isfinite(u).all(axis=1) & np.isfinite(own)
    x = np.column_stack([np.ones(known.sum()), u[known], u[known] ** 2])
    y = own[known] - own[known].mean()
    left = y - x @ np.linalg.lstsq(x, y, rcond=None)[0]
    return bool((left**2).sum() < (1 - _FOLLOWS) * (y**2).sum())
