"""Further tension: rubber stretched beforehand, a clamped rim that holds some chambers only, skins that go slack."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Setting
from labrig.bench.development._places import some
from labrig.bench.development.tension import HeldBack


class StretchedBeforehand(HeldBack):
    """Pre-stretched neo-Hookean sheet: what its stretch adds to its stress, times the curvature of the bulge.

    J. E. Adkins, R. S. Rivlin, Large elastic deformations of isotropic materials IX: the deformation of thin shells,
    Phil. Trans. Royal Society A 244, 1952.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._before = random.uniform(1.02, 1.12)
        self._height = random.uniform(0.3, 0.7, count)  # of a full bulge, against its radius
        self._stiff = random.uniform(0.3, 0.6) * random.uniform(0.85, 1.15, count)

    def _held(self, deflection: Floats) -> Floats:
        height = self._height * deflection
        stretch = np.sqrt(1 + height**2)
        more = _stress(self._before * stretch) - _stress(stretch)
        return self._stiff * more * deflection / (1 + height**2)


class ClampedRim(HeldBack):
    """Clamped rim: thin skin drawn tight where it is clamped; it pulls by its curvature on some chambers only.

    R. P. Vinci, J. J. Vlassak, Mechanical behavior of thin films, Annual Review of Materials Science 26, 1996.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tight = some(random, count, 0.12, 0.4, random.uniform(0.4, 0.9))
        self._steep = random.uniform(0.5, 1.3)

    def _held(self, deflection: Floats) -> Floats:
        return self._tight * deflection / (1 + (self._steep * deflection) ** 2) ** 1.5


class GoingSlack(HeldBack):
    """Cable that goes slack: the way out uses up the mounting tension, which fades away exponentially.

    H. M. Irvine, Cable Structures, MIT Press, 1981.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tight = random.uniform(0.2, 0.5) * random.uniform(0.8, 1.2, count)
        self._slack_at = random.uniform(0.3, 0.8)

    def _held(self, deflection: Floats) -> Floats:
        return self._tight * deflection * np.exp(-np.abs(deflection) / self._slack_at)


class SkewedNet(HeldBack):
    """Pretensioned net: cords that cross at an angle straighten out as they yield, and pull with the tangent of it.

    H.-J. Schek, The force density method for form finding and computation of general networks, Computer Methods in
    Applied Mechanics and Engineering 3, 1974.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._density = random.uniform(0.08, 0.2) * np.exp(random.normal(0, 0.5, count))
        self._straight_at = random.uniform(0.5, 1.2)

    def _held(self, deflection: Floats) -> Floats:
        return self._density * self._straight_at * np.arctan(deflection / self._straight_at)


def _stress(stretch: Floats) -> Floats:
    """The stress of a neo-Hookean sheet, stretched the same in both directions."""
    return stretch**2 - stretch**-4
