"""What a learned map is off by, about as much as what it was learnt from was noisy: smooth in the set-points.

Every map that was fitted to measurements has it, so it is there in every explanation, as noise is, and has no name.
"""

import numpy as np
from scipy.spatial.distance import cdist

from labrig.arrays import Floats
from labrig.effects import Context, Space

RIPPLE = Space("ripple", "ripple", ())
RIPPLE_FLOORS = 1.0
"""How large it is, prior sd, in the noise of a capture's mean: a map of as many numbers as it was learnt from captures
errs by as much as one of these does.
"""
_WIDTHS = (0.25, 0.7)
"""How far along the range a bump reaches: a grid, half of it each."""
_MOST = 200
"""Set-points that it is laid out on at most; numerical."""
_KEPT = 0.98
"""Share of it that is kept; numerical."""


def ripple(context: Context) -> Floats:
    """Functions (F, q) of the set-points whose sum of squares is one, a Gaussian process' in its main directions (C. E.
    Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press 2006, section 8.1).
    """
    x = context.rows.fraction
    where = np.unique(np.round(x, 4), axis=0)
    where = where[np.unique(np.linspace(0, len(where) - 1, min(len(where), _MOST)).astype(int))]
    power, turn = np.linalg.eigh(_kernel(where, where))
    order = np.argsort(-power)
    few = order[: int(np.searchsorted(np.cumsum(power[order]), _KEPT * power.sum())) + 1]
    few = few[: max(1, context.rows.n_captures // 3)]
    return _kernel(x, where) @ turn[:, few] / np.sqrt(power[few])


def _kernel(a: Floats, b: Floats) -> Floats:
    """Gaussian kernels of all widths, their mean, (len(a), len(b))."""
    square = cdist(a, b, "sqeuclidean") / a.shape[1]
    return np.mean([np.exp(-0.5 * square / width**2) for width in _WIDTHS], axis=0)
