"""Gravity: the sheet sags under its own weight."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


class Gravity(Hidden):
    """The sheet sags under its own weight, most where it is softest: a membrane far out is stiff.

    The sag follows the tangent compliance of the chambers' law, along gravity in the frame of the base, which
    may be tilted. `strength`: sag of a vented patch, mm.
    """

    name = "gravity"

    def see(self, time_s: Floats, tilt_deg: Floats, deflection_mm: Floats, position_mm: Floats) -> Floats:
        """Positions with the sag."""
        del time_s
        body = self.setting.body
        soft = (1.0 / (1.0 + 3.0 * (deflection_mm / body.limit_mm) ** 2)) @ body.weight.T
        tilt = np.deg2rad(tilt_deg)
        down = np.stack([0.0 * tilt, -np.sin(tilt), -np.cos(tilt)], axis=-1)
        return position_mm + self.strength * soft[..., None] * down[:, None]
