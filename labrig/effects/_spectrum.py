"""The bulk of a singular spectrum: how large the noise of a matrix is when its signal has low rank."""

from functools import lru_cache

import numpy as np

from labrig._gaps import filled
from labrig.arrays import Floats

_BULK = 0.3
"""Quantile of the singular values at which the noise is read off."""


@lru_cache(maxsize=64)
def _bulk_quantile(ratio: float, quantile: float) -> float:
    """Quantile of the Marchenko-Pastur law of singular values, unit noise, scaled by sqrt(longer side).

    Marchenko and Pastur, Math. USSR-Sbornik 1 (1967) 457; used as in Gavish and Donoho, IEEE Trans. Inf.
    Theory 60 (2014) 5040, there at the median.
    """
    low, high = (1 - np.sqrt(ratio)) ** 2, (1 + np.sqrt(ratio)) ** 2
    x = np.linspace(low, high, 20001)[1:-1]
    density = np.sqrt((high - x) * (x - low)) / x
    total = np.cumsum(density)
    return float(np.sqrt(np.interp(quantile, total / total[-1], x)))


def bulk_noise(matrix: Floats, lost: int = 0) -> float:
    """Standard deviation of the noise in `matrix` (n, K), NaN where nothing was seen.

    The signal may fill the larger singular values; the smaller ones are noise alone. `lost` is how many
    degrees of freedom a fit has taken from the rows. Rows and columns of which nothing was seen do not count. Returns
    NaN for matrices too small to tell.
    """
    seen = np.isfinite(matrix)
    matrix = matrix[np.ix_(seen.any(axis=1), seen.any(axis=0))]
    n, K = matrix.shape
    rows = n - lost
    short, long = min(rows, K), max(rows, K)
    if short < 6:
        return float("nan")
    s = np.sort(np.linalg.svd(filled(matrix), compute_uv=False)[:short])
    at = _BULK * (short - 1)
    value = float(np.interp(at, np.arange(short), s))
    missing = 1 - np.isfinite(matrix).mean()
    return value / (np.sqrt(long) * _bulk_quantile(round(short / long, 3), _BULK)) / np.sqrt(1 - missing)


def bulk_edge(n: int, K: int) -> float:
    """Largest singular value that pure noise of unit size makes in an (n, K) matrix, nearly always."""
    return np.sqrt(n) + np.sqrt(K) + 2.0
