"""Regulators of the fifth portion: span and zero, a calibration of the third degree, a potentiometer under load."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import either_way, full, some


class SpanAndZero(Law):
    """Span and zero: each regulator was adjusted by hand, and has both a factor and a zero of its own a little wrong.

    IEC 60770-1, Transmitters for use in industrial-process control systems: methods for performance evaluation, 1999;
    from laboratory experience. Some zeros show only while the valve is open.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._factor = either_way(setting, 0.02, 0.1, 0.9)
        self._zero = either_way(setting, 0.01, 0.05, 0.8)
        self._shut = random.random(count) < 0.5

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        open_ = np.where(self._shut, np.tanh(np.abs(load) / 0.03), 1.0)
        return kpa + strength * self.rig.high_kpa * (self._factor * load + self._zero * open_)


class CubicCalibration(Law):
    """Calibration of the third degree: a cubic through a few bad readings, which waves in between and off at the ends.

    P. R. Bevington, Data Reduction and Error Analysis for the Physical Sciences, McGraw-Hill, 1969; from laboratory
    experience.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        seen = np.sort(random.uniform(0.02, 0.98, (count, int(random.integers(5, 9)))), axis=1)
        off = random.normal(size=seen.shape) * some(random, count, 0.02, 0.06, 0.9)[:, None]
        self._cubic = np.array([np.polyfit(x, y, 3) for x, y in zip(seen, off, strict=True)]).T  # (4, C)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        low, high = self.rig.low_kpa, self.rig.high_kpa
        x = np.clip((kpa - low) / (high - low), -0.05, 1.05)
        off = np.clip(
            ((self._cubic[0] * x + self._cubic[1]) * x + self._cubic[2]) * x + self._cubic[3], -0.3, 0.3
        )
        return kpa + strength * (high - low) * off


class LoadedPotentiometer(Law):
    """Potentiometer under load: what reads the set-point draws current, so that it sags most at two thirds of the way.

    E. O. Doebelin, Measurement Systems: Application and Design, McGraw-Hill, 1966.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._draws = random.uniform(0.2, 0.8) * some(
            random, count, 0.7, 1.3, 0.9
        )  # resistance over the reader's

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        low, high = self.rig.low_kpa, self.rig.high_kpa
        x = np.clip((kpa - low) / (high - low), 0.0, 1.0)
        draws = strength * self._draws * x * (1 - x)
        return kpa - (high - low) * x * draws / (1 + draws)
