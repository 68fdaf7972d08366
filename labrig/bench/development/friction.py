"""Friction: sliding parts hold back whatever moves, at once and in full when the direction turns."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some
from labrig.bench.development._story import pauses, plays, steps


def sliding(drive: Floats, give: Floats) -> Floats:
    """Which way each part slides, (T, C) from -1 to 1, turning within 2 `give` (C,) of the drive."""
    return (drive - plays(drive, give[None])[:, 0]) / give


class Coulomb(Law):
    """Coulomb friction: a constant force against the last motion, after a hardly visible give.

    C. A. Coulomb, Théorie des machines simples, Mémoires de Mathématique et de Physique, Paris, 1785.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._give = setting.random.uniform(0.004, 0.012, count)
        self._held = some(setting.random, count, 0.02, 0.06)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        way = sliding(full(self.rig, kpa), self._give)
        return kpa - strength * self._held * self.rig.high_kpa * way


class Dahl(Law):
    """Dahl friction: asperities bend like springs before they slide, so that the force turns exponentially.

    P. R. Dahl, A solid friction model, Aerospace Corporation TOR-0158(3107-18)-1, 1968.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._give = setting.random.uniform(0.01, 0.04, count)
        self._held = some(setting.random, count, 0.02, 0.06)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        move = steps(deflection)
        stays, way = np.exp(-np.abs(move) / self._give), np.sign(move)
        state = np.zeros(deflection.shape[1])
        out = np.empty_like(deflection)
        for t in range(len(out)):
            state = way[t] + (state - way[t]) * stays[t]
            out[t] = state
        return deflection - strength * self._held * out


class LuGre(Law):
    """LuGre friction: bristles that carry more when slow than when fast (Stribeck), and keep their bend at rest.

    C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, A new model for control of systems with friction, IEEE
    Trans. Automatic Control 40, 1995.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._give = setting.random.uniform(0.008, 0.03, count)
        self._slow_per_s = setting.random.uniform(0.05, 0.6, count)
        self._sticks = setting.random.uniform(1.2, 1.8, count)
        self._held = some(setting.random, count, 0.02, 0.05)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        move = steps(full(self.rig, kpa))
        speed = np.abs(move) / np.maximum(pauses(path), 1e-3)[:, None]
        bears = 1 + (self._sticks - 1) * np.exp(-((speed / self._slow_per_s) ** 2))
        stays, limit = np.exp(-np.abs(move) / (self._give * bears)), np.sign(move) * bears
        state = np.zeros(kpa.shape[1])
        out = np.empty_like(kpa)
        for t in range(len(out)):
            state = limit[t] + (state - limit[t]) * stays[t]
            out[t] = state
        return kpa - strength * self._held * self.rig.high_kpa * out


class LoadedCoulomb(Law):
    """Friction of a braided sleeve: against the last motion, in proportion to the pressure that presses the threads.

    B. Tondu, P. Lopez, Modeling and control of McKibben artificial muscle robot actuators, IEEE Control Systems
    Magazine 20, 2000.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._give = setting.random.uniform(0.005, 0.02, count)
        self._held = some(setting.random, count, 0.005, 0.02)
        self._loaded = some(setting.random, count, 0.04, 0.12)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        drive = full(self.rig, kpa)
        held = self._held + self._loaded * np.maximum(drive, 0.0)
        return kpa - strength * self.rig.high_kpa * held * sliding(drive, self._give)
