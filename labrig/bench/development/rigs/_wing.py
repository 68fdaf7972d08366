"""A morphing trailing edge: two rows of pressurised cells bend it against each other; markers are on both skins."""

import numpy as np
from scipy.special import erf

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, markers


class Wing(Rig):
    """Pressure-actuated cells: at each station the upper cell bends the wing down, the lower one up.

    M. Pagitz, E. Lamacchia, J. M. A. M. Hol, Pressure-actuated cellular structures, Bioinspiration and Biomimetics 7,
    2012. Both together make a station stiff, so that neither acts alone; a station turns all that lies behind it.
    """

    kind = "wing"

    def __init__(self, random: np.random.Generator) -> None:
        stations = int(random.integers(4, 7))
        count = 2 * stations
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(60, 200) * random.uniform(0.93, 1.07, count)
        spots = 2 * int(random.integers(7, 13))
        self.marker_names, self.observables = markers(spots)
        self.noise = float(random.uniform(0.08, 0.16))
        self._chord_mm = random.uniform(25, 45) * random.uniform(0.9, 1.1, stations)
        self._turn_rad = np.deg2rad(random.uniform(10, 18, (2, stations))) * np.array([[-1.0], [1.0]])
        self._stiff = random.uniform(0.3, 1.2)
        self._unlike = random.uniform(-0.3, 0.3, stations)  # how much more one side of the span turns
        self._early = random.uniform(0.5, 1.3, count)
        place = np.linspace(0.4, stations - 0.1, spots) + random.normal(0, 0.05, spots)
        self._station = np.clip(place.astype(int), 0, stations - 1)
        self._along_mm = (place - self._station) * self._chord_mm[self._station]
        self._side = np.where(np.arange(spots) % 2, 1.0, -1.0) * random.uniform(0.7, 1.0, spots)
        self._wide_mm = random.uniform(40, 70)
        thick_mm = random.uniform(14, 24) * (1 - 0.7 * place / stations)
        self._off_mm = 0.5 * thick_mm * np.where(np.arange(spots) // 2 % 2, -1.0, 1.0)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(spots, 3)

    def deflection(self, kpa: Floats) -> Floats:
        return erf(self._early * kpa / self.high_kpa) / erf(self._early)

    def shape(self, deflection: Floats) -> Floats:
        cells = deflection.reshape(len(deflection), 2, -1)
        firm = 1 + self._stiff * (np.sqrt(0.01 + cells**2) - 0.1).sum(axis=1)
        bend = np.sum(cells * self._turn_rad, axis=1) / firm * (1 + 0.5 * self._stiff)  # (T, stations)
        unlike = 1 + self._unlike * self._side[:, None]  # (M, stations)
        angle = np.cumsum(bend[:, None] * unlike, axis=2)  # (T, M, stations)
        steps = self._chord_mm * np.stack([np.cos(angle), np.sin(angle)], axis=3).transpose(3, 0, 1, 2)
        ends = np.cumsum(steps, axis=3) - steps
        own = self._station[None, :, None]
        x, z = (
            np.take_along_axis(each, np.broadcast_to(own, each[:, :, :1].shape), axis=2)[..., 0]
            for each in ends
        )
        here = np.take_along_axis(angle, np.broadcast_to(own, angle[:, :, :1].shape), axis=2)[..., 0]
        x = x + self._along_mm * np.cos(here) - self._off_mm * np.sin(here)
        z = z + self._along_mm * np.sin(here) + self._off_mm * np.cos(here)
        y = np.broadcast_to(self._wide_mm * self._side, x.shape)
        return np.stack([x, y, z], axis=2).reshape(len(deflection), -1)
