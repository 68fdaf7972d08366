"""Hysteresis of the third portion: ramps in place of relays, Masing's branches of the whole body, intrinsic time."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, pattern, reached, some, span
from labrig.bench.development._story import steps


class KrasnoselskiiPokrovskii(Law):
    """Krasnosel'skii-Pokrovskii: a crowd of ramps, each between a line up and a line down, with a way in between.

    H. T. Banks, A. J. Kurdila, G. Webb, Identification of hysteretic control influence operators representing smart
    actuators I: formulation, Mathematical Problems in Engineering 3, 1997.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        size = (40, count)
        self._ramp = random.uniform(0.15, 0.5)
        half = np.abs(random.normal(0, random.uniform(0.08, 0.2), size))
        centre = random.uniform(0.0, 1.0, size)
        self._up, self._down = centre + half, centre - half
        self._share = some(random, count, 0.3, 0.7, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        drive = np.abs(deflection)[:, None]
        rising, falling = self._line(drive - self._up), self._line(drive - self._down)
        without = self._line(drive - 0.5 * (self._up + self._down)).mean(axis=1)
        state, crowd = np.zeros(self._up.shape), np.empty_like(deflection)
        for t in range(len(crowd)):
            state = np.maximum(np.minimum(state, falling[t]), rising[t])
            crowd[t] = state.mean(axis=0)
        return deflection + strength * self._share * np.sign(deflection) * (crowd - without)

    def _line(self, x: Floats) -> Floats:
        return np.clip(0.5 + x / self._ramp, 0.0, 1.0)


class MasingBranches(Law):
    """Masing's rule: after each turn the body follows its first curve, twice as large, until the loop closes.

    G. Masing, Eigenspannungen und Verfestigung beim Messing, Proc. 2nd Int. Congress for Applied Mechanics, Zürich,
    1926. The whole body, along its main way, is held back by what this makes of the way that it has gone.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._way = pattern(self.rig)
        self._full = span(self.rig) * np.sqrt(len(self.rig.observables))
        self._knee = random.uniform(0.1, 0.4) * max(float(reached(self.rig, setting.path).max()), 0.3)
        self._power = random.uniform(0.35, 0.7)
        self._held = random.uniform(0.05, 0.14)

    def _first(self, way: float) -> float:
        """The first curve: as steep as 1 at the start, and then like a power of the way."""
        return float(np.sign(way) * ((1 + abs(way)) ** self._power - 1) / self._power)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        along = (values - self.rig.at_rest) @ self._way / (self._full * self._knee)
        held = self._branches(along)
        return values - strength * self._held * self._full * held[:, None] * self._way

    def _branches(self, drive: Floats) -> Floats:
        turns: list[tuple[float, float]] = [(0.0, 0.0)]  # where branches began, oldest first; all nested
        now, force, way, out = 0.0, 0.0, 0.0, np.empty(len(drive))
        for t, then in enumerate(drive.tolist()):
            move = then - now
            if abs(move) > 1e-9:
                if move * way < 0:
                    turns.append((now, force))
                way = move
                while len(turns) > 2 and (then - turns[-2][0]) * move > 0:
                    del turns[-2:]  # the loop has closed: the branch before goes on
                if len(turns) == 2 and abs(then) > abs(turns[1][0]):
                    del turns[1:]
                at, began = turns[-1]
                force = self._first(then) if len(turns) == 1 else began + 2 * self._first(0.5 * (then - at))
                now = then
            out[t] = force
        return out


class Endochronic(Law):
    """Endochronic theory: memory fades with the length of the way gone, and the body hardens along it.

    K. C. Valanis, A theory of viscoplasticity without a yield surface, Archives of Mechanics 23, 1971.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        load = full(self.rig, setting.path.kpa)
        self._whole = max(float(np.abs(steps(load)).sum(axis=0).max()), 1.0)
        fast, slow = random.uniform(4, 8), random.uniform(1, 2.5)
        self._fades = np.array([[fast], [slow]]) * random.uniform(0.8, 1.2, count)
        self._share = random.dirichlet([2.0, 2.0])[:, None]
        self._hardens = random.uniform(0.0, 0.8)
        self._held = some(random, count, 0.06, 0.15, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        move = steps(full(self.rig, kpa))
        gone = np.cumsum(np.abs(move), axis=0)
        slower = 1 + self._hardens * gone / self._whole
        stays = np.exp(-self._fades * (np.abs(move) / slower)[:, None])  # (T, 2, C)
        way, state, held = np.sign(move), np.zeros(self._fades.shape), np.empty_like(kpa)
        for t in range(len(held)):
            state = way[t] + (state - way[t]) * stays[t]
            held[t] = np.sum(self._share * state, axis=0) * slower[t]
        return kpa - strength * self._held * self.rig.high_kpa * held
