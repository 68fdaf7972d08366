"""Regulators of the third portion: valve characteristics, errors about a fitted line, wrong tables, pulsed valves."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import either_way, some


def _share(law: Law, kpa: Floats) -> Floats:
    """Pressures as shares (T, C) of the way from the lower limits to the upper ones."""
    low = law.rig.low_kpa
    return np.clip((kpa - low) / (law.rig.high_kpa - low), 0.0, 1.0)


def _range(law: Law) -> Floats:
    """The ranges (C,) in kPa."""
    return law.rig.high_kpa - law.rig.low_kpa


class EqualPercentage(Law):
    """Equal-percentage trim where a linear one was meant: equal steps of the set-point multiply what comes.

    IEC 60534-2-4, Industrial-process control valves: inherent flow characteristics and rangeability, 2009.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._decades = either_way(setting, 0.3, 1.0, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        share = _share(self, kpa)
        steep = np.clip(strength * self._decades, -8.0, 8.0)
        bent = np.where(np.abs(steep) < 1e-6, 1.0, steep)
        change = np.expm1(bent * share) / np.expm1(bent) - share
        return kpa + np.where(bent == steep, _range(self) * change, 0.0)


class IndependentLinearity(Law):
    """Independent linearity: about the best straight line a sensor is off by Chebyshev's polynomials, at the ends too.

    ISA-51.1, Process Instrumentation Terminology, Instrument Society of America, 1979.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._second = either_way(setting, 0.01, 0.04, 0.7)
        self._third = either_way(setting, 0.01, 0.04, 0.7)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        x = 2 * _share(self, kpa) - 1
        error = self._second * (2 * x**2 - 1) + self._third * (4 * x**3 - 3 * x)
        return kpa + strength * _range(self) * error


class WrongTable(Law):
    """Wrong table: the calibration has a few points of each sensor, each off by itself, and straight lines between.

    L. Kirkup, R. B. Frenkel, An Introduction to Uncertainty in Measurement, Cambridge University Press, 2006.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        points = int(random.integers(4, 8))
        self._points = np.linspace(0.0, 1.0, points)
        self._off = random.normal(0, 1, (points, count)) * some(random, count, 0.02, 0.06, 0.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        share, out = _share(self, kpa), kpa.copy()
        for c, high in enumerate(_range(self)):
            out[:, c] += strength * high * np.interp(share[:, c], self._points, self._off[:, c])
        return out


class PulsedValve(Law):
    """Pulsed valve: pulses shorter than its dead time do not open it, pauses shorter than that do not close it.

    R. B. van Varseveld, G. M. Bone, Accurate position control of a pneumatic actuator using on/off solenoid valves,
    IEEE/ASME Trans. Mechatronics 2, 1997.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._dead = some(setting.random, count, 0.03, 0.09, 0.85)
        self._like = setting.random.uniform(0.4, 1.0)  # the pause's, against the pulse's

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = kpa / self.rig.high_kpa
        size = np.clip(np.abs(load), 0.0, 1.0)
        dead = 0.45 * np.tanh(strength * self._dead / 0.45)
        passed = np.clip((size - dead) / (1 - dead * (1 + self._like)), 0.0, 1.0)
        return kpa + self.rig.high_kpa * np.sign(load) * (passed - size)
