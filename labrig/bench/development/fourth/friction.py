"""Friction of the fourth portion: a peak before it slides, rubber under load, wells that it drops into."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some
from labrig.bench.development._story import steps
from labrig.bench.development.friction import sliding


class PeakBeforeSliding(Law):
    """Bliman-Sorine: two spring-like contacts, one fast and one slow and opposed, so that the force peaks as it slides.

    P.-A. Bliman, M. Sorine, Easy-to-use realistic dry friction models for automatic control, Proc. 3rd European Control
    Conference, 1995.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        fast = random.uniform(0.006, 0.02, count)
        self._give = np.stack([fast, fast * random.uniform(4, 12)])
        self._peak = random.uniform(0.4, 1.2)
        self._held = some(random, count, 0.02, 0.05)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        move = steps(full(self.rig, kpa))
        stays, way = np.exp(-np.abs(move)[:, None] / self._give), np.sign(move)
        state, held = np.zeros(self._give.shape), np.empty_like(kpa)
        for t in range(len(held)):
            state = way[t] + (state - way[t]) * stays[t]
            held[t] = (1 + self._peak) * state[0] - self._peak * state[1]
        return kpa - strength * self._held * self.rig.high_kpa * held


class RubberUnderLoad(Law):
    """Schallamach: rubber holds back by the area in contact, so by the power two thirds of what presses it on.

    A. Schallamach, The load dependence of rubber friction, Proc. Physical Society B 65, 1952.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._give = random.uniform(0.006, 0.02, count)
        self._own, self._before = random.uniform(0.5, 1.0), random.uniform(0.02, 0.1)
        self._held = some(random, count, 0.03, 0.09)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        drive = full(self.rig, kpa)
        size = np.abs(drive)
        presses = self._before + self._own * size + (1 - self._own) * size.mean(axis=1, keepdims=True)
        held = self._held * presses ** (2 / 3) * sliding(drive, self._give)
        return kpa - strength * self.rig.high_kpa * held


class RowOfWells(Law):
    """Prandtl's model of dry friction: a part on a spring sits in one well of a row, and drops into the next.

    L. Prandtl, Ein Gedankenmodell zur kinetischen Theorie der festen Körper, Zeitschrift für angewandte Mathematik und
    Mechanik 8, 1928. The wells are parabolas here.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._apart = random.uniform(0.015, 0.05, count)
        self._first = random.uniform(-0.5, 0.5, count) * self._apart
        self._holds = some(random, count, 0.02, 0.06)  # how far the spring is stretched before the part drops

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        holds = strength * self._holds
        most = 0.5 * self._apart + holds
        well, behind = self._first.copy(), np.empty_like(deflection)
        for t, now in enumerate(deflection):
            off = now - well
            wells = np.ceil(np.maximum(np.abs(off) - most, 0.0) / self._apart)
            well = well + np.sign(off) * wells * self._apart
            behind[t] = now - well
        return deflection - holds / most * behind
