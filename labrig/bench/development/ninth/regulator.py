"""Regulators of the ninth portion: span, zero, overlap, a bowed sensor, an exhaust that holds air back."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import either_way, full


class SpanError(Law):
    """Span error: each sensor has its own sensitivity, and its regulator holds too much or too little.

    J. Fraden, Handbook of Modern Sensors: Physics, Designs, and Applications, Springer, 2010 (calibration
    error). The span follows a common reference voltage too, so a part of the error is the same in all.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        reference = random.uniform(0.02, 0.06) * random.choice([-1.0, 1.0])
        self._gain = reference + either_way(setting, 0.02, 0.08)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return np.maximum(1 + strength * self._gain, 0.1) * kpa


class ZeroShift(Law):
    """Zero shift: the bridge of each sensor is out of balance, so every pressure is off by the same amount.

    T. G. Beckwith, R. D. Marangoni, J. H. Lienhard, Mechanical Measurements, Addison-Wesley, 1993. A
    regulator with nothing but an exhaust below it cannot go under its lower limit, however it errs.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._zero = either_way(setting, 0.02, 0.06)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        got = kpa + strength * self._zero * self.rig.high_kpa
        return np.maximum(got, np.minimum(kpa, self.rig.low_kpa))


class SpoolOverlap(Law):
    """Spool overlap: the lands of a valve cover its ports, and the first part of a command does nothing.

    G. Tao and P. V. Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, Wiley,
    1996: the dead zone u = v - b beyond b, nothing within. The valves are of one type, with some spread; b
    differs by side.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._right = random.uniform(0.04, 0.09) * random.uniform(0.75, 1.25, count)
        self._left = self._right * random.uniform(0.8, 1.2, count)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        above = np.maximum(kpa - strength * self._right * self.rig.high_kpa, 0.0)
        below = np.minimum(kpa + strength * self._left * self.rig.high_kpa, 0.0)
        return above + below


class BowedSensor(Law):
    """Bowed sensor: right at both ends of its range, a diaphragm's signal bows in between.

    ISA-S51.1, Process Instrumentation Terminology, 1979 (terminal-based non-linearity). The bow is a
    parabola, the same way in sensors of one make; a regulator follows its sensor, and so holds a bowed
    pressure.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._bow = random.uniform(0.03, 0.06) * random.choice([-1.0, 1.0]) * random.uniform(0.6, 1.4, count)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        inside = np.clip(np.abs(load), 0.0, 1.0)
        return kpa + strength * self.rig.high_kpa * self._bow * 4 * np.sign(load) * inside * (1 - inside)


class ExhaustHolds(Law):
    """Exhaust holds: a check valve or silencer shuts before a chamber is empty, and air stays in.

    P. Beater, Pneumatic Drives: System Design, Modelling and Control, Springer, 2007. Pressures above what
    the valve needs to open are right; below it all settle there. A vacuum line goes round it.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._opens = random.uniform(0.05, 0.12) * random.uniform(0.7, 1.3, count)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        lacks = np.maximum(strength * self._opens - np.maximum(load, 0.0), 0.0)
        not_sucked = np.clip(1 + load / 0.02, 0.0, 1.0)
        return kpa + lacks * not_sucked * self.rig.high_kpa
