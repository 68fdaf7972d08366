"""Tension of the third portion: cords of rubber, sagging guys, bundles of threads that go slack one by one."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Setting
from labrig.bench.development._places import some
from labrig.bench.development.tension import HeldBack


class PrestretchedCord(HeldBack):
    """Neo-Hookean cord, stretched beforehand: what that adds to its pull, times the sine of its slope.

    L. R. G. Treloar, The elasticity of a network of long-chain molecules I, Trans. Faraday Society 39, 1943.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._before = random.uniform(1.05, 1.25)
        self._steep = random.uniform(0.5, 1.4, count)
        self._stiff = some(random, count, 0.25, 0.6, random.uniform(0.6, 1.0))

    def _held(self, deflection: Floats) -> Floats:
        slope = self._steep * deflection
        stretch = np.sqrt(1 + slope**2)
        more = _pull(self._before * stretch) - _pull(stretch)
        return self._stiff * more * slope / stretch


class SaggingGuy(HeldBack):
    """Guy ropes: as they are pulled straight their sag goes, and they hold with the inverse hyperbolic sine of the way.

    H. J. Ernst, Der E-Modul von Seilen unter Berücksichtigung des Durchhanges, Der Bauingenieur 40, 1965.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._straight_at = random.uniform(0.08, 0.35, count)
        self._tight = random.uniform(0.04, 0.12) * random.uniform(0.75, 1.25, count)

    def _held(self, deflection: Floats) -> Floats:
        return self._tight * np.arcsinh(deflection / self._straight_at)


class SlackBundle(HeldBack):
    """Bundle of threads: each goes slack at a way of its own (Weibull), so that fewer and fewer hold.

    H. E. Daniels, The statistical theory of the strength of bundles of threads, Proc. Royal Society A 183, 1945.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._shape = random.uniform(1.8, 3.5)
        self._slack_at = random.uniform(0.4, 0.9) * random.uniform(0.85, 1.15, count)
        self._tight = some(random, count, 0.12, 0.35, 0.85)

    def _held(self, deflection: Floats) -> Floats:
        share = np.exp(-((np.abs(deflection) / self._slack_at) ** self._shape))
        return self._tight * deflection * share


def _pull(stretch: Floats) -> Floats:
    """The stress of a neo-Hookean cord."""
    return stretch - stretch**-2
