"""A Gaussian process from chamber pressures to the modes of a shape, from values and, where known, slopes."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular
from scipy.linalg.lapack import dpotrf, dpotri, dpotrs  # pyright: ignore[reportAttributeAccessIssue]

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.surrogate._kernel import Kernel
from labrig.surrogate._likelihood import fit_kernel

_LEADING = 24
"""Modes that decide on the kernel's parameters; the others are as good with the same ones."""
_NUGGET = 1e-8
_SLOPE_NOISE = 1e-4
"""Variance of a simulated slope per length squared, relative to the values': solvers stop before they are exact."""


@dataclass(frozen=True)
class GaussianHead:
    """Latent coordinates z (K) of fractions x (C) of the range.

    `points` (n, C) where something is known; `weights` (R, K), R = n, or n (1 + C) with slopes; `offset`, `scale`
    (K,); `noise` relative to the kernel.
    """

    kind = "gaussian"

    kernel: Kernel
    noise: float
    points: Floats
    weights: Floats
    offset: Floats
    scale: Floats

    @property
    def has_slopes(self) -> bool:
        """Whether slopes were learned from as well."""
        return len(self.weights) > len(self.points)

    def latent(self, x: Floats) -> Floats:
        """z (F, K) at fractions x (F, C)."""
        t = self.kernel.bent(x)
        if self.has_slopes:
            value, first, _ = self.kernel.parts(t, self._bent)
            row = (
                np.concatenate([value[None], -value * first])
                .transpose(1, 0, 2)
                .reshape(len(x), len(self.weights))
            )
        else:
            row = self.kernel.covariance(t, self._bent)
        return row @ self.weights * self.scale + self.offset

    def slopes(self, x: Floats) -> Floats:
        """dz/dx (F, K, C) at fractions x (F, C)."""
        t, n = self.kernel.bent(x), len(self.points)
        by_t = np.empty((*x.shape, len(self.scale)))
        for f in range(len(x)):
            if self.has_slopes:
                rows = self.kernel.with_slopes(t[f : f + 1], self._bent)[1:]
            else:
                value, first, _ = self.kernel.parts(t[f : f + 1], self._bent)
                rows = (value * first).reshape(-1, n)
            by_t[f] = rows @ self.weights
        return (by_t * self.kernel.slope(x)[:, :, None] * self.scale).transpose(0, 2, 1)

    def doubt(self, x: Floats) -> Floats:
        """Standard deviation (F,) at fractions x, as a share of what was there before anything was known.

        From the values alone: slopes make it smaller by a factor that the calibration of the sizes takes in.
        """
        cross = self.kernel.covariance(self._bent, self.kernel.bent(x))
        known = solve_triangular(self._factor, cross, lower=True, check_finite=False)
        return np.sqrt(np.maximum(1.0 + self.noise - (known * known).sum(axis=0), self.noise + _NUGGET))

    def left_out_doubt(self) -> Floats:
        """The doubt (n,) at each of the points, were it not known itself."""
        inverse, _ = dpotri(np.asfortranarray(self._factor), lower=1)
        return 1.0 / np.sqrt(np.diagonal(inverse))

    @cached_property
    def _bent(self) -> Floats:
        return self.kernel.bent(self.points)

    @cached_property
    def _factor(self) -> Floats:
        matrix = self.kernel.covariance(self._bent, self._bent)
        matrix[np.diag_indices(len(matrix))] += self.noise + _NUGGET
        return np.asarray(np.linalg.cholesky(matrix), np.float64)


def fit_gaussian(
    x: Floats, values: Floats, slopes: Floats | None = None, iterations: int = 30
) -> tuple[GaussianHead, Floats]:
    """Learn from values (n, K) and slopes (n, K, C), if any, at fractions x (n, C).

    Returns the head, and what each value is off when its own point is left out (n, K): exact for the kernel that
    all points chose.
    """
    offset, scale = values.mean(axis=0), np.maximum(values.std(axis=0), 1e-12)
    normal = (values - offset) / scale
    kernel, noise = fit_kernel(x, normal[:, :_LEADING], iterations)
    t, (n, C) = kernel.bent(x), x.shape
    if slopes is None:
        matrix = kernel.covariance(t, t)
        known = normal
        nugget = np.full(n, noise + _NUGGET)
    else:
        matrix = kernel.with_slopes(t, t)
        by_t = slopes.transpose(2, 0, 1) / kernel.slope(x).T[:, :, None] / scale
        known = np.concatenate([normal, by_t.reshape(n * C, -1)])
        nugget = np.concatenate(
            [np.full(n, noise + _NUGGET), np.repeat(noise + _SLOPE_NOISE / kernel.length**2, n)]
        )
    matrix = matrix.T  # symmetric, and so in the order that LAPACK works in place on
    matrix[np.diag_indices(len(matrix))] += nugget
    factor, failed = dpotrf(matrix, lower=1, overwrite_a=1)
    if failed:
        raise LabrigError(
            "forward: the simulations repeat the same pressures with other shapes; simulate again"
        )
    weights, _ = dpotrs(factor, known, lower=1)
    head = GaussianHead(kernel, noise, x.copy(), np.ascontiguousarray(weights), offset, scale)
    return head, _left_out(factor, weights, n) * scale


def _left_out(factor: Floats, weights: Floats, n: int) -> Floats:
    """Errors (n, K) of each point's values when all that is known at the point is left out."""
    blocks = len(weights) // n
    inverse, _ = dpotri(factor, lower=1, overwrite_c=1)
    rows = np.arange(blocks) * n
    errors = np.empty((n, weights.shape[1]))
    for i in range(n):
        own = inverse[np.ix_(rows + i, rows + i)]
        own = np.tril(own) + np.tril(own, -1).T
        errors[i] = np.linalg.solve(own, weights[rows + i])[0]
    return errors
