"""Lens (on no list of usual suspects): the cameras' distortion was never taken out."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


class Lens(Hidden):
    """Radial distortion: what moves away from the optical axis seems to move further than it does.

    Registration at rest took out the part that is always there. `strength`: distortion 150 mm from the axis,
    mm.
    """

    name = "lens"
    natural = 5.0

    def prepare(self) -> None:
        self.axis_mm = self.setting.body.rest_mm.mean(axis=0) + self.setting.random.normal(size=3) * 40.0

    def _distorted(self, position_mm: Floats) -> Floats:
        arm = position_mm - self.axis_mm
        distance = np.linalg.norm(arm[..., [0, 2]], axis=-1, keepdims=True)
        return arm * ((distance / 150.0) ** 2 + 0.3 * arm[..., 1:2] / 150.0) / 150.0

    def see(self, time_s: Floats, tilt_deg: Floats, deflection_mm: Floats, position_mm: Floats) -> Floats:
        """Positions through the lens."""
        del time_s, tilt_deg, deflection_mm
        return position_mm + self.strength * (
            self._distorted(position_mm) - self._distorted(self.setting.body.rest_mm)
        )
