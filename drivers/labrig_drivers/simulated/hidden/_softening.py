"""Softening (on no list of usual suspects): rubber remembers how far it was stretched, and forgets it again."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


class Softening(Hidden):
    """Mullins effect (1969) that heals: softer below the largest stretch of late.

    `strength`: part of the stiffness lost after a full inflation.
    """

    name = "softening"
    natural = 0.05

    def prepare(self) -> None:
        self.healing_s = self.setting.random.uniform(15.0, 60.0)

    def deflect(self, time_s: Floats, step_s: Floats, deflection_mm: Floats) -> Floats:
        """Deflections of the damaged rubber."""
        del time_s
        largest = self.memory.get("largest", np.zeros(self.setting.chambers))
        reached = np.empty_like(deflection_mm)
        for k in range(step_s.size):
            largest = np.maximum(np.abs(deflection_mm[k]), largest * np.exp(-step_s[k] / self.healing_s))
            reached[k] = largest
        self.memory["largest"] = largest
        unused = 1.0 - (np.abs(deflection_mm) / np.maximum(reached, 1e-9)) ** 2
        return deflection_mm + self.strength * reached * unused
