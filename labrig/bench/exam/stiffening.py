"""Stiffening: the walls' compliance changes with how far they have given way."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting


def _invariant(stretch: Floats) -> Floats:
    """The first invariant less 3 of a rubber pulled along one axis."""
    return stretch**2 + 2 / stretch - 3


_GRID = np.linspace(-0.9, 4.0, 4001)


def _balanced(deflection: Floats, extra: Floats, amount: Floats) -> Floats:
    """Where walls come to rest whose modulus is 1 + amount (C,) x extra, at the loads that a modulus of 1 would need.

    `extra` is on the grid of deflections; a load never falls as a wall gives way further, so no wall jumps.
    """
    if not amount.any():
        return deflection
    after = np.empty_like(deflection)
    for chamber, much in enumerate(amount):
        slope = np.diff(_GRID * (1 + much * extra)) / np.diff(_GRID)
        load = np.concatenate([[0.0], np.cumsum(np.maximum(slope, 0.25) * np.diff(_GRID))])
        after[:, chamber] = np.interp(deflection[:, chamber], load - np.interp(0.0, _GRID, load), _GRID)
    return after


class Yeoh(Law):
    """Filled rubber with a modulus C1 + 2 C2 (I1 - 3) + 3 C3 (I1 - 3)^2: C2 < 0 softens first, C3 > 0 stiffens later.

    O. H. Yeoh, Rubber Chemistry and Technology, 1993.
    """

    effect: ClassVar[str] = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._strain = random.uniform(0.35, 0.65)
        self._second = -random.uniform(0.1, 0.4)
        self._third = random.uniform(0.3, 0.9)
        self._share = random.uniform(0.7, 1.3, len(setting.rig.chambers))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """The walls where the new modulus balances the load that the old one did."""
        far = _invariant(1 + self._strain * _GRID)
        return _balanced(deflection, self._second * far + self._third * far**2, strength * self._share)


class ArrudaBoyce(Law):
    """Eight chains per cell with an inverse Langevin spring: the walls lock as the chains run out of length.

    E. M. Arruda and M. C. Boyce, J. Mechanics and Physics of Solids, 1993; inverse by A. Cohen, Rheologica Acta, 1991.
    """

    effect: ClassVar[str] = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._strain = setting.random.uniform(0.35, 0.65)
        self._links = setting.random.uniform(1.8, 3.0)
        self._share = setting.random.uniform(0.7, 1.3, len(setting.rig.chambers))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """The walls where the chains' modulus balances the load that a constant one did."""
        chain = np.minimum((_invariant(1 + self._strain * _GRID) / 3 + 1) / self._links, 0.95)
        start = 1 / self._links
        modulus = (3 - chain) / (1 - chain) / ((3 - start) / (1 - start))
        return _balanced(deflection, modulus - 1, strength * self._share)


class BilinearWall(Law):
    """Slack fibres that become taut at a knee: above it the walls give way along a flatter line.

    R. E. Shadwick, Journal of Experimental Biology, 1999 (recruitment of collagen in arterial walls).
    """

    effect: ClassVar[str] = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(setting.rig.chambers)
        self._knee = setting.random.uniform(0.25, 0.6) * setting.random.uniform(0.9, 1.1, count)
        self._taut = setting.random.uniform(0.2, 0.6)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """The walls, held back by the fibres above the knee."""
        held = strength * self._taut
        return deflection - np.maximum(deflection - self._knee, 0.0) * held / (1 + held)
