"""Hysteresis of the twelfth portion: aiming at a peak, a regulator's own, Rayleigh's loops, a gear."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full
from labrig.bench.development._story import finely, plays
from labrig.bench.development.twelfth._sensors import added, any_sensor, sensors, usual


class AimsAtItsPeak(Law):
    """Clough-Johnston: after each turn a wall unloads steeply, and then aims straight at the farthest that it has been.

    R. W. Clough, S. B. Johnston, Effect of stiffness degradation on earthquake ductility requirements, Japan Earthquake
    Engineering Symposium, 1966. So the first way out is stiffer than any later one, and small loops are slanted more.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._size = random.uniform(0.04, 0.09) * random.uniform(0.8, 1.2, count)
        self._yields = random.uniform(0.05, 0.15) * random.uniform(0.8, 1.2, count)
        self._hardens = random.uniform(0.05, 0.4)  # per full deflection
        self._degrades = random.uniform(0.0, 0.5)

    def _force(self, step: Floats, yields: float) -> Floats:
        """The force (N,) of one wall along its steps (N,)."""
        far, most = [yields, yields], [1.0, 1.0]  # the peaks, up and down
        at = force = 0.0
        out = np.empty(len(step))
        for i, move in enumerate(step.tolist()):
            if move:
                side, way = (0, 1.0) if move > 0 else (1, -1.0)
                unloads = (max(far) / yields) ** -self._degrades / yields
                before, at = at, at + move
                if way * force < 0:  # back to no force first
                    back = min(abs(force) / unloads, abs(move))
                    force += way * unloads * back
                    before += way * back
                left = way * (at - before)
                if left > 0 and way * force >= -1e-12:
                    gap = far[side] - way * before
                    if left < gap:
                        force += way * (most[side] - way * force) * left / gap
                    else:
                        far[side] = way * at
                        most[side] += self._hardens * max(left - max(gap, 0.0), 0.0)
                        force = way * most[side]
            out[i] = force
        return out

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        step, _, where = finely(path, deflection, 0.05)
        each = [self._force(step[:, c], float(y)) for c, y in enumerate(self._yields)]
        return deflection - strength * self._size * np.stack(each, axis=1)[where]


class RegulatorsOwnHysteresis(Law):
    """A regulator's own hysteresis: what it holds is behind on the way up and ahead on the way down, by its data sheet.

    ISO 6953-1, Pneumatic fluid power, Compressed air pressure regulators, 2015, which asks makers to state it, in per
    cent of the range. Its diaphragm and spool rub and its magnet remembers: narrow plays and wide ones, one each.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        wide = random.uniform(0.01, 0.03) * random.uniform(0.6, 1.4, count)
        self._half = np.stack([wide, wide * random.uniform(3.0, 8.0)])
        self._share = random.uniform(0.5, 0.85)  # that goes through the narrow one

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        behind = plays(load, strength * self._half)
        lags = self._share * (behind[:, 0] - load) + (1 - self._share) * (behind[:, 1] - load)
        return kpa + lags * self.rig.high_kpa


class RayleighsLoops(Law):
    """Rayleigh: between two turns a sensor's signal is a parabola of the load, so that its loops grow by their square.

    Lord Rayleigh, On the behaviour of iron and steel under the operation of feeble magnetic forces, Philosophical
    Magazine 23, 1887; bend sensors, load cells and piezos do so. Plays of all widths, alike, make just such parabolas.
    One sensor has it, and the rig itself has not.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._which = any_sensor(setting)
        self._far = float(usual(rig, setting.path)[self._which])
        self._share = random.uniform(0.25, 0.5)
        self._half = (np.arange(16)[:, None] + 0.5) / 16 * random.uniform(0.8, 1.4)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        way = (values[:, [self._which]] - self.rig.at_rest[self._which]) / self._far
        part = plays(way, self._half).mean(axis=1)[:, 0]
        line = float(
            part @ way[:, 0] / max(float(way[:, 0] @ way[:, 0]), 1e-12)
        )  # the calibration took it out
        return added(values, self._which, strength * self._share * self._far * (part - line * way[:, 0]))


class BacklashInTheGear(Law):
    """Backlash in a gear: each encoder sits behind a small gear of its own, and has to cross its play after each turn.

    G. Tao, P. V. Kokotović, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, Wiley, 1996. The joint
    itself is where it should be, and load cells know nothing of it.
    """

    effect = "hysteresis"
    needs = frozenset({"angle"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._angles = sensors(self.rig, "deg")
        far = usual(self.rig, setting.path)[self._angles]
        has = random.random(len(far)) < 0.7
        has[random.integers(len(far))] = True
        self._half = np.where(has, random.uniform(0.04, 0.12, len(far)), 0.0) * far

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        way = values[:, self._angles] - self.rig.at_rest[self._angles]
        behind = plays(way, strength * self._half[None])[:, 0]
        return added(values, self._angles, behind - way)
