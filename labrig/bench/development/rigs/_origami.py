"""A folded strip: rigid panels that pouches in their creases unfold, seen from the side by one camera."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers


class Origami(Rig):
    """A zigzag of three to six creases; a pouch's lever shrinks with the cosine of the crease's angle as it opens.

    D. Rus, M. T. Tolley, Design, fabrication and control of origami robots, Nature Reviews Materials 3, 2018. Each
    crease turns all panels beyond it.
    Markers have two coordinates: the camera looks square to the plane in which the strip folds.
    """

    kind = "origami"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(3, 7))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(15, 45) * random.uniform(0.9, 1.1, count)
        panels, each = count + 1, int(random.integers(1, 3))
        spots = each * panels
        self.marker_names = tuple(f"p{m + 1}" for m in range(spots))
        self.observables = tuple(
            Observable(f"{name}.{'xyz'[axis]}", "mm", m, axis)
            for m, name in enumerate(self.marker_names)
            for axis in (0, 2)
        )
        self.noise = float(random.uniform(0.08, 0.18))
        way = np.where(np.arange(count) % 2, -1.0, 1.0)
        self._folded_rad = -way * np.deg2rad(random.uniform(40, 70, count))
        self._opens_rad = way * np.deg2rad(random.uniform(25, 50, count))
        self._soft = random.uniform(0.8, 2.5, count)
        self._length_mm = random.uniform(28, 45) * random.uniform(0.9, 1.1, panels)
        self._panel = np.repeat(np.arange(panels), each)
        share = np.tile(np.linspace(0.35, 0.8, each) if each > 1 else np.array([0.6]), panels)
        self._along_mm = share * self._length_mm[self._panel] + random.normal(0, 1.0, spots)
        self._off_mm = random.uniform(2, 6, spots)
        self._first_rad = np.deg2rad(random.uniform(20, 70))
        self.rest_mm = np.zeros((spots, 3))
        self.rest_mm[:, [0, 2]] = self.shape(np.zeros((1, count))).reshape(spots, 2)

    def deflection(self, kpa: Floats) -> Floats:
        return np.arctan(self._soft * kpa / self.high_kpa) / np.arctan(self._soft)

    def shape(self, deflection: Floats) -> Floats:
        crease = self._folded_rad + deflection * self._opens_rad
        start = np.full((len(deflection), 1), self._first_rad)
        angle = np.hstack([start, self._first_rad + np.cumsum(crease, axis=1)])  # of each panel
        along = np.stack([np.cos(angle), np.sin(angle)], axis=2)  # (T, panels, 2)
        square = np.stack([-np.sin(angle), np.cos(angle)], axis=2)
        ends = np.cumsum(self._length_mm[:, None] * along, axis=1) - self._length_mm[:, None] * along
        own = self._panel
        points = (
            ends[:, own] + self._along_mm[:, None] * along[:, own] + self._off_mm[:, None] * square[:, own]
        )
        return points.reshape(len(deflection), -1)
