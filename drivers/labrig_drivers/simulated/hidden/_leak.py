"""Leak: a chamber that is shut in loses its air."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


class Leak(Hidden):
    """Each chamber is shut in once it has reached its pressure, and loses air through an orifice.

    Flow goes with the root of the pressure, so the root falls linearly. `strength`: part of the highest
    pressure lost in the first 10 s at the highest pressure.
    """

    name = "leak"
    natural = 0.05

    def prepare(self) -> None:
        self.share = self.setting.varied(0.4)
        self.shut_after_s = 0.8

    def line(self, since_s: Floats, step_s: Floats, pressure_kpa: Floats) -> Floats:
        """What is left in the chambers."""
        del step_s
        shut_s = np.maximum(since_s - self.shut_after_s, 0.0)[:, None]
        rate = self.strength * self.share * np.sqrt(self.setting.max_kpa) / 20.0
        left = np.maximum(np.sqrt(np.abs(pressure_kpa)) - rate * shut_s, 0.0)
        return np.sign(pressure_kpa) * left**2
