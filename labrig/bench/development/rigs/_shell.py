"""A free-form shell with nine chambers under its skin and 34 markers on it, like a part of a mannequin."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, cubic_membrane, markers

_COUNT = 34


class Shell(Rig):
    """Smooth overlapping patches that move along the normal and aside; their slopes foreshorten each other."""

    kind = "shell"

    def __init__(self, random: np.random.Generator) -> None:
        self.chambers = chambers(9)
        self.high_kpa = random.uniform(35, 75) * random.uniform(0.85, 1.15, 9)
        self.marker_names, self.observables = markers(_COUNT)
        self.noise = float(random.uniform(0.07, 0.14))
        self._axes_mm = np.array([random.uniform(80, 110), random.uniform(55, 80), random.uniform(110, 150)])
        angles = random.uniform(0, 2 * np.pi) + np.arange(_COUNT) * np.pi * (3 - np.sqrt(5))
        distance = np.sqrt((np.arange(_COUNT) + 0.5) / _COUNT)
        flat = 0.85 * distance[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        self.rest_mm, self._normal = self._on_shell(flat + random.normal(0, 0.02, flat.shape))
        grid = np.stack(np.meshgrid([-0.5, 0, 0.5], [-0.5, 0, 0.5]), axis=-1).reshape(9, 2)
        centre, _ = self._on_shell(grid + random.normal(0, 0.06, grid.shape))
        away_mm = self._tangent(self.rest_mm[:, None] - centre[None])  # (M, 9, 3)
        width_mm = random.uniform(28, 45, 9)
        height_mm = random.uniform(15, 28, 9) * np.exp(-0.5 * np.sum(away_mm**2, axis=2) / width_mm**2)
        aside = random.uniform(0.1, 0.35, 9) / width_mm
        self._height_mm = height_mm.T  # (9, M)
        self._slope = _flat(-(height_mm / width_mm**2)[..., None] * away_mm)
        self._aside_mm = _flat((height_mm * aside)[..., None] * away_mm)
        self._foreshorten = random.uniform(0.3, 0.8)
        self._cubic = random.uniform(0.2, 0.65, 9)

    def _on_shell(self, flat: Floats) -> tuple[Floats, Floats]:
        """Points (N, 3) and normals on the ellipsoid above places (N, 2) of its shadow."""
        up = np.sqrt(np.maximum(1.0 - np.sum(flat**2, axis=1), 0.05))
        unit = np.column_stack([flat[:, 0], flat[:, 1], up])
        axes = self._axes_mm[[0, 2, 1]]
        normal = unit / axes
        return unit * axes, normal / np.linalg.norm(normal, axis=1, keepdims=True)

    def _tangent(self, vectors: Floats) -> Floats:
        """Vectors (M, C, 3) at the markers without their part along the normal."""
        along = np.einsum("mcx,mx->mc", vectors, self._normal)
        return vectors - along[..., None] * self._normal[:, None]

    def deflection(self, kpa: Floats) -> Floats:
        return cubic_membrane(kpa / self.high_kpa, self._cubic)

    def shape(self, deflection: Floats) -> Floats:
        assert self.rest_mm is not None
        height = (deflection @ self._height_mm)[..., None]
        slope, aside_mm = (
            (deflection @ each).reshape(len(deflection), -1, 3) for each in (self._slope, self._aside_mm)
        )
        moved = aside_mm + height * (self._normal - self._foreshorten * slope)
        return (self.rest_mm + moved).reshape(len(deflection), -1)


def _flat(vectors: Floats) -> Floats:
    """Vectors (M, 9, 3) as rows (9, 3 M), by which deflections (T, 9) can be multiplied."""
    return vectors.swapaxes(0, 1).reshape(vectors.shape[1], -1)
