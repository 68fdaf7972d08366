"""Leaks of the twelfth portion: slip flow through fine pores, and a bursting disc that has given way."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some

_ROOM_KPA = 101.3


class SlipsThroughPores(Law):
    """Klinkenberg: in pores as fine as the way between two collisions gas slips, and leaks by more than viscosity says.

    L. J. Klinkenberg, The permeability of porous media to liquids and gases, API Drilling and Production Practice,
    1941: permeability grows by one over the mean pressure. What leaks goes with the difference of the squares of both
    absolute pressures, and with their difference.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._per_s = random.uniform(0.002, 0.006) * random.lognormal(
            0.0, 0.4, count
        )  # of a pressure far below 1 atm
        self._slips = random.uniform(0.2, 2.0)  # atm

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        over = kpa / _ROOM_KPA
        per_s = strength * self._per_s
        # d over / dt = -per_s over (over / 2 + 1 + slips) / (1 + slips), in closed form
        rest = 1 + self._slips
        gone = np.exp(-per_s * path.hold_s[:, None])
        return kpa * gone / np.maximum(1 + over / (2 * rest) * (1 - gone), 0.05)


class GaveWayOnce(Law):
    """Bursting disc: a weak place in some chambers gives way the first time that enough presses on it, and leaks since.

    ISO 4126-2, Safety devices for protection against excessive pressure: Bursting disc safety devices, 2018. Its hole
    passes the root of the pressure: a chamber loses it evenly, and the last of it fast.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        count = len(self.rig.chambers)
        most = np.maximum(np.abs(full(self.rig, path.kpa)).max(axis=0), 0.1)
        self._at = random.uniform(0.45, 0.85, count) * most
        self._per_s = some(random, count, 0.003, 0.009, share=0.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, path.kpa)
        burst = np.maximum.accumulate(np.abs(load), axis=0) >= self._at
        # the root of the pressure falls evenly in time
        size = np.abs(full(self.rig, kpa))
        falls = 0.5 * strength * self._per_s * path.hold_s[:, None]
        left = np.maximum(np.sqrt(size) - falls, 0.0) ** 2
        return np.where(burst, np.sign(kpa) * left * self.rig.high_kpa, kpa)
