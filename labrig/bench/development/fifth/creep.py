"""Creep of the fifth portion: times spread as a bell over their logarithm, a hyperbola of time, slow ways back."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some
from labrig.bench.development._story import as_chain, in_a_minute, lagged, pauses

_TIMES_S = np.geomspace(0.3, 1e4, 80)


class WagnersBell(Law):
    """Wagner's distribution: retardation times whose logarithms are normally distributed about one of them.

    K. W. Wagner, Zur Theorie der unvollkommenen Dielektrika, Annalen der Physik 345, 1913.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        middle_s = np.exp(random.uniform(np.log(5), np.log(150)))
        at = np.linspace(-2.2, 2.2, 9)
        tau_s = middle_s * np.exp(at * random.uniform(0.5, 1.8))
        self._tau_s, self._yields = in_a_minute(tau_s, np.exp(-0.5 * at**2))
        self._size = some(random, count, 0.06, 0.18, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        late = np.einsum("tnc,n->tc", lagged(path, deflection, self._tau_s), self._yields)
        return deflection + strength * self._size * late


class RossHyperbola(Law):
    """Ross: yielding is a hyperbola of the time under load, half of it gone after a time, and the rest ever slower.

    A. D. Ross, Concrete creep data, The Structural Engineer 15, 1937. Loads above a share of full count the more.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        half_s = np.exp(random.uniform(np.log(4), np.log(120)))
        self._tau_s, self._yields = as_chain(_TIMES_S / (half_s + _TIMES_S), _TIMES_S)
        self._above, self._more = random.uniform(0.4, 0.6), random.uniform(0.0, 1.5)
        self._size = some(random, count, 0.06, 0.16, 0.85)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        size = np.abs(deflection)
        pull = deflection + np.sign(deflection) * self._more * np.maximum(size - self._above, 0.0)
        late = np.einsum("tnc,n->tc", lagged(path, pull, self._tau_s), self._yields)
        return deflection + strength * self._size * late


class SlowWayBack(Law):
    """Slow recovery: what has yielded under load within seconds to minutes takes several times as long to come back.

    S. Turner, The strength of plastics expressed in terms of creep curves, in Testing of Polymers 4, Interscience,
    1969.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        first_s = np.exp(random.uniform(np.log(3), np.log(12)))
        self._forth_s = first_s * np.array([1.0, random.uniform(5, 12)])[:, None]
        self._slower = random.uniform(2.0, 6.0)
        self._size = some(random, count, 0.05, 0.14, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        gone_s, state = pauses(path), np.zeros((2, deflection.shape[1]))
        late = np.empty_like(deflection)
        for t, now in enumerate(deflection):
            tau_s = np.where(np.abs(now) > np.abs(state), 1.0, self._slower) * self._forth_s
            state = now + (state - now) * np.exp(-gone_s[t] / tau_s)
            late[t] = state.mean(axis=0)
        return deflection + strength * self._size * late
