"""Creep of the sixth portion: a logarithm of a power of time, water in a gel, a wedge of relaxation times."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some
from labrig.bench.development._story import as_chain, in_a_minute, lagged

_TIMES_S = np.geomspace(0.3, 1e4, 80)


class LogOfPower(Law):
    """Bažant-Prasannan: it yields by the logarithm of one plus a power of time: a power first, then a logarithm.

    Z. P. Bažant, S. Prasannan, Solidification theory for concrete creep I: formulation, J. Engineering Mechanics 115,
    1989.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        turns_s, power = np.exp(random.uniform(np.log(5), np.log(200))), random.uniform(0.4, 0.95)
        self._tau_s, self._yields = as_chain(np.log1p((_TIMES_S / turns_s) ** power), _TIMES_S)
        self._size = some(random, count, 0.06, 0.18, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        late = np.einsum("tnc,n->tc", lagged(path, deflection, self._tau_s), self._yields)
        return deflection + strength * self._size * late


class WaterInGel(Law):
    """Poroelastic gel: water is squeezed out of it by two exponentials, one of the root of time and one of time.

    Y. Hu, X. Zhao, J. J. Vlassak, Z. Suo, Using indentation to characterize the poroelasticity of gels, Applied Physics
    Letters 96, 2010. Thick walls take longer, by the square.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        middle_s, thick = np.exp(random.uniform(np.log(10), np.log(200))), random.uniform(0.8, 1.25, count)
        scaled = _TIMES_S / middle_s
        gone = 1 - 0.491 * np.exp(-0.908 * np.sqrt(scaled)) - 0.509 * np.exp(-1.679 * scaled)
        tau_s, self._yields = as_chain(gone, _TIMES_S)
        self._tau_s = tau_s[:, None] * thick**2
        self._size = some(random, count, 0.06, 0.2, 0.85)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        late = lagged(path, deflection, self._tau_s)
        return deflection + strength * self._size * np.einsum("tnc,n->tc", late, self._yields)


class WedgeOfTimes(Law):
    """Tobolsky's wedge: relaxation times between two ends, the fewer, the longer they are, by one over their root.

    A. V. Tobolsky, Properties and Structure of Polymers, Wiley, 1960. What yields is as if by more pressure.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        first_s = np.exp(random.uniform(np.log(1.0), np.log(6.0)))
        tau_s = np.geomspace(first_s, first_s * random.uniform(20, 200), 9)
        self._tau_s, self._yields = in_a_minute(tau_s, tau_s**-0.5)
        self._size = some(random, count, 0.06, 0.18, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        late = np.einsum("tnc,n->tc", lagged(path, kpa, self._tau_s), self._yields)
        return kpa + strength * self._size * late
