"""Regulators of the eighth portion: what data sheets, current loops and fast valves make of a set-point."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import either_way, full, some


class FullScaleError(Law):
    """Error of full scale: each regulator has an error of gain and one of zero, as its data sheet says.

    IEC 61298-2, Process measurement and control devices, Part 2: Tests under reference conditions, 2008. Every unit
    has its own errors, in per cent of the full scale and of either sign.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._gain = either_way(setting, 0.03, 0.09)
        self._zero = either_way(setting, 0.0, 0.015)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa + strength * (self._gain * kpa + self._zero * self.rig.high_kpa)


class FallsShortAtTop(Law):
    """Falls short at the top: near its limit a regulator gives less and less of what it is asked for.

    P. Beater, Pneumatic Drives: System Design, Modelling and Control, Springer, 2007. All regulators hang on one
    supply; what is left to open the valve shrinks from some pressure on, a little different for each of them.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._from = np.clip(random.uniform(0.4, 0.65) + random.normal(0, 0.04, count), 0.3, 0.75)
        self._lost = random.uniform(0.25, 0.45) * random.uniform(0.8, 1.2, count)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        over = np.maximum(full(self.rig, kpa) - self._from, 0.0)
        lack = strength * self._lost
        return kpa - self.rig.high_kpa * lack * over / (1 + lack)


class MinimumOnTime(Law):
    """Minimum on-time: a switching valve skips pulses that are too short, and stays open between long ones.

    R. B. van Varseveld and G. M. Bone, Accurate position control of a pneumatic actuator using on/off solenoid valves,
    IEEE/ASME Transactions on Mechatronics 2(3), 1997. So there is a dead zone at the bottom and an early full scale at
    the top. The valves are of one type, with the usual spread.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        period_s = random.uniform(0.02, 0.04)
        spread = random.uniform(0.8, 1.2, (2, count))
        self._opens = random.uniform(0.0012, 0.0022) / period_s * spread[0]
        self._closes = random.uniform(0.0008, 0.0015) / period_s * spread[1]

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        duty = full(self.rig, kpa)
        opens, closes = strength * self._opens, strength * self._closes
        open_share = (np.abs(duty) - opens) / np.maximum(1 - opens - closes, 0.1)
        above = np.maximum(
            np.abs(duty), 1.0
        )  # no valve gives more than it has, but what is asked beyond stays
        return np.sign(duty) * np.clip(open_share, 0.0, above) * self.rig.high_kpa


class LeakyCurrentLoop(Law):
    """Leaky current loop: damp terminals take a share of the 4 to 20 mA that tell the regulators their set-points.

    B. G. Liptak (editor), Instrument Engineers' Handbook, CRC Press, 2003. All regulators sit on one terminal strip.
    As the loop lives at 4 mA, the lowest pressure is missed too; a regulator that cannot draw gives no less than zero.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._lost = random.uniform(0.03, 0.07) * random.uniform(0.8, 1.2, count)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        low, high = self.rig.low_kpa, self.rig.high_kpa
        live = (high - low) / 4  # so much pressure are 4 mA
        got = kpa - np.minimum(strength * self._lost, 0.6) * (kpa - low + live)
        return np.maximum(got, np.minimum(kpa, low))


class TrimmedAtMidScale(Law):
    """Trimmed at mid-scale: some regulators were set right against a gauge at one pressure only, and turn about it.

    A. S. Morris and R. Langari, Measurement and Instrumentation: Theory and Application, Academic Press, 2012. A shut
    valve is shut, so that a vented chamber is vented.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._gain = either_way(setting, 0.08, 0.2, share=0.6)
        self._right = random.uniform(0.35, 0.65)
        self._shut = some(random, count, 0.03, 0.06)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        off = np.abs(load) - self._right
        is_open = np.tanh(load / self._shut)
        return kpa + strength * self._gain * off * is_open * self.rig.high_kpa
