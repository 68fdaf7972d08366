"""Kink (on no list of usual suspects): one inflated chamber squeezes the hose of another."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


class Kink(Hidden):
    """While one chamber is well inflated, others get only a part of each change that is asked of them.

    `strength`: the part that is missing, in the worst chamber.
    """

    name = "kink"
    natural = 0.2

    def prepare(self) -> None:
        random, count = self.setting.random, self.setting.chambers
        self.squeezing = int(random.integers(count))
        self.threshold = random.uniform(0.2, 0.4)
        self.share = random.uniform(0.4, 1.0, count)
        self.share[self.squeezing] = 0.0

    def set_point(self, target_kpa: Floats) -> Floats:
        """Pressures that arrive through squeezed hoses; a vent of everything opens them all."""
        last = self.memory.get("pressure", np.zeros_like(target_kpa))
        full = target_kpa[self.squeezing] / self.setting.max_kpa[self.squeezing]
        shut = self.strength * self.share / (1.0 + np.exp(-(full - self.threshold) / 0.02))
        shut = np.minimum(shut, 1.0) if target_kpa.any() else np.zeros_like(shut)
        self.memory["pressure"] = target_kpa + shut * (last - target_kpa)
        return self.memory["pressure"].copy()
