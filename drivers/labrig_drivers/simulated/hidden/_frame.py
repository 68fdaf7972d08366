"""Frame: the measuring frame is not where it is believed to be."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


class Frame(Hidden):
    """A calibration wand held badly: the measuring frame is turned, shifted, and a little off in scale.

    `strength`: the turn, degrees; shift and scale go with it.
    """

    name = "frame"
    natural = 0.2

    def prepare(self) -> None:
        random = self.setting.random
        axis = random.normal(size=3)
        self.axis = axis / np.linalg.norm(axis)
        self.shift_mm = random.normal(size=3)
        self.scale = 1e-3 * random.normal()
        self.pivot_mm = self.setting.body.rest_mm.mean(axis=0) + random.normal(size=3) * 40.0

    def see(self, time_s: Floats, tilt_deg: Floats, deflection_mm: Floats, position_mm: Floats) -> Floats:
        """Positions in the frame as it is (Rodrigues' rotation)."""
        del time_s, tilt_deg, deflection_mm
        angle = np.deg2rad(self.strength)
        arm = position_mm - self.pivot_mm
        along = (arm @ self.axis)[..., None] * self.axis
        turned = along + np.cos(angle) * (arm - along) + np.sin(angle) * np.cross(self.axis, arm)
        seen = self.pivot_mm + turned * (1.0 + self.scale * self.strength) + self.strength * self.shift_mm
        return np.asarray(seen, dtype=float)
