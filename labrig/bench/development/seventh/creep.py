"""Creep of the seventh portion: the third root of time and a steady flow, and a material that ages as it yields."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some
from labrig.bench.development._story import UNIT_S, as_chain, lagged, pauses, steps

_TIMES_S = np.geomspace(0.3, 1e4, 80)


class ThirdRootAndFlow(Law):
    """Andrade: under load it yields by the third root of time, and flows on evenly beside; the flow does not come back.

    E. N. da C. Andrade, On the viscous flow in metals, and allied phenomena, Proc. Royal Society A 84, 1910.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tau_s, self._yields = as_chain(np.cbrt(_TIMES_S), _TIMES_S)
        self._size = some(random, count, 0.06, 0.18, 0.9)
        self._flows = random.uniform(0.0, 0.02)  # in a minute, of what the root yields

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        late = np.einsum("tnc,n->tc", lagged(path, deflection, self._tau_s), self._yields)
        flown = np.cumsum(deflection * pauses(path)[:, None], axis=0) / UNIT_S
        return deflection + strength * self._size * (late + self._flows * flown)


class AgesAsItYields(Law):
    """Double power law: a power of the time under load, and another one, falling, of the age at which the load came.

    Z. P. Bažant, E. Osman, Double power law for basic creep of concrete, Materials and Structures 9, 1976. So what is
    loaded early yields more than what is loaded late.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tau_s, self._yields = as_chain(_TIMES_S ** random.uniform(0.15, 0.45), _TIMES_S)
        self._power = random.uniform(0.1, 0.4)
        self._age_s = max(float(setting.path.time_s[-1]), 1.0) * random.uniform(0.1, 1.0)
        self._size = some(random, count, 0.05, 0.14, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        young = (1 + path.time_s[:, None] / self._age_s) ** -self._power
        drive = np.cumsum(steps(deflection) * young, axis=0)
        late = np.einsum("tnc,n->tc", lagged(path, drive, self._tau_s), self._yields)
        return deflection + strength * self._size * late
