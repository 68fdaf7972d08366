"""Stiffening: the further out, the harder to stretch."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden, resisted


class Stiffening(Hidden):
    """A fibre-filled silicone: exponential stiffening with stretch (Fung 1967), on top of the membrane's
    cubic.

    `strength`: dimensionless factor of the exponential term.
    """

    name = "stiffening"
    natural = 0.1

    def prepare(self) -> None:
        self.share = self.setting.varied(0.15)
        self.exponent = self.setting.random.uniform(1.5, 3.0)

    def deflect(self, time_s: Floats, step_s: Floats, deflection_mm: Floats) -> Floats:
        """Deflections of the stiffer membrane."""
        del time_s, step_s
        body, a = self.setting.body, self.exponent
        limit, gain = body.limit_mm, body.compliance_mm_per_kpa

        def resistance(d: Floats) -> tuple[Floats, Floats]:
            y = (d / limit) ** 2
            scale = self.strength * self.share / gain
            return scale * d * np.expm1(a * y), scale * (np.expm1(a * y) + 2.0 * a * y * np.exp(a * y))

        return resisted(body, deflection_mm, resistance)
