"""Contact: something stands in the way of an inflated chamber."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden, resisted


class Contact(Hidden):
    """A strut in front of one chamber or two is met at some deflection: Hertzian resistance beyond it.

    `strength`: how far short of the largest deflection the strut stands, mm.
    """

    name = "contact"
    natural = 5.0

    def prepare(self) -> None:
        random, count = self.setting.random, self.setting.chambers
        touched = random.permutation(count)[: min(count, int(random.integers(1, 3)))]
        self.touches = np.isin(np.arange(count), touched).astype(float)
        self.hardness = random.uniform(2.0, 6.0)  # at 10 mm beyond the gap, in stiffnesses of the membrane

    def deflect(self, time_s: Floats, step_s: Floats, deflection_mm: Floats) -> Floats:
        """Deflections against the strut."""
        del time_s, step_s
        body = self.setting.body
        gap_mm = np.maximum(self.setting.largest_mm - self.strength, 0.0)
        scale = self.hardness * self.touches / (body.compliance_mm_per_kpa * np.sqrt(10.0))

        def resistance(d: Floats) -> tuple[Floats, Floats]:
            deep = np.maximum(d - gap_mm, 0.0)
            return scale * deep**1.5, 1.5 * scale * np.sqrt(deep)

        return resisted(body, deflection_mm, resistance)
