"""Least squares that a few wild values do not spoil."""

import numpy as np

from labrig.arrays import Floats

_ROUNDS = 5


def robust_fit(X: Floats, y: Floats, weight: Floats) -> Floats:
    """Coefficients (D,) of columns (n, D) for values (n,), NaN left out, what is far off counting less and less.

    Huber's psi, five rounds; `weight` (n,) multiplies residuals.
    """
    seen = np.isfinite(y)
    if not seen.any():
        return np.zeros(X.shape[1])
    X, y, w = X[seen], y[seen], weight[seen]
    beta = np.linalg.lstsq(X * w[:, None], y * w, rcond=1e-10)[0]
    for _ in range(_ROUNDS):
        off = np.abs(y - X @ beta)
        scale = 1.4826 * np.median(off)
        if scale <= 0:
            break
        r = w * np.sqrt(np.minimum(1.0, 3.0 * scale / np.maximum(off, 1e-300)))
        beta = np.linalg.lstsq(X * r[:, None], y * r, rcond=1e-10)[0]
    return np.asarray(beta, dtype=float)
