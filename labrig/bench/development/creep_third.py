"""Creep of the third portion: hardening flow, flow above a yield load, a box of times, a backing that sinks."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some
from labrig.bench.development._story import as_chain, in_a_minute, lagged, pauses

_TIMES_S = np.geomspace(0.3, 1e4, 80)


class HardeningFlow(Law):
    """Strain hardening: what has flowed already slows the flow under load; once unloaded, it fades from memory.

    P. G. Nutting, A new general law of deformation, J. Franklin Institute 191, 1921, in the strain-hardening form of
    Yu. N. Rabotnov, Creep Problems in Structural Members, North-Holland, 1969.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._hardens, self._power = random.uniform(1.0, 3.0), random.uniform(1.0, 2.0)
        self._minute = random.uniform(0.5, 1.0)  # flowed in a minute at full load, had nothing faded
        self._fades_s = np.exp(random.uniform(np.log(40), np.log(300)))
        self._size = some(random, len(self.rig.chambers), 0.08, 0.2, 0.85)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        up, down = (self._flown(path, np.maximum(each, 0.0)) for each in (deflection, -deflection))
        return deflection + strength * self._size * (up - down)

    def _flown(self, path: Path, load: Floats) -> Floats:
        n, pause_s = self._hardens + 1, pauses(path)
        flows = (self._minute**n / 60.0) * np.minimum(load, 2.0) ** self._power * pause_s[:, None]
        stays = np.exp(-pause_s / self._fades_s)
        state, out = np.zeros(load.shape[1]), np.empty_like(load)
        for t in range(len(out)):
            state = (state**n + flows[t]) ** (1 / n) * stays[t]
            out[t] = state
        return out


class BinghamBody(Law):
    """Bingham body beside a spring: it flows after the load only while it is behind by more than a yield stress.

    E. C. Bingham, Fluidity and Plasticity, McGraw-Hill, 1922; P. Perzyna, Fundamental problems in viscoplasticity,
    Advances in Applied Mechanics 9, 1966.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._yield = random.uniform(0.04, 0.12) * random.uniform(0.8, 1.2, count)
        self._tau_s = np.exp(random.uniform(np.log(10), np.log(90)))
        self._size = some(random, count, 0.1, 0.25)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        share = -np.expm1(-pauses(path) / self._tau_s)
        state, late = np.zeros(deflection.shape[1]), np.empty_like(deflection)
        for t, now in enumerate(deflection):
            behind = now - state
            state = state + share[t] * np.sign(behind) * np.maximum(np.abs(behind) - self._yield, 0.0)
            late[t] = state
        return deflection + strength * self._size * late


class QuasiLinear(Law):
    """Fung's quasi-linear tissue: an exponential of the load, through a box of relaxation times, all alike.

    Y. C. Fung, Biomechanics: Mechanical Properties of Living Tissues, 2nd ed., Springer, 1993.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        first_s = np.exp(random.uniform(np.log(0.8), np.log(6)))
        tau_s = np.geomspace(first_s, first_s * random.uniform(40, 300), 9)
        self._tau_s, self._yields = in_a_minute(tau_s, np.ones(9))
        self._steep = random.uniform(0.3, 1.5)
        self._size = some(random, len(self.rig.chambers), 0.06, 0.16, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        size = np.minimum(np.abs(deflection), 3.0)
        pull = np.sign(deflection) * np.expm1(self._steep * size) / np.expm1(self._steep)
        late = np.einsum("tnc,n->tc", lagged(path, pull, self._tau_s), self._yields)
        return deflection + strength * self._size * late


class SinkingBacking(Law):
    """Jeffreys' modified Lomnitz law, between logarithm and power, of a backing: each number has its own share of it.

    H. Jeffreys, A modification of Lomnitz's law of creep in rocks, Geophysical J. 1, 1958.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        power = random.uniform(0.1, 0.6) * random.choice([-1.0, 1.0])
        begins_s = np.exp(random.uniform(np.log(1), np.log(15)))
        self._tau_s, self._yields = as_chain(((1 + _TIMES_S / begins_s) ** power - 1) / power, _TIMES_S)
        soft = np.exp(random.normal(0, random.uniform(0.1, 0.5), len(self.rig.observables)))
        self._size = random.uniform(0.05, 0.14) * soft

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        late = np.zeros_like(values)
        for tau_s, share in zip(self._tau_s, self._yields, strict=True):  # one by one, of many markers
            late += share * lagged(path, values - self.rig.at_rest, np.array([tau_s]))[:, 0]
        return values + strength * self._size * late
