"""Laws outside the library: real phenomena that none of its names describes."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import columns, full, smooth_field, some, span, spread
from labrig.bench.development._story import pauses, steps


class CyclicSoftening(Law):
    """Fatigue: a wall softens with the number of cycles that it has been through, fast at first.

    W. V. Mars, A. Fatemi, A literature survey on fatigue analysis approaches for rubber, Int. J. Fatigue 24, 2002.
    """

    effect = "cyclic_softening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        load = full(self.rig, setting.path.kpa)
        self._cycles = 0.5 * np.abs(steps(load)).sum(axis=0).max()
        self._power = setting.random.uniform(0.4, 0.9)
        self._softer = some(setting.random, len(self.rig.chambers), 0.08, 0.25, 0.6)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        cycles = np.cumsum(0.5 * np.abs(steps(full(self.rig, kpa))), axis=0)
        return deflection * np.exp(strength * self._softer * (cycles / self._cycles) ** self._power)


class SnapThrough(Law):
    """Bistable dome: under the load of all chambers together a part of the body snaps over, and back at a lower one.

    R. von Mises, Über die Stabilitätsprobleme der Elastizitätstheorie, Z. angewandte Mathematik und Mechanik 3, 1923.
    """

    effect = "snap_through"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        load = full(self.rig, setting.path.kpa[setting.path.row]).mean(axis=1)
        self._over = float(np.quantile(load, random.uniform(0.65, 0.85)))
        self._back = min(float(np.quantile(load, random.uniform(0.2, 0.45))), 0.9 * self._over)
        size = span(self.rig) * random.uniform(0.15, 0.5)
        marked = columns(self.rig).max(initial=-1) >= 0
        self._jump = size * (
            spread(self.rig, smooth_field(setting)) if marked else random.choice([-1.0, 1.0])
        )

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        load = full(self.rig, path.kpa).mean(axis=1)
        switched = np.where(load >= self._over, 1, np.where(load <= self._back, 0, -1))
        last = np.maximum.accumulate(np.where(switched >= 0, np.arange(len(load)), -1))
        over = np.where(last >= 0, switched[last], 0)
        return values + strength * over[:, None] * self._jump


class OrderMemory(Law):
    """Memory of order: the chamber that moved last lies on top of the others, and moves the surface by more than they.

    H. Bense, M. van Hecke, Complex pathways and memory in compressed corrugated sheets, PNAS 118, 2021.
    """

    effect = "order_memory"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._gain = setting.random.uniform(0.05, 0.2) * setting.random.uniform(0.5, 1.5, count)
        self._fades = setting.random.uniform(0.2, 0.7)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        size = np.abs(steps(full(self.rig, path.commanded_kpa)))
        when = np.arange(len(size))[:, None] + 0.5 * size / (
            1 + size.max()
        )  # of those moved at once the farthest
        last = np.maximum.accumulate(np.where(size > 0, when, -1.0), axis=0)
        rank = np.argsort(np.argsort(-last, axis=1, kind="stable"), axis=1)
        on_top = self._fades**rank
        on_top -= on_top.mean(axis=1, keepdims=True)
        return deflection * np.exp(np.minimum(strength * self._gain * on_top, 2.0))


class CompressorCycle(Law):
    """Cycle of the supply: a compressor fills its tank fast and lets it empty slowly, and the regulators pass it on.

    A. Parr, Hydraulics and Pneumatics, 3rd ed., Butterworth-Heinemann, 2011.
    """

    effect = "compressor_cycle"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._period_s, self._phase = np.exp(random.uniform(np.log(17), np.log(140))), random.uniform(0, 1)
        self._filling = random.uniform(0.1, 0.4)
        self._passed = random.uniform(0.03, 0.1) * random.uniform(0.7, 1.3, len(self.rig.chambers))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        phase = (path.time_s / self._period_s + self._phase) % 1.0
        tank = np.interp(phase, [0.0, self._filling, 1.0], [-1.0, 1.0, -1.0])[:, None]
        return kpa * np.exp(strength * self._passed * tank)


class HealingMullins(Law):
    """Mullins effect that heals: a wall is softer below the farthest it has been, and forgets that within minutes.

    D. E. Hanson, M. Hawley, R. Houlton et al., Stress softening experiments in silica-filled polydimethylsiloxane
    provide insight into a mechanism for the Mullins effect, Polymer 46, 2005.
    """

    effect = "healing_mullins"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._heals_s = np.exp(setting.random.uniform(np.log(60), np.log(900)))
        self._softer = some(setting.random, len(self.rig.chambers), 0.15, 0.5, 0.8)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        stays = np.exp(-pauses(path) / self._heals_s)
        farthest = np.zeros(deflection.shape[1])
        below = np.empty_like(deflection)
        for t, now in enumerate(deflection):
            farthest = np.maximum(farthest * stays[t], now)
            below[t] = farthest - now
        return deflection * (1 + strength * self._softer * below)
