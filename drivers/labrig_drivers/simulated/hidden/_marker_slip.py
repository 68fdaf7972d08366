"""Marker slip: one marker moves on the surface, once."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


class MarkerSlip(Hidden):
    """One marker's glue lets go at some moment: it slides to another place within a second or two.

    `strength`: how far, mm.
    """

    name = "marker_slip"
    natural = 2.0

    def prepare(self) -> None:
        body, random = self.setting.body, self.setting.random
        self.marker = int(random.integers(len(body.rest_mm)))
        self.moment_s = self.setting.duration_s * random.uniform(0.3, 0.7)
        normal = body.normal[self.marker]
        way = random.normal(size=3)
        way -= (way @ normal) * normal
        self.way = way / np.linalg.norm(way)

    def see(self, time_s: Floats, tilt_deg: Floats, deflection_mm: Floats, position_mm: Floats) -> Floats:
        """Positions with one marker slipped."""
        del tilt_deg, deflection_mm
        slipped = 0.5 * (1.0 + np.tanh(2.0 * (time_s - self.moment_s)))
        moved = position_mm.copy()
        moved[:, self.marker] += self.strength * slipped[:, None] * self.way
        return moved
