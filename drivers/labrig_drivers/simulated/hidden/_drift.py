"""Drift: the rig warms up."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


class Drift(Hidden):
    """Everything warms up: first a Kelvin-type approach to the working temperature, then the day's wave.

    By chance the cameras' mount moves (all markers alike) or the silicone softens. `strength`: mm, or per
    cent of compliance, at the end of the warm-up.
    """

    name = "drift"
    natural = 0.5

    def prepare(self) -> None:
        random, duration = self.setting.random, self.setting.duration_s
        self.softens = bool(random.random() < 0.4)
        self.lag_s = duration * random.uniform(0.25, 0.8)
        self.wave_s, self.phase = duration * random.uniform(1.5, 3.0), random.uniform(0.0, 2.0 * np.pi)
        direction = random.normal(size=3)
        self.direction = direction / np.linalg.norm(direction)

    def warmth(self, time_s: Floats) -> Floats:
        """Temperature above the start, in parts of the warm-up, (T,)."""
        wave = np.sin(2.0 * np.pi * time_s / self.wave_s + self.phase) - np.sin(self.phase)
        return 1.0 - np.exp(-time_s / self.lag_s) + 0.15 * wave

    def deflect(self, time_s: Floats, step_s: Floats, deflection_mm: Floats) -> Floats:
        """Deflections of the warmer membrane."""
        del step_s
        if not self.softens:
            return deflection_mm
        return deflection_mm * (1.0 + 0.01 * self.strength * self.warmth(time_s)[:, None])

    def see(self, time_s: Floats, tilt_deg: Floats, deflection_mm: Floats, position_mm: Floats) -> Floats:
        """Positions seen by cameras that have moved, and turned with it by a hair."""
        del tilt_deg, deflection_mm
        if self.softens:
            return position_mm
        moved = self.strength * self.warmth(time_s)[:, None, None]
        turned = np.cross(self.direction, position_mm - self.setting.body.rest_mm.mean(axis=0)) * 5e-4
        return np.asarray(position_mm + moved * (np.roll(self.direction, 1) + turned), dtype=float)
