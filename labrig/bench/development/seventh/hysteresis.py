"""Hysteresis of the seventh portion: between two limiting branches, and from one asymptote to the next."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some
from labrig.bench.development._story import finely, steps


class TellinensBranches(Law):
    """Tellinen: between a branch up and one down the slope is that of the branch ahead, by how far the other one is.

    J. Tellinen, A simple scalar model for magnetic hysteresis, IEEE Trans. Magnetics 34, 1998.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._middle = random.uniform(0.2, 0.6) * random.uniform(0.9, 1.1, count)
        self._apart, self._wide = random.uniform(0.05, 0.2, count), random.uniform(0.2, 0.6, count)
        self._held = some(random, count, 0.1, 0.25, 0.9)

    def _branches(self, load: Floats) -> tuple[Floats, Floats]:
        """The branch on the way up, and the one on the way down."""
        at = load - np.where(load < 0, -1.0, 1.0) * self._middle * np.tanh(np.abs(load) / 0.1)
        up, down = ((at + side * self._apart) / self._wide for side in (-1.0, 1.0))
        return np.tanh(up), np.tanh(down)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        moves, _, last = finely(path, full(self.rig, kpa), 0.02)
        load = np.cumsum(moves, axis=0)
        low, high = self._branches(load)
        at, out = 0.5 * np.add(*self._branches(np.zeros(kpa.shape[1]))), np.empty_like(load)
        before_low, before_high = self._branches(np.zeros(kpa.shape[1]))
        for t, move in enumerate(moves):
            wide = np.maximum(before_high - before_low, 1e-6)
            rise = (low[t] - before_low) * (before_high - at) / wide
            fall = (high[t] - before_high) * (at - before_low) / wide
            at = np.clip(at + np.where(move > 0, rise, fall), low[t], high[t])
            before_low, before_high = low[t], high[t]
            out[t] = at - 0.5 * (low[t] + high[t])
        return kpa + strength * self._held * self.rig.high_kpa * out[last]


class FromAsymptoteToAsymptote(Law):
    """Menegotto-Pinto: after each turn an elastic line bends into the yield line, the rounder, the more it had yielded.

    M. Menegotto, P. E. Pinto, Method of analysis for cyclically loaded reinforced concrete plane frames, IABSE
    Symposium on Resistance and Ultimate Deformability of Structures, Lisbon, 1973.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._yields_at = random.uniform(0.06, 0.2) * random.uniform(0.9, 1.1, count)
        self._sharp, self._rounder = random.uniform(3.0, 12.0), random.uniform(0.5, 0.9)
        self._held = some(random, count, 0.05, 0.12, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        count = deflection.shape[1]
        way, turn, gone, force = np.ones(count), np.zeros(count), np.zeros(count), np.zeros(count)
        power, out = np.full(count, self._sharp), np.empty_like(deflection)
        for t, move in enumerate(steps(deflection)):
            turned = move * way < 0
            flown = np.maximum(gone / self._yields_at - 1, 0.0)
            rounder = self._sharp * (1 - self._rounder * flown / (0.5 + flown))
            power = np.where(turned, np.maximum(rounder, 1.0), power)
            way, turn = np.where(turned, -way, way), np.where(turned, force, turn)
            gone = np.where(turned, 0.0, gone) + np.abs(move)
            knee = self._yields_at * np.maximum(np.abs(way - turn), 1e-6)
            along = gone / knee
            force = turn + (way - turn) * along / (1 + along**power) ** (1 / power)
            out[t] = force
        return deflection - strength * self._held * out
