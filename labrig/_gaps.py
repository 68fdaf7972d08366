"""What was not seen, from what is like it: a low-rank Gaussian model of a matrix with gaps."""

import numpy as np

from labrig.arrays import Floats

_MOST, _ROUNDS = 8, 20
"""Most directions that gaps are filled from, and how often these are found anew; numerical."""


def filled(values: Floats) -> Floats:
    """A matrix (n, K) whose NaN are what is expected there, given what was seen in the same row.

    Rows are few common directions, those that stand clear of the noise, and noise that is alike in all columns: found
    by expectation and maximisation (M. E. Tipping and C. M. Bishop, J. R. Stat. Soc. B 61 (1999) 611; with gaps A. Ilin
    and T. Raiko, J. Mach. Learn. Res. 11 (2010) 1957). Where no direction is clear of the noise gaps are zero, and of
    few rows or columns the mean of the column.
    """
    seen = np.isfinite(values)
    if seen.all():
        return values
    x, s = np.where(seen, values, 0.0), seen.astype(float)
    if min(values.shape) < 4:
        return np.where(seen, values, x.sum(axis=0) / np.maximum(s.sum(axis=0), 1.0))
    W, noise = _directions(x, s)
    if not W.shape[1]:
        return x
    for _ in range(_ROUNDS):
        mean, spread = _expected(x, s, W, noise)
        W, noise = _maximised(x, s, mean, spread, noise)
    return np.where(seen, values, _expected(x, s, W, noise)[0] @ W.T)


def _directions(x: Floats, s: Floats) -> tuple[Floats, float]:
    """Directions (K, k) that stand clear of the noise, and the noise's square, from what was seen together: `x` (n, K)
    is zero in gaps, `s` one where something was seen.
    """
    n, K = x.shape
    power, V = np.linalg.eigh(x.T @ x / np.maximum(s.T @ s, 1.0))
    some = power[K - min(n, K) :]  # of few rows all else is exactly none
    noise = max(float(np.median(some)) * min(1.0, n / K), 1e-6 * float(power[-1]))
    edge = 1.1 * (1 + np.sqrt(K / n)) ** 2
    k = min(_MOST, n // 3, K // 3, int((power > noise * edge).sum()))
    return V[:, K - k :] * np.sqrt(np.maximum(power[K - k :] - noise, 0.0)), noise


def _expected(x: Floats, s: Floats, W: Floats, noise: float) -> tuple[Floats, Floats]:
    """How far each row goes along the directions, (n, k), and the covariance of that, (n, k, k)."""
    k = W.shape[1]
    products = (W[:, :, None] * W[:, None]).reshape(len(W), k * k)
    precision = (s @ products).reshape(len(x), k, k) + noise * np.eye(k)
    inverse = np.asarray(np.linalg.inv(precision), dtype=float)
    return np.einsum("nab,nb->na", inverse, x @ W), noise * inverse


def _maximised(x: Floats, s: Floats, mean: Floats, spread: Floats, was: float) -> tuple[Floats, float]:
    """The directions and the noise's square that are likeliest, given how far the rows go."""
    k, K = mean.shape[1], x.shape[1]
    square = (mean[:, :, None] * mean[:, None] + spread).reshape(len(x), k * k)
    gram = (s.T @ square).reshape(K, k, k)
    ridge = 1e-9 * np.trace(gram, axis1=1, axis2=2) + 1e-300
    W = np.linalg.solve(gram + ridge[:, None, None] * np.eye(k), (x.T @ mean)[:, :, None])[:, :, 0]
    left = float((s * (x - mean @ W.T) ** 2).sum())
    left += float((s @ (W[:, :, None] * W[:, None]).reshape(K, k * k) * spread.reshape(len(x), k * k)).sum())
    return np.asarray(W, dtype=float), max(left / max(float(s.sum()), 1.0), 1e-9 * was)
