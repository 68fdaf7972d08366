"""Hysteresis of the fifth portion: back stresses, loops that grow with a power of their size, a few creases."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some
from labrig.bench.development._story import finely, plays


class BackStresses(Law):
    """Chaboche: beyond an elastic range the wall flows, and two back stresses follow the flow, each up to its limit.

    J. L. Chaboche, Time-independent constitutive theories for cyclic plasticity, Int. J. Plasticity 2, 1986.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._elastic = random.uniform(0.02, 0.1, count)
        self._fades = np.array([random.uniform(6, 15), random.uniform(1.5, 4)])[:, None]
        self._share = np.array([random.uniform(0.3, 0.7)])
        self._held = some(random, count, 0.05, 0.13, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        moves, _, last = finely(path, full(self.rig, kpa), 0.05)
        flowed = plays(np.cumsum(moves, axis=0), self._elastic[None])[:, 0]
        flow = np.diff(flowed, axis=0, prepend=np.zeros((1, kpa.shape[1])))
        stress, out = np.zeros((2, kpa.shape[1])), np.empty_like(flow)
        for t, step in enumerate(flow):
            way = np.sign(step)
            stress = way + (stress - way) * np.exp(-self._fades * np.abs(step))
            out[t] = self._share * stress[0] + (1 - self._share) * stress[1]
        return kpa - strength * self._held * self.rig.high_kpa * out[last]


class GrowingLoops(Law):
    """Davidenkov: between two turns the wall follows a power of the way since, so that small loops hardly show.

    N. N. Davidenkov, Energy dissipation in vibrations, Zhurnal Tekhnicheskoi Fiziki 8, 1938. Here by plays of which
    there are the more, the wider they are.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        wide = np.linspace(0.03, random.uniform(0.4, 0.6), 9)
        self._wide = np.repeat(wide[:, None], count, axis=1)
        share = wide ** random.uniform(0.3, 2.0)
        self._share = share / share.sum()
        self._lags = some(random, count, 0.15, 0.4, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        behind = deflection - np.einsum("tnc,n->tc", plays(deflection, self._wide), self._share)
        return deflection - strength * self._lags * behind


class FewCreases(Law):
    """Non-ideal relays: each wall has a few creases, which pop out at a load of their own, and back at a lower one.

    A. Visintin, Differential Models of Hysteresis, Springer, 1994.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        creases = int(random.integers(3, 7))
        self._out_at = random.uniform(0.25, 0.9, (creases, count))
        self._back_at = self._out_at - random.uniform(0.1, 0.35, (creases, count))
        self._round = random.uniform(0.02, 0.05)
        size = random.uniform(0.4, 1.0, (creases, count))
        self._size = some(random, count, 0.1, 0.25, 0.9) * size / size.sum(axis=0)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load, state = np.abs(deflection), np.zeros(self._out_at.shape)
        change = np.empty_like(load)
        for t, now in enumerate(load):
            least = np.clip((now - self._out_at) / self._round, 0.0, 1.0)
            most = np.clip((now - self._back_at) / self._round + 1.0, 0.0, 1.0)
            state = np.clip(state, least, most)
            usual = np.clip((now - self._back_at) / (self._out_at - self._back_at), 0.0, 1.0)
            change[t] = np.sum(self._size * (state - usual), axis=0)
        return deflection + strength * np.sign(deflection) * change
