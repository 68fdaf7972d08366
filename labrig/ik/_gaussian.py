"""Gaussian processes of the pressures and their derivatives, compiled: both from one pass over what was learned."""

from typing import Any

import numpy as np
from numba import njit

from labrig.arrays import Floats

NEGLIGIBLE_MM = 0.05
"""Modes that together move the control points by less than this, root mean square, are left out.

Pressures come out the same with half of it (0.14 kPa beside the true ones, shapes that can be reached).
"""


@njit(cache=True, fastmath=True)
def _bells(t, points, length, share, value, first, both):
    """Covariance of t (C,) with n points, and how it changes, relative to it.

    points (C, n) in the bent coordinate. Fills value (n,), first (C, n), the derivative by t_c, and both (C, n), its
    square plus the second derivative by t_c and the point's own. See `labrig.surrogate._kernel.Kernel.parts`.
    """
    value[:] = 1.0
    for c in range(len(t)):
        scale = 1.0 / (1.0 + share[c])
        over = 1.0 / length[c]
        for i in range(points.shape[1]):
            step = (t[c] - points[c, i]) * over
            bell = share[c] * np.exp(-0.5 * step * step)
            value[i] *= (1.0 + bell) * scale
            bell /= 1.0 + bell
            slope = -bell * step * over
            first[c, i] = slope
            both[c, i] = bell * (1.0 - step * step) * over * over + slope * slope


@njit(cache=True, fastmath=True)
def _sums(value, first, both, weights, mixed, out):
    """The process (row 0 of `out`) and its derivatives by the bent coordinates (rows 1 to C), (1 + C, K).

    weights (n, B, K): of the points' values (B = 1), and of their slopes (B = 1 + C). As the covariance of two slopes
    of different chambers is minus the product of what they have with values, each point needs 3 C products for a mode
    instead of (1 + C)^2. `mixed` (K,) is a place to work in.
    """
    n, blocks, K = weights.shape
    out[:] = 0.0
    for i in range(n):
        row = weights[i, 0]
        for k in range(K):
            mixed[k] = row[k]
        for b in range(1, blocks):
            factor, row = first[b - 1, i], weights[i, b]
            for k in range(K):
                mixed[k] -= factor * row[k]
        for k in range(K):
            mixed[k] *= value[i]
            out[0, k] += mixed[k]
        for c in range(len(first)):
            factor = first[c, i]
            if blocks > 1:
                own, row = value[i] * both[c, i], weights[i, 1 + c]
                for k in range(K):
                    out[1 + c, k] += factor * mixed[k] + own * row[k]
            else:
                for k in range(K):
                    out[1 + c, k] += factor * mixed[k]


class Process:
    """A process with a kernel (see `labrig.surrogate._kernel`) at fractions x: value (K,) and derivatives (C, K).

    points (n, C) fractions; weights (B n, K), B = 1, or 1 + C with slopes.
    """

    def __init__(self, kernel: Any, points: Floats, weights: Floats) -> None:
        self._kernel = kernel
        self._points = np.ascontiguousarray(kernel.bent(points).T)
        C, n = self._points.shape
        self._weights = np.ascontiguousarray(weights.reshape(-1, n, weights.shape[1]).transpose(1, 0, 2))
        self._length, self._share = (np.asarray(x, float) for x in (kernel.length, kernel.share))
        self._parts = np.empty(n), np.empty((C, n)), np.empty((C, n))
        self._mixed, self._out = np.empty(weights.shape[1]), np.empty((1 + C, weights.shape[1]))

    def __call__(self, x: Floats) -> tuple[Floats, Floats]:
        """Value (K,), and derivatives (C, K) by the fractions x (C,)."""
        kernel = self._kernel
        _bells(kernel.bent(x), self._points, self._length, self._share, *self._parts)
        _sums(*self._parts, self._weights, self._mixed, self._out)
        return self._out[0].copy(), self._out[1:] * kernel.slope(x)[:, None]


class CompiledGaussian:
    """`latent` of a forward model with a Gaussian head, corrected or not, for as many of its modes as matter."""

    def __init__(self, model: Any) -> None:
        head = model.head
        corrected = head.kind == "corrected"
        base = head.base if corrected else head
        size = base.scale**2
        if corrected:
            bent = head.kernel.bent(head.points)
            size = size + ((head.constant + head.kernel.covariance(bent, bent) @ head.weights) ** 2).mean(
                axis=0
            )
        energy = size * (np.asarray(model.modes_mm) ** 2).sum(axis=(1, 2, 3))
        left = np.sqrt(np.append(np.cumsum(energy[::-1])[::-1], 0.0) / model.spline.size)
        self.modes = max(1, int(np.argmax(left < NEGLIGIBLE_MM)))
        kept = slice(0, self.modes)
        self._base = Process(base.kernel, base.points, base.weights[:, kept] * base.scale[kept])
        self._offset, self._correction, self._gain = base.offset[kept], None, 1.0
        if corrected:
            self._offset = self._offset + head.constant[kept]
            self._correction = Process(head.kernel, head.points, head.weights[:, kept])
            self._gain = head.gain
        self._low, self._span = model.low_kpa, model.high_kpa - model.low_kpa

    def __call__(self, pressure_kpa: Floats) -> tuple[Floats, Floats]:
        """z (K,) and dz/dpressure (K, C) at pressures (C,), kPa."""
        x = (pressure_kpa - self._low) / self._span
        value, slope = self._base(x * self._gain)
        slope *= np.reshape(self._gain, (-1, 1))
        if self._correction is not None:
            more, steeper = self._correction(x)
            value, slope = value + more, slope + steeper
        return value + self._offset, (slope / self._span[:, None]).T


def compiles(model: Any) -> bool:
    """Whether a forward model's latent coordinates can be compiled."""
    head = getattr(model, "head", None)
    if getattr(head, "kind", "") == "corrected":
        head = head.base  # type: ignore[union-attr]
    return getattr(head, "kind", "") == "gaussian"
