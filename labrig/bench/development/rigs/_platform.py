"""A stiff plate on three to six bellows, seen by the markers on it."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, markers


class Platform(Rig):
    """A rigid plate lies on its bellows as their least-squares plane; bellows are nearly linear, or a little soft.

    More than three bellows work against each other: only the best plane through their ends shows.
    """

    kind = "platform"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(3, 7))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(40, 120) * random.uniform(0.9, 1.1, count)
        self.marker_names, self.observables = markers(int(random.integers(5, 10)))
        self.noise = float(random.uniform(0.05, 0.1))
        radius_mm = random.uniform(35, 70)
        around = random.uniform(0, 2 * np.pi) + np.arange(count) * 2 * np.pi / count
        around += random.normal(0, 0.06, count)
        foot = radius_mm * random.uniform(0.9, 1.1, count)[:, None] * _circle(around)
        self._plane = np.linalg.pinv(np.column_stack([np.ones(count), foot]))  # (3, C): height, slopes
        self._stroke_mm = random.uniform(16, 32) * random.uniform(0.85, 1.15, count)
        self._soft = random.uniform(0.1, 1.1, count)
        self._aside = random.normal(0, 0.05, (count, 2))  # bellows that lean as they grow
        spots = len(self.marker_names)
        side = random.uniform(0, 2 * np.pi) + np.arange(spots) * np.deg2rad(137)
        out_mm = radius_mm * np.sqrt(np.linspace(0.15, 1.5, spots))
        self._spot_mm = np.column_stack([out_mm[:, None] * _circle(side), random.uniform(3, 12, spots)])
        self._up_mm = random.uniform(40, 60)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(spots, 3)

    def deflection(self, kpa: Floats) -> Floats:
        load = np.clip(kpa / self.high_kpa, -20.0, 20.0)
        return np.sinh(self._soft * load) / np.sinh(self._soft)

    def shape(self, deflection: Floats) -> Floats:
        stroke = deflection * self._stroke_mm
        height, slope_x, slope_y = (stroke @ self._plane.T).T
        steep = np.hypot(slope_x, slope_y)
        normal = np.stack([-slope_x, -slope_y, np.ones_like(steep)], axis=1) / np.hypot(1, steep)[:, None]
        turn = _tilt(normal)
        middle = np.column_stack([stroke @ self._aside, self._up_mm + height])
        points = middle[:, None] + np.einsum("txy,my->tmx", turn, self._spot_mm)
        return points.reshape(len(deflection), -1)


def _circle(angle: Floats) -> Floats:
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _tilt(normal: Floats) -> Floats:
    """The smallest rotations (T, 3, 3) that turn the z-axis into normals (T, 3) that point upwards."""
    x, y, z = normal.T
    share = 1 / (1 + z)
    rows = [
        [1 - share * x * x, -share * x * y, x],
        [-share * x * y, 1 - share * y * y, y],
        [-x, -y, z],
    ]
    return np.stack([np.stack(row, axis=1) for row in rows], axis=1)
