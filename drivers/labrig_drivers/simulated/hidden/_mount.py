"""Mount (on no list of usual suspects): the stand that carries the shell gives way under its load."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


class Mount(Hidden):
    """The whole shell nods and shifts, as a rigid body, with all that its chambers push together.

    `strength`: the turn when every chamber is full, degrees; the shift goes with it.
    """

    name = "mount"
    natural = 0.3

    def prepare(self) -> None:
        random, count = self.setting.random, self.setting.chambers
        axis = random.normal(size=3) * [1.0, 0.3, 0.6]
        self.axis = axis / np.linalg.norm(axis)
        self.foot_mm = np.array([0.0, -40.0, random.uniform(-80.0, 0.0)])
        lever = random.uniform(0.2, 1.0, count)
        self.lever = lever / lever.sum()
        self.shift_mm = random.normal(size=3)

    def see(self, time_s: Floats, tilt_deg: Floats, deflection_mm: Floats, position_mm: Floats) -> Floats:
        """Positions on the stand that has given way; a spring that hardens a little."""
        del time_s, tilt_deg
        load = (deflection_mm / self.setting.largest_mm) @ self.lever
        angle = np.deg2rad(self.strength * np.tanh(1.5 * load) / np.tanh(1.5))[:, None, None]
        arm = position_mm - self.foot_mm
        along = (arm @ self.axis)[..., None] * self.axis
        turned = along + np.cos(angle) * (arm - along) + np.sin(angle) * np.cross(self.axis, arm)
        return self.foot_mm + turned + np.rad2deg(angle) * self.shift_mm
