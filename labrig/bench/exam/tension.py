"""Tension: the top membrane was stretched before it was fixed."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import (
    Law,
    Path,
    Rig,
    Setting,
)
from labrig.bench.exam.tools import seats


def _left_over(rig: Rig, kpa: Floats, taken_kpa: Floats, bend: float, steps: int = 7) -> Floats:
    """The deflections that pressures make when the tension takes its part, taken d / sqrt(1 + (d / bend)^2) kPa.

    Solved for the pressure q that is left for the wall itself, q + taken(d(q)) = p, by Newton's method.
    """
    low, high = np.minimum(kpa, 0.0), np.maximum(kpa, 0.0)
    small_kpa = 1e-3 * rig.high_kpa
    left = kpa / (1 + taken_kpa / rig.high_kpa)
    for _ in range(steps):
        here = rig.deflection(left)
        slope = (rig.deflection(left + small_kpa) - here) / small_kpa
        root = np.sqrt(1 + (here / bend) ** 2)
        miss = left + taken_kpa * here / root - kpa
        left = np.clip(left - miss / (1 + taken_kpa * slope / root**3), low, high)
    return rig.deflection(left)


class FopplPretension(Law):
    """A membrane with one pretension: it takes a pressure in proportion to the deflection, besides what bends the wall.

    J. W. Small and W. D. Nix, Journal of Materials Research, 1992 (bulge test of pretensioned Foppl-von Karman films).
    """

    effect: ClassVar[str] = "tension"
    needs: ClassVar[frozenset[str]] = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, setting.rig
        self._taken_kpa = random.uniform(0.1, 0.25) * rig.high_kpa.mean() * np.ones(len(rig.chambers))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """The walls, less by what the tension takes."""
        with_tension = _left_over(self.rig, kpa, strength * self._taken_kpa, 1e6)
        return deflection + (with_tension - self.rig.deflection(kpa)) if strength else deflection


class PreStretchGradient(Law):
    """A membrane stretched more at one side: a tension that differs from chamber to chamber, most felt at small loads.

    N. Goulbourne, E. Mockensturm and M. Frecker, Journal of Applied Mechanics, 2005 (pre-stretched membranes).
    """

    effect: ClassVar[str] = "tension"
    needs: ClassVar[frozenset[str]] = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, setting.rig
        seat = seats(rig)
        slope = (seat - seat.mean(axis=0)) @ random.standard_normal(3)
        slope = slope / (np.abs(slope).max() or 1.0)
        self._taken_kpa = (
            random.uniform(0.12, 0.3) * rig.high_kpa.mean() * (1 + random.uniform(0.5, 0.95) * slope)
        )
        self._bend = random.uniform(0.4, 1.0)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """The walls, each less by what its own tension takes."""
        with_tension = _left_over(self.rig, kpa, strength * self._taken_kpa, self._bend)
        return deflection + (with_tension - self.rig.deflection(kpa)) if strength else deflection
