"""Laws that no list of usual suspects names."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.exam.tools import history, lagged, pattern, scale, seats


class HotSpot(Law):
    """One busy chamber heats itself at each stroke, and softens what is around it until the heat has gone.

    A. N. Gent, Engineering with Rubber, Hanser, 1992 (heat build-up).
    """

    effect: ClassVar[str] = "hot_spot"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, seat = setting.random, seats(setting.rig)
        self._busy = int(random.integers(len(seat)))
        away = np.linalg.norm(seat - seat[self._busy], axis=1)
        self._near = np.exp(-((away / random.uniform(0.3, 0.8)) ** 2))
        self._cools_s = random.uniform(30, 150)
        self._amount = random.choice([-1.0, 1.0]) * random.uniform(0.08, 0.2)
        warmth = self._warmth(setting.path, setting.rig.deflection(setting.path.kpa))
        self._most = float(warmth.max()) or 1.0

    def _warmth(self, path: Path, deflection: Floats) -> Floats:
        """The heat (T, 1) that the strokes of the busy chamber have left."""
        past = history(path, deflection[:, [self._busy]])
        stroke = np.abs(np.diff(past.load, axis=0, prepend=0.0))
        total = np.cumsum(stroke, axis=0)
        return past.back(total - lagged(past.step_s, total, self._cools_s).real)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """The walls near the busy chamber, softer or stiffer by its heat."""
        warm = self._warmth(path, deflection) / self._most
        return deflection * np.exp(strength * self._amount * warm * self._near)


class SnapThrough(Law):
    """A shell that snaps to its second shape above a total load, and back only below a lower one.

    M. Gomez, D. E. Moulton and D. Vella, Nature Physics, 2017 (snap-through of elastic shells).
    """

    effect: ClassVar[str] = "snap_through"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        load = (path.kpa / setting.rig.high_kpa).mean(axis=1)[path.row]
        self._up, self._down = (
            np.quantile(load, random.uniform(0.55, 0.75)),
            np.quantile(load, random.uniform(0.2, 0.4)),
        )
        self._offset = random.uniform(0.08, 0.2) * scale(setting) * pattern(setting)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """The second shape's difference while the shell is in it."""
        load = (path.kpa / self.rig.high_kpa).mean(axis=1)
        past = history(path, load[:, None])
        told = np.where(past.load[:, 0] > self._up, 1, np.where(past.load[:, 0] < self._down, 0, -1))
        told[0] = 0
        last = np.maximum.accumulate(np.where(told >= 0, np.arange(len(told)), 0))
        return values + strength * past.back(told[last])[:, None] * self._offset


class CompressorCycle(Law):
    """A compressor that cuts in and out: a sawtooth of the supply in clock time reaches the chambers, full ones most.

    A. A. Andronov, A. A. Vitt and S. E. Khaikin, Theory of Oscillators, Pergamon, 1966 (relaxation oscillations).
    """

    effect: ClassVar[str] = "compressor_cycle"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._period_s = random.uniform(15, 70)
        self._rise = random.uniform(0.1, 0.35)
        self._phase = random.uniform(0, 1)
        self._power = random.uniform(1.0, 2.0)
        self._amount = random.uniform(0.04, 0.1) * random.uniform(0.8, 1.2, len(setting.rig.chambers))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        """The pressures with their part of the supply's swing."""
        phase = (path.time_s / self._period_s + self._phase) % 1.0
        saw = np.where(phase < self._rise, phase / self._rise, (1 - phase) / (1 - self._rise)) - 0.5
        load = np.clip(kpa / self.rig.high_kpa, 0.0, 1.5) ** self._power
        return kpa + strength * saw[:, None] * self._amount * load * self.rig.high_kpa


class OrderMemory(Law):
    """Folds that lock in the order in which the chambers filled: whoever was filled last lies on top of the others.

    H. Yasuda and others, Nature, 2021 (mechanical computing: memory of the sequence of loads).
    """

    effect: ClassVar[str] = "order_memory"
    needs: ClassVar[frozenset[str]] = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, seat = setting.random, seats(setting.rig)
        away = np.linalg.norm(seat[:, None] - seat[None], axis=2)
        gain = np.exp(-away / (away.mean() + 1e-6)) * random.uniform(0.5, 1.5, away.shape)
        np.fill_diagonal(gain, 0.0)
        self._gain = gain / gain.sum(axis=0).max() * random.uniform(0.1, 0.25)
        self._felt = random.uniform(0.03, 0.1)

    def _filled(self, path: Path) -> Floats:
        """The number of the actuation (T, C) at which each chamber was last filled, -1 if never in the session."""
        told = path.commanded_kpa / self.rig.high_kpa
        session = np.diff(path.session, prepend=path.session[0] - 1) != 0
        before = np.where(session[:, None], 0.0, np.concatenate([np.zeros((1, told.shape[1])), told[:-1]]))
        index = np.where(told - before > self._felt, np.arange(len(told))[:, None], -1)
        start = np.maximum.accumulate(np.where(session, np.arange(len(told)), 0))[:, None]
        last = np.maximum.accumulate(index, axis=0)
        return np.where(last >= start, last, -1).astype(float)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """Each wall, helped by the neighbours that it lies upon and held by those that lie upon it."""
        filled = self._filled(path)
        order = np.sign(filled[:, :, None] - filled[:, None, :])
        change = np.einsum("tij,ti,ij->tj", order, deflection, self._gain, optimize=True)
        return deflection - strength * change * np.clip(deflection, 0.0, 1.5)
