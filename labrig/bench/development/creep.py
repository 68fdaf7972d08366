"""Creep: the walls go on yielding under load, ever slower, and come back as slowly: linear in the load's history."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some
from labrig.bench.development._story import as_chain, lagged

_TIMES_S = np.geomspace(0.3, 1e4, 80)


class KelvinVoigtChain(Law):
    """Kelvin-Voigt chain: two or three springs, each beside a damper, yield one after another in each wall.

    N. W. Tschoegl, The Phenomenological Theory of Linear Viscoelastic Behavior, Springer, 1989.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        links = int(setting.random.integers(2, 4))
        self._tau_s = np.exp(setting.random.uniform(np.log(4), np.log(250), links))
        self._yields = setting.random.dirichlet(np.full(links, 2.0))
        self._size = some(setting.random, len(self.rig.chambers), 0.08, 0.2)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        late = np.einsum("tnc,n->tc", lagged(path, deflection, self._tau_s), self._yields)
        return deflection + strength * self._size * late


class LogarithmicCreep(Law):
    """Logarithmic creep: the walls yield with the logarithm of the time under load, as if by a little more pressure.

    A. N. Gent, Relaxation processes in vulcanized rubber I, J. Applied Polymer Science 6, 1962.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        begins_s = np.exp(setting.random.uniform(np.log(0.5), np.log(8)))
        self._tau_s, self._yields = as_chain(np.log1p(_TIMES_S / begins_s), _TIMES_S)
        self._size = some(setting.random, len(self.rig.chambers), 0.06, 0.15)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        late = np.einsum("tnc,n->tc", lagged(path, kpa, self._tau_s), self._yields)
        return kpa + strength * self._size * late


class FindleyPowerLaw(Law):
    """Findley's power law: yielding grows with a power of time, and with the hyperbolic sine of the load.

    W. N. Findley, J. S. Lai, K. Onaran, Creep and Relaxation of Nonlinear Viscoelastic Materials, North-Holland, 1976.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._tau_s, self._yields = as_chain(_TIMES_S ** setting.random.uniform(0.12, 0.4), _TIMES_S)
        self._steep = setting.random.uniform(0.2, 1.2)
        self._size = some(setting.random, len(self.rig.chambers), 0.06, 0.16)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = np.sinh(self._steep * full(self.rig, kpa)) / np.sinh(self._steep)
        late = np.einsum("tnc,n->tc", lagged(path, load, self._tau_s), self._yields)
        return kpa + strength * self._size * self.rig.high_kpa * late


class StretchedExponential(Law):
    """Kohlrausch-Williams-Watts: the walls approach their end by a stretched exponential of the time under load.

    G. Williams, D. C. Watts, Non-symmetrical dielectric relaxation behaviour, Trans. Faraday Society 66, 1970.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        tau_s = np.exp(setting.random.uniform(np.log(8), np.log(150)))
        stretch = setting.random.uniform(0.4, 0.8)
        self._tau_s, self._yields = as_chain(-np.expm1(-((_TIMES_S / tau_s) ** stretch)), _TIMES_S)
        self._size = some(setting.random, len(self.rig.chambers), 0.06, 0.16)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        late = np.einsum("tnc,n->tc", lagged(path, deflection, self._tau_s), self._yields)
        return deflection + strength * self._size * late
