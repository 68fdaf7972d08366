"""A flat skin on a backing plate, blown up in one to six fields."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, markers


class Plate(Rig):
    """Bumps of clamped fields with a logarithmic curve; below zero the skin lies on its backing and does nothing."""

    kind = "plate"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(1, 7))
        across = 1 if count == 1 else 2
        along = -(-count // across)
        side_mm = random.uniform(45, 70)
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(20, 50) * random.uniform(0.9, 1.1, count)
        rows = int(random.integers(3, 5))
        self.marker_names, self.observables = markers(rows * int(random.integers(3, 5)))
        self.noise = float(random.uniform(0.06, 0.12))
        per_row = len(self.marker_names) // rows
        size = side_mm * np.array([along, across])
        x, y = np.meshgrid(
            (np.arange(rows) + 0.5) / rows, (np.arange(per_row) + 0.5) / per_row, indexing="ij"
        )
        flat = np.column_stack([x.ravel(), y.ravel()]) * size
        flat += random.normal(0, 0.04 * side_mm, flat.shape)
        self.rest_mm = np.column_stack([flat, np.zeros(len(flat))])
        centre = side_mm * np.array([[c // across + 0.5, c % across + 0.5] for c in range(count)])
        reach_mm = side_mm * random.uniform(0.75, 0.95, (count, 2))
        share = (flat[:, None] - centre) / reach_mm  # (M, C, 2)
        inside = np.abs(share) < 1
        bump = np.where(inside, 0.5 + 0.5 * np.cos(np.pi * share), 0.0)
        tilt = np.where(inside, -0.5 * np.pi / reach_mm * np.sin(np.pi * share), 0.0)
        self._height_mm = random.uniform(10, 22, count)
        self._bump = bump.prod(axis=2) * self._height_mm  # (M, C)
        self._slope = tilt * bump[..., ::-1] * self._height_mm[:, None]  # (M, C, 2)
        self._foreshorten = random.uniform(0.3, 0.7)
        self._bend = random.uniform(0.6, 4.0, count)

    def deflection(self, kpa: Floats) -> Floats:
        load = np.maximum(kpa / self.high_kpa, 0.0)
        return np.log1p(self._bend * load) / np.log1p(self._bend)

    def shape(self, deflection: Floats) -> Floats:
        assert self.rest_mm is not None
        height = deflection @ self._bump.T
        slope = np.tensordot(deflection, self._slope, axes=(1, 1))  # (T, M, 2)
        aside = -self._foreshorten * height[..., None] * slope
        moved = np.concatenate([aside, height[..., None]], axis=2)
        return (self.rest_mm + moved).reshape(len(deflection), -1)
