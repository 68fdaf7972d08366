"""Warm starts of a solve: what the shapes that are already solved suggest."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats

_MODES = 64
_SMOOTHING = 1e-3
LEAST_SHAPES = 12
"""Shapes below which the nearest one is a better start than any interpolation."""


@dataclass(frozen=True)
class StartPredictor:
    """A smooth interpolation of states over pressures: cubic radial functions and a plane, of the states' modes.

    `places` (N, C) pressures over their maxima; `weight` (N + 1 + C, K); `modes` (K, D) and `mean` (D,) of states.
    """

    places: Floats
    weight: Floats
    modes: NDArray[np.float32]
    mean: NDArray[np.float32]

    @classmethod
    def fit(cls, places: Floats, states: NDArray[np.float32]) -> "StartPredictor":
        """From solved states (N, D) at `places` (N, C)."""
        mean = states.mean(axis=0)
        off = (states - mean).astype(float)
        value, vector = np.linalg.eigh(off @ off.T)
        keep = np.argsort(value)[::-1][: min(_MODES, len(places) - 1)]
        keep = keep[value[keep] > 1e-10 * max(value.max(), 1e-300)]
        size = np.sqrt(value[keep])
        modes = (vector[:, keep] / size).T @ off
        amplitude = vector[:, keep] * size
        n, plane = len(places), np.hstack([np.ones((len(places), 1)), places])
        kernel = _cube(places, places) + _SMOOTHING * np.eye(n)
        corner = -1e-8 * np.eye(plane.shape[1])
        matrix = np.block([[kernel, plane], [plane.T, corner]])
        right = np.vstack([amplitude, np.zeros((plane.shape[1], len(keep)))])
        weight = np.asarray(np.linalg.solve(matrix, right), dtype=float)
        return cls(places, weight, modes.astype(np.float32), mean)

    def __call__(self, place: Floats) -> Floats:
        """The state (D,) that is likely at a place (C,)."""
        near = np.concatenate([_cube(place[None], self.places)[0], [1.0], place])
        return self.mean.astype(float) + (near @ self.weight) @ self.modes


def nearest_state(place: Floats, places: list[Floats], states: list[Floats]) -> Floats | None:
    """The state at the nearest of the solved places, None if there is none."""
    if not places:
        return None
    return states[int(np.argmin(np.linalg.norm(np.array(places) - place, axis=1)))]


def _cube(a: Floats, b: Floats) -> Floats:
    square = (a * a).sum(1)[:, None] + (b * b).sum(1)[None] - 2.0 * a @ b.T
    return np.maximum(square, 0.0) ** 1.5
