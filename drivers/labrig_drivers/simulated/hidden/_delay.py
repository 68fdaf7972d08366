"""Delay: the air takes its time through a long thin tube."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


class Delay(Hidden):
    """A long thin tube and a soft chamber: two volumes that fill one after the other.

    `strength`: time constant of each, s.
    """

    name = "delay"
    natural = 0.5

    def prepare(self) -> None:
        self.share = self.setting.varied(0.15)

    def line(self, since_s: Floats, step_s: Floats, pressure_kpa: Floats) -> Floats:
        """Two lags in series."""
        del since_s
        first, second = self.memory.get("volumes", np.zeros((2, self.setting.chambers)))
        out = np.empty_like(pressure_kpa)
        lag = np.maximum(self.strength * self.share, 1e-3)
        keep = np.exp(-step_s[:, None] / lag)
        for k in range(step_s.size):
            before = first
            first = pressure_kpa[k] + (first - pressure_kpa[k]) * keep[k]
            rest = step_s[k] / lag * keep[k]
            second = (
                pressure_kpa[k] + (second - pressure_kpa[k]) * keep[k] + (before - pressure_kpa[k]) * rest
            )
            out[k] = second
        self.memory["volumes"] = np.stack([first, second])
        return out
