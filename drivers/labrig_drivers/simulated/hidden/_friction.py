"""Friction: the layers rub on each other and on the core, and hold the surface back in either direction."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


class Friction(Hidden):
    """LuGre friction (Canudas de Wit et al. 1995): bristles that bend over a short way, then slide.

    The force grows with the load (Coulomb) and falls with speed (Stribeck). `strength`: friction at the
    highest pressure as a part of it.
    """

    name = "friction"
    natural = 0.03

    def prepare(self) -> None:
        random = self.setting.random
        self.share = self.setting.varied(0.15)
        self.presliding = random.uniform(0.008, 0.02)
        self.unloaded = random.uniform(0.1, 0.3)
        self.stribeck, self.speed = random.uniform(0.2, 0.4), random.uniform(0.05, 0.2)

    def load(self, step_s: Floats, pressure_kpa: Floats) -> Floats:
        """The membrane's pressure less friction against its last motion."""
        x = pressure_kpa / self.setting.max_kpa
        z = self.memory.get("z", np.zeros(self.setting.chambers))
        last = self.memory.get("x", np.zeros(self.setting.chambers))
        out = np.empty_like(x)
        for k in range(len(x)):
            change = x[k] - last
            speed = np.abs(change) / max(step_s[k], 1e-3)
            # sliding over `change` in one go: the bristle relaxes towards the direction of motion
            z = np.sign(change) + (z - np.sign(change)) * np.exp(-np.abs(change) / self.presliding)
            out[k] = z * (1.0 + self.stribeck * np.exp(-((speed / self.speed) ** 2)))
            last = x[k]
        self.memory["z"], self.memory["x"] = z, last
        force = out * (self.unloaded + (1.0 - self.unloaded) * np.abs(x))
        return pressure_kpa - self.strength * self.share * self.setting.max_kpa * force
