"""Creep of the fourth portion: foam that drains, Davidson and Cole's skewed times, memory of the second order."""

import numpy as np
from scipy.special import gammainc

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some
from labrig.bench.development._story import as_chain, in_a_minute, lagged

_TIMES_S = np.geomspace(0.3, 1e4, 80)


class DrainingFoam(Law):
    """Consolidation: a wet foam yields as its water drains through it, with the root of time first, then exponentially.

    K. Terzaghi, Erdbaumechanik auf bodenphysikalischer Grundlage, Deuticke, 1925.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        drains_s = np.exp(random.uniform(np.log(15), np.log(250)))
        odd = np.asarray((2 * np.arange(8) + 1) ** 2, dtype=float)
        self._tau_s, self._yields = in_a_minute(drains_s / odd, 8 / np.pi**2 / odd)
        self._size = some(random, count, 0.06, 0.18, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        late = np.einsum("tnc,n->tc", lagged(path, deflection, self._tau_s), self._yields)
        return deflection + strength * self._size * late


class DavidsonCole(Law):
    """Davidson-Cole: relaxation times crowd below a longest one; yielding is an incomplete gamma function of time.

    D. W. Davidson, R. H. Cole, Dielectric relaxation in glycerol, propylene glycol, and n-propanol, J. Chemical Physics
    19, 1951.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        longest_s = np.exp(random.uniform(np.log(20), np.log(600)))
        self._tau_s, self._yields = as_chain(
            gammainc(random.uniform(0.2, 0.6), _TIMES_S / longest_s), _TIMES_S
        )
        self._softens = random.uniform(-0.3, 0.3)  # under load
        self._size = some(random, count, 0.06, 0.16, 0.85)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        pull = deflection * (1 + self._softens * np.minimum(np.abs(deflection), 1.5))
        late = np.einsum("tnc,n->tc", lagged(path, pull, self._tau_s), self._yields)
        return deflection + strength * self._size * late


class GreenRivlin(Law):
    """Green-Rivlin: beside one memory of the load comes the product of two, so that large loads yield on the more.

    A. E. Green, R. S. Rivlin, The mechanics of non-linear materials with memory, Archive for Rational Mechanics and
    Analysis 1, 1957.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        first_s = np.exp(random.uniform(np.log(3), np.log(15)))
        self._tau_s = first_s * np.array([1.0, random.uniform(3, 8)])
        self._second = random.uniform(0.5, 2.0)
        self._size = some(random, count, 0.04, 0.12, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        fast, slow = lagged(path, deflection, self._tau_s).swapaxes(0, 1)
        late = 0.5 * (fast + slow) + self._second * np.abs(fast) * slow
        return deflection + strength * self._size * late
