"""The latent coordinates of a Gaussian forward model and their derivatives, compiled: both from one pass."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]

NEGLIGIBLE_MM = 0.025
"""Modes that together move the control points by less than this, root mean square, are left out."""


@njit(cache=True, fastmath=True)
def _rows(t, points, length, share, slopes, out):
    """Covariance of the value (row 0) and of the slopes (rows 1 to C) at t (C,) with what is known.

    points (C, n) in the bent coordinate; columns of `out`: n values, then, with `slopes`, n slopes by each coordinate.
    See `labrig.surrogate._kernel.Kernel.with_slopes`.
    """
    C, n = points.shape
    first = np.empty((C, n))
    second = np.empty((C, n))
    value = np.ones(n)
    for c in range(C):
        scale = 1.0 / (1.0 + share[c])
        over = 1.0 / length[c]
        for i in range(n):
            step = (t[c] - points[c, i]) * over
            bell = share[c] * np.exp(-0.5 * step * step)
            value[i] *= (1.0 + bell) * scale
            bell /= 1.0 + bell
            first[c, i] = -bell * step * over
            second[c, i] = bell * (1.0 - step * step) * over * over
    for i in range(n):
        out[0, i] = value[i]
    for c in range(C):
        for i in range(n):
            out[1 + c, i] = value[i] * first[c, i]
        if slopes:
            for i in range(n):
                out[0, (1 + c) * n + i] = -value[i] * first[c, i]
            for d in range(C):
                if c == d:
                    for i in range(n):
                        out[1 + c, (1 + d) * n + i] = value[i] * second[c, i]
                else:
                    for i in range(n):
                        out[1 + c, (1 + d) * n + i] = -value[i] * first[c, i] * first[d, i]


class CompiledGaussian:
    """`latent` of a forward model with a Gaussian head, for as many of its modes as matter."""

    def __init__(self, model: Any) -> None:
        head = model.head
        energy = head.scale**2 * (np.asarray(model.modes_mm) ** 2).sum(axis=(1, 2, 3))
        left = np.sqrt(np.append(np.cumsum(energy[::-1])[::-1], 0.0) / model.spline.size)
        self.modes = max(1, int(np.argmax(left < NEGLIGIBLE_MM)))
        kept = slice(0, self.modes)
        self._kernel = head.kernel
        self._points = np.ascontiguousarray(head.kernel.bent(head.points).T)
        self._weights = np.ascontiguousarray(head.weights[:, kept])
        self._slopes = bool(head.has_slopes)
        self._scale, self._offset = head.scale[kept], head.offset[kept]
        self._low, self._span = model.low_kpa, model.high_kpa - model.low_kpa
        self._out = np.empty((1 + len(self._span), len(self._weights)))

    def __call__(self, pressure_kpa: Floats) -> tuple[Floats, Floats]:
        """z (K,) and dz/dpressure (K, C) at pressures (C,), kPa."""
        x = (pressure_kpa - self._low) / self._span
        kernel = self._kernel
        _rows(kernel.bent(x), self._points, kernel.length, kernel.share, self._slopes, self._out)
        both = self._out @ self._weights * self._scale
        by_pressure = both[1:] * (kernel.slope(x) / self._span)[:, None]
        return both[0] + self._offset, by_pressure.T
