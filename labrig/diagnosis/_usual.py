"""What is usual in a campaign, whatever it is: beside it single captures that are mistaken stand out."""

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.effects import Context, motion_scale
from labrig.model import robust_fit

_SMALL = 1e-3
"""Share of how chambers move the rig that keeps those of which little is seen from any pressure; numerical."""


def as_pressures(slopes: Floats, off: Floats, ridge: float) -> Floats | None:
    """How far each chamber's pressure (n, C) would have to change for what is `off` (n, K), by `slopes` (n, K, C) and
    least squares; a share `ridge` of the mean square of all slopes holds it small. None where nothing has a slope.
    """
    normal = np.einsum("nkc,nkd->ncd", slopes, slopes)
    if not normal.any():  # a base that says the same at all pressures
        return None
    normal += ridge * np.trace(normal.mean(axis=0)) * np.eye(normal.shape[1])
    return np.linalg.solve(normal, np.einsum("nkc,nk->nc", slopes, off)[:, :, None])[:, :, 0]


def usual(context: Context, first: Ints, off: Floats) -> Floats:
    """What each chamber does otherwise in most captures, (n, K), of how far these are off (n, K): by its pressure, by
    the one before, by the way it came.
    """
    rows = context.rows
    seen = np.asarray(np.isfinite(context.residual).any(axis=0))
    J = context.jacobian[first] * context.span / motion_scale(context)[:, None] * seen[:, None]
    change = as_pressures(J, off, _SMALL)
    if change is None:
        return np.zeros_like(off)
    event = rows.event[first]
    x, before, way = rows.fraction[first], context.previous[event] / context.span, context.direction[event]
    otherwise = np.zeros_like(change)
    for c in range(change.shape[1]):
        columns = np.column_stack(
            [np.ones(len(x)), x[:, c], x[:, c] ** 2, before[:, c], way[:, c], way[:, c] * x[:, c]]
        )
        otherwise[:, c] = columns @ robust_fit(columns, change[:, c], np.ones(len(x)))
    return np.einsum("nkc,nc->nk", J, otherwise)
