"""Hysteresis of the eighth portion: slack, two curves, filled rubber, a knitted cover, and folds that pop open."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some
from labrig.bench.development._story import plays, steps


class Backlash(Law):
    """Backlash: each wall hangs on its chamber with some slack, and first has to cross it after every reversal.

    M. Nordin, P.-O. Gutman, Controlling mechanical systems with backlash: a survey, Automatica 38, 2002.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._slack = some(setting.random, len(self.rig.chambers), 0.03, 0.07)  # shares of the full motion

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return plays(deflection, strength * self._slack[None])[:, 0]


class UpAndDownCurves(Law):
    """Up and down curves: as data sheets draw it, the way up lies below the way down, furthest in mid-range.

    ANSI/ISA-51.1, Process Instrumentation Terminology, Instrument Society of America, 1979. After a reversal the way
    goes over from one curve to the other within a share of the range.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._half = random.uniform(0.03, 0.06) * random.uniform(0.9, 1.1, len(rig.chambers))
        self._goes_over = random.uniform(0.05, 0.2)
        self._low = rig.low_kpa / rig.high_kpa

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        step = steps(load)
        left = np.exp(-np.abs(step) / self._goes_over)
        side = np.zeros_like(load)
        state = np.zeros(load.shape[1])
        for i, way in enumerate(np.sign(step)):
            state = way + (state - way) * left[i]
            side[i] = state
        lens = 4 * (load - self._low) * (1 - load) / (1 - self._low) ** 2
        return deflection - strength * self._half * side * np.clip(lens, 0.0, 1.0)


class BergSpring(Law):
    """Spring of filled rubber: beside its elastic force is one of friction, which builds up smoothly from each turn.

    M. Berg, A model for rubber springs in the dynamic analysis of rail vehicles, Proc. Institution of Mechanical
    Engineers F 211, 1997. Half of the greatest friction is there after the travel `x2`.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._most = random.uniform(0.035, 0.07) * random.uniform(0.85, 1.15, count)
        self._travel = random.uniform(0.04, 0.15)  # x2, one compound for all

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        way = np.sign(steps(load))
        out = np.empty_like(load)
        turn, at_turn, going = np.zeros(load.shape[1]), np.zeros(load.shape[1]), np.zeros(load.shape[1])
        last, force = turn.copy(), turn.copy()
        for i in range(len(load)):
            turns = (way[i] != 0) & (way[i] != going)
            turn, at_turn = np.where(turns, last, turn), np.where(turns, force, at_turn)
            going = np.where(turns, way[i], going)
            gone = np.abs(load[i] - turn)
            room = 1 - going * at_turn  # up to the greatest friction on this side
            force = at_turn + going * room * gone / (self._travel * room + gone + 1e-12)
            last = load[i]
            out[i] = force
        return deflection - strength * self._most * out


class CoverOfJersey(Law):
    """Cover of jersey: one knitted sleeve around all chambers, whose yarns rub where they cross as it is stretched.

    S. Kawabata, The Standardization and Analysis of Hand Evaluation, Textile Machinery Society of Japan, 1980. Yarns
    give way at stretches of their own; what the sleeve lags it takes from all chambers under it.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        covers = some(random, count, 0.5, 1.0, 0.8)
        self._covers = covers / np.linalg.norm(covers)
        self._gives_way = random.uniform(0.18, 0.28) * np.array([1.0, 1.8, 3.0])  # stretches
        self._stiff = random.uniform(0.3, 0.5) * random.dirichlet([4.0, 3.0, 2.0])

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        stretch = deflection @ self._covers
        slipped = plays(stretch[:, None], self._gives_way[:, None])[:, :, 0]
        pull = (stretch[:, None] - slipped) @ self._stiff
        # beside walls of stiffness 1 the sleeve takes its part of the load
        part = strength / (1 + strength * self._stiff.sum())
        return deflection - part * pull[:, None] * self._covers


class FoldsThatPop(Law):
    """Folds that pop: each fold of a bellows opens at one pressure, and folds up again only at a lower one.

    I. D. Mayergoyz, Mathematical Models of Hysteresis, Springer, 1991, for many such switches; some chambers only.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        folds = int(random.integers(5, 13))
        gap = random.uniform(0.15, 0.35) * random.uniform(0.8, 1.2, (folds, count))
        self._close = random.uniform(0.05, 0.5, (folds, count))
        self._open = self._close + gap
        each = random.dirichlet(np.full(folds, 8.0), count).T
        self._moves = some(random, count, 0.2, 0.35, 0.6) * each

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        state = np.zeros_like(self._open)
        more = np.empty_like(deflection)
        for i, now in enumerate(load):
            state = np.where(now >= self._open, 1.0, np.where(now <= self._close, 0.0, state))
            usual = np.clip((now - self._close) / (self._open - self._close), 0.0, 1.0)
            more[i] = np.sum(self._moves * (state - usual), axis=0)
        return deflection + strength * more
