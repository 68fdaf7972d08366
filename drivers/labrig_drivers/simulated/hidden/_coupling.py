"""Coupling: chambers that touch hinder each other."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


def neighbours(weight: Floats) -> Floats:
    """How much chambers share of the surface, (C, C), zero diagonal, largest entry one; `weight` (M, C)."""
    norm = np.linalg.norm(weight, axis=0)
    shared = weight.T @ weight / np.outer(norm, norm)
    np.fill_diagonal(shared, 0.0)
    return shared / max(shared.max(), 1e-12)


class Coupling(Hidden):
    """Bellies that touch: an inflated neighbour presses a chamber flat, less and less the further it is out.

    d_i becomes d_i (1 - s sum_j a_ij tanh(d_j / d0)); `strength` s: dimensionless.
    """

    name = "coupling"
    natural = 0.05

    def prepare(self) -> None:
        random, count = self.setting.random, self.setting.chambers
        chance = np.exp(0.4 * random.normal(size=(count, count)))
        self.pairs = neighbours(self.setting.body.weight) * chance
        self.scale_mm = random.uniform(0.35, 0.7) * self.setting.largest_mm

    def deflect(self, time_s: Floats, step_s: Floats, deflection_mm: Floats) -> Floats:
        """Deflections beside inflated neighbours."""
        del time_s, step_s
        pressed = np.tanh(deflection_mm / self.scale_mm) @ self.pairs.T
        return deflection_mm * (1.0 - self.strength * pressed)
