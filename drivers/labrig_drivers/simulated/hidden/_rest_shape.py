"""Rest shape: the unloaded shell is not as drawn."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


class RestShape(Hidden):
    """The shell was printed or mounted a little out of shape: a smooth bend along its normals.

    `strength`: typical deviation, mm.
    """

    name = "rest_shape"
    natural = 0.5

    def prepare(self) -> None:
        body, random = self.setting.body, self.setting.random
        centred = body.rest_mm - body.rest_mm.mean(axis=0)
        across, up = centred[:, 0] / 100.0, centred[:, 2] / 150.0
        terms = np.stack([across**2, up**2, across * up, up**3, across**2 * up, np.cos(2.0 * up)], axis=-1)
        bend = (terms - terms.mean(axis=0)) @ random.normal(size=terms.shape[1])
        self.bend = (bend / np.sqrt(np.mean(bend**2)))[:, None] * body.normal

    def see(self, time_s: Floats, tilt_deg: Floats, deflection_mm: Floats, position_mm: Floats) -> Floats:
        """Positions on the shell as it is."""
        del time_s, tilt_deg, deflection_mm
        return position_mm + self.strength * self.bend
