"""Captures that have each other's measurements: files that were renamed, rows of a table that changed places."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats, Ints
from labrig.diagnosis._listed import first_few
from labrig.diagnosis._usual import usual
from labrig.effects import Context, errors_by_capture, motion_scale

INTERCHANGED = "captures that have each other's measurements"
_NEARER = 3.0
"""How many times nearer two captures are to what the model says of each other than to what it says of themselves."""
_FAR = 4.0
"""How many times as far off as usual each of them is: where loops are as wide as a step, others are near as well."""
_MOST = 0.2
"""Share of the captures up to which they are single ones; of more it is the order of the table."""
_FEWEST, _MORE = 2, 3
"""Chambers, and how many more observables there must be: else some other capture is always near."""
_MOST_CAPTURES = 3000
"""Of more, nothing is asked: each would be compared with each."""


def without_interchanged(context: Context) -> tuple[Context, NDArray[np.bool_]]:
    """The campaign with a warning that names the captures which have each other's measurements, and the other rows
    (F,).
    """
    rows = context.rows
    captures, pairs = _pairs(context)
    if not len(pairs):
        return context, np.ones(len(rows.capture), dtype=bool)
    shown = first_few([f"{captures[i]} and {captures[j]}" for i, j in pairs])
    who = "captures" if len(pairs) == 1 else f"{len(pairs)} pairs of captures"
    line = f"{who} have each other's measurements ({shown}): left out; put them right"
    context = replace(context, rows=replace(rows, warnings=(*rows.warnings, line)))
    return context, ~np.isin(rows.capture, captures[pairs])


def _pairs(context: Context) -> tuple[Ints, Ints]:
    """The captures, and which two of them (p, 2), by place, have each other's measurements."""
    none = np.zeros((0, 2), dtype=np.int64)
    rows = context.rows
    first, K = rows.first, len(rows.unit)
    n = len(first)
    few = len(rows.chambers) < _FEWEST or len(rows.chambers) + _MORE > K
    if not context.moves or context.sample_s or n > _MOST_CAPTURES or few:
        return none[:, 0], none
    captures, error = errors_by_capture(context)
    scale = motion_scale(context)
    seen = np.asarray(np.isfinite(context.residual).any(axis=0))
    said, off = (np.where(seen, v / scale, 0.0) for v in (context.base[first], error))
    apart = _apart(said + off, said + usual(context, first, off))
    own, both = np.diag(apart), apart + apart.T
    far = own > _FAR**2 * np.median(own)
    pairs = np.argwhere(np.triu(np.outer(far, far) & (np.add.outer(own, own) > _NEARER**2 * both), 1))
    chosen: dict[int, int] = {}
    for i, j in pairs[np.argsort(both[pairs[:, 0], pairs[:, 1]])].tolist():  # the nearest first
        if not {i, j} & {*chosen, *chosen.values()}:
            chosen[i] = j
    if 2 * len(chosen) > _MOST * n:
        return none[:, 0], none
    return captures, np.array(sorted(chosen.items()), dtype=np.int64).reshape(-1, 2)


def _apart(a: Floats, b: Floats) -> Floats:
    """Squared distances (n, m) of rows (n, K) and (m, K)."""
    square = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2 * a @ b.T
    return np.maximum(square, 0.0)
