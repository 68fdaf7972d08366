"""Hysteresis of the tenth portion: two S-shaped branches, and a surface within which the wall yields ever more."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, pattern, span
from labrig.bench.development._story import finely


class TwoSBranches(Law):
    """Takács: the way up and the way down are one hyperbolic tangent, set apart; from each turn a new one starts.

    J. Takács, A phenomenological mathematical model of hysteresis, COMPEL 20(4), 2001. The branch from a turn is the
    way's own, shifted up or down so that it begins there, and the shift is used up as the motion goes on.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._middle = random.uniform(0.35, 0.6) * random.uniform(0.9, 1.1, count)
        self._steep = random.uniform(2.0, 4.0)
        self._apart = random.uniform(0.08, 0.16) * random.uniform(0.85, 1.15, count)  # half of it, in load
        self._size = random.uniform(0.25, 0.45)
        self._used_up = random.uniform(0.15, 0.4)

    def _branch(self, load: Floats, way: Floats) -> Floats:
        """The branch (C,) for a direction (C,), as a departure from the curve in between."""
        at = self._steep * (load - self._middle)
        off = self._steep * self._apart * way
        return self._size * (np.tanh(at - off) - np.tanh(at)) / self._steep

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        step, _, where = finely(path, load, 0.02)
        at = np.zeros(load.shape[1])
        way = np.ones(load.shape[1])
        shift = -self._branch(at, way)  # it begins on the curve in between
        begins = np.empty_like(step)
        for i in range(len(step)):
            turns = step[i] * way < 0
            here = self._branch(at, way) + shift
            way = np.where(turns, -way, way)
            shift = np.where(turns, here - self._branch(at, way), shift)
            shift = shift * np.exp(-np.abs(step[i]) / self._used_up)
            at = at + step[i]
            begins[i] = self._branch(at, way) + shift
        return deflection + strength * begins[where]


class WithinABound(Law):
    """Dafalias-Popov: a liner around all yields from the first on, the more, the nearer its force is to an outer bound.

    Y. F. Dafalias, E. P. Popov, A model of nonlinearly hardening materials for complex loading, Acta Mechanica 21,
    1975. Its plastic modulus goes with the distance to the bound, over how much of it has been used up since the last
    turn. One liner feels all chambers together, and holds back the motion of the whole.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        count = len(rig.chambers)
        self._felt = random.dirichlet(np.full(count, 6.0)) * np.sqrt(count)
        self._bound = random.uniform(0.12, 0.25)
        self._hard = random.uniform(0.15, 0.6)
        self._way = random.uniform(0.8, 1.5) * span(rig) * np.sqrt(len(rig.observables)) * pattern(rig)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        step, _, where = finely(path, (deflection @ self._felt)[:, None], 0.01)
        bound, force, way, first = self._bound, 0.0, 1.0, self._bound
        held = np.empty(len(step))
        for i, go in enumerate(step[:, 0].tolist()):
            if go * way < 0:
                way = -way
                first = bound - way * force
            apart = max(bound - way * force, 0.0)
            used_up = max(1 - apart / first, 1e-9)
            plastic = self._hard * apart / bound / used_up
            force = min(
                max(force + go * plastic / (1 + plastic), -bound), bound
            )  # with an elastic part in series
            held[i] = force
        return values - strength * held[where, None] * self._way
