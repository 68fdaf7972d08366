"""Regulator: what arrives in a chamber is not what was commanded."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


class Regulator(Hidden):
    """A pressure sensor that is off, S-shaped and different per channel, so that the loop settles elsewhere.

    `strength`: the typical error of span, as a part of the pressure.
    """

    name = "regulator"
    natural = 0.03

    def prepare(self) -> None:
        random, count = self.setting.random, self.setting.chambers
        self.span = random.choice([-1.0, 1.0]) * self.setting.varied(0.35)
        self.bend = 0.25 * random.normal(size=count)
        self.zero = 0.08 * random.normal(size=count)

    def set_point(self, target_kpa: Floats) -> Floats:
        """Pressure at which the faulty sensor reads the target; a vented line is open to the room."""
        x = target_kpa / self.setting.max_kpa
        error = self.span * x + self.bend * np.sin(2.0 * np.pi * x) / np.pi + self.zero
        return np.where(target_kpa == 0.0, 0.0, target_kpa + self.strength * self.setting.max_kpa * error)
