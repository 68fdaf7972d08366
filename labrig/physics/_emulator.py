"""A quick stand-in for a shell's markers: a Gaussian process on solved shapes and their slopes.

It lies a few tenths of a millimetre off and costs microseconds; where more is needed, a shape is solved.
"""

from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats

_LENGTH = 1.6
"""Correlation length, in ranges of a chamber."""
_VALUE_NOISE, _SLOPE_NOISE = 1e-4, 1e-3
_ROWS = 512


@dataclass(frozen=True)
class Emulator:
    """Points (K,) as a smooth function of places (C,), both dimensionless or mm.

    `places` (N, C) are those that were solved; `weight` (N * (1 + C), K); `mean` (K,).
    """

    places: Floats
    weight: Floats
    mean: Floats

    @classmethod
    def fit(cls, places: Floats, values: Floats, slopes: Floats) -> "Emulator":
        """From values (N, K) and slopes (N, K, C) at `places` (N, C)."""
        n, chambers = places.shape
        kernel = np.empty((n, 1 + chambers, n, 1 + chambers))
        near, pull = _near(places, places)
        kernel[:, 0, :, 0] = near
        kernel[:, 0, :, 1:] = near[..., None] * pull
        kernel[:, 1:, :, 0] = -(near[..., None] * pull).transpose(0, 2, 1)
        bent = np.eye(chambers) / _LENGTH**2 - pull[..., :, None] * pull[..., None, :]
        kernel[:, 1:, :, 1:] = (near[..., None, None] * bent).transpose(0, 2, 1, 3)
        size = n * (1 + chambers)
        matrix = kernel.reshape(size, size)
        noise = np.full((n, 1 + chambers), _SLOPE_NOISE / _LENGTH**2)
        noise[:, 0] = _VALUE_NOISE
        matrix[np.diag_indices(size)] += noise.ravel()
        mean = values.mean(axis=0)
        right = np.concatenate([(values - mean)[:, None], slopes.transpose(0, 2, 1)], axis=1)
        weight = np.linalg.solve(matrix, right.reshape(size, -1))
        return cls(places, np.asarray(weight, dtype=float), mean)

    def __call__(self, places: Floats) -> Floats:
        """Points (F, K) at places (F, C)."""
        parts = [self._some(places[k : k + _ROWS]) for k in range(0, len(places), _ROWS)]
        return np.concatenate(parts) if parts else np.empty((0, len(self.mean)))

    def _some(self, places: Floats) -> Floats:
        near, pull = _near(places, self.places)
        basis = np.concatenate([near[..., None], near[..., None] * pull], axis=2)
        return self.mean + basis.reshape(len(places), -1) @ self.weight


def _near(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """Correlation (n, m) of two sets of places, and its logarithm's slope by those of the second (n, m, C)."""
    apart = (a[:, None] - b[None]) / _LENGTH
    return np.exp(-0.5 * (apart**2).sum(-1)), apart / _LENGTH
