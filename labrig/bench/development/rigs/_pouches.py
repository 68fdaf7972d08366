"""A sheet on an array of eight to twelve sealed pouches, with many markers on it."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, markers


class Pouches(Rig):
    """Pouches that do not stretch (R. Niiyama et al., Soft Robotics 2, 2015): out at once, then hardly any further.

    The sheet on top bridges the gaps between them, so that each marker rides on two to six pouches.
    """

    kind = "pouches"

    def __init__(self, random: np.random.Generator) -> None:
        across = int(random.integers(2, 4))
        along = int(random.integers(4, 7)) if across == 2 else int(random.integers(3, 5))
        count = max(across * along, 8)
        along = count // across
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(15, 35) * random.uniform(0.92, 1.08, count)
        pitch_mm = random.uniform(22, 34)
        size = pitch_mm * np.array([along, across])
        centre = pitch_mm * np.array([[c // across + 0.5, c % across + 0.5] for c in range(count)])
        centre = centre - size / 2
        flat = _spread(int(random.integers(24, 41)), size, random)
        self.marker_names, self.observables = markers(len(flat))
        self.noise = float(random.uniform(0.04, 0.08))
        self.rest_mm = np.column_stack([flat, random.normal(0, 0.5, len(flat))])
        away = flat[:, None] - centre
        width_mm = pitch_mm * random.uniform(0.55, 0.9)
        bump = np.exp(-0.5 * np.sum(away**2, axis=2) / width_mm**2)  # (M, C)
        rise_mm = random.uniform(5, 10) * random.uniform(0.9, 1.1, count)
        self._lift_mm = (bump * rise_mm).T
        slope = -bump[..., None] * away / width_mm**2 * rise_mm[:, None]
        self._slope = slope.swapaxes(0, 1).reshape(count, -1)  # (C, 2 M)
        self._thick_mm = random.uniform(1.5, 4.0)
        self._pull = random.uniform(0.1, 0.35)
        self._inward = flat / (0.5 * np.linalg.norm(size))
        self._early = random.uniform(1.0, 2.2, count)

    def deflection(self, kpa: Floats) -> Floats:
        return np.tanh(self._early * kpa / self.high_kpa) / np.tanh(self._early)

    def shape(self, deflection: Floats) -> Floats:
        assert self.rest_mm is not None
        height = deflection @ self._lift_mm
        slope = (deflection @ self._slope).reshape(len(deflection), -1, 2)
        steep = 0.5 * np.mean(np.sum(slope**2, axis=2), axis=1)  # what the sheet takes up, as a share
        length_mm = np.linalg.norm(self.rest_mm[:, :2], axis=1).max()
        drawn = -self._pull * (steep * length_mm)[:, None, None] * self._inward
        aside = -self._thick_mm * slope / np.sqrt(1 + np.sum(slope**2, axis=2, keepdims=True)) + drawn
        moved = np.concatenate([aside, height[..., None]], axis=2)
        return (self.rest_mm + moved).reshape(len(deflection), -1)


def _spread(count: int, size: Floats, random: np.random.Generator) -> Floats:
    """Places (M, 2), evenly spread over a rectangle around zero, each a little off."""
    turn = (np.arange(count) * (np.sqrt(5) - 1) / 2) % 1.0
    places = np.column_stack([(np.arange(count) + 0.5) / count, turn]) - 0.5
    return places * size * 0.95 + random.normal(0, 0.02 * size.min(), places.shape)
