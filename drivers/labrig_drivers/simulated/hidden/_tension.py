"""Tension: the top membrane is stretched more than assumed."""

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden, resisted


class Tension(Hidden):
    """The top membrane was mounted with more stretch than the drawing says: stiffer at first, not when far
    out.

    `strength`: the surplus of linear stiffness, as a part of it.
    """

    name = "tension"
    natural = 0.08

    def deflect(self, time_s: Floats, step_s: Floats, deflection_mm: Floats) -> Floats:
        """Deflections under more tension."""
        del time_s, step_s
        stiffness = self.strength / self.setting.body.compliance_mm_per_kpa
        return resisted(self.setting.body, deflection_mm, lambda d: (stiffness * d, stiffness + 0.0 * d))
