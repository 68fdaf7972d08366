"""Regulators of the tenth portion: a parabola that is off everywhere, and a screw whose pitch wobbles."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import either_way, full


class WrongParabola(Law):
    """Parabola of calibration: zero, factor and bow of each regulator are all a little wrong at once.

    JCGM 100, Guide to the Expression of Uncertainty in Measurement, 2008, annex H.3 on calibration curves. No gauge is
    right at any point by more than chance.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._zero = either_way(setting, 0.005, 0.025)
        self._gain = either_way(setting, 0.02, 0.08)
        self._bow = either_way(setting, 0.03, 0.1)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        wrong = self._zero + self._gain * load + self._bow * load * np.abs(load)
        got = kpa + strength * wrong * self.rig.high_kpa
        return np.maximum(got, np.minimum(kpa, self.rig.low_kpa))  # it cannot draw more than its lower limit


class WobblingScrew(Law):
    """Periodic error of a screw: a motor turns the regulator's spindle, which is ahead and behind once a turn.

    A. H. Slocum, Precision Machine Design, Prentice Hall, 1992, on drunken threads. A few turns make the whole range;
    the motors were homed where the valves are shut, so that nothing is wrong there.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._turns = random.uniform(1.4, 3.5) * random.uniform(0.97, 1.03, count)  # of one make
        self._phase = random.uniform(0, 2 * np.pi, count)
        self._size = random.uniform(0.025, 0.05) * random.uniform(0.7, 1.3, count)
        self._twice = random.uniform(0.0, 0.35)  # a bent coupling adds a wave of half the length

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        turn = 2 * np.pi * self._turns * full(self.rig, kpa)
        once = np.sin(turn + self._phase) - np.sin(self._phase)
        twice = np.sin(2 * turn + self._phase) - np.sin(self._phase)
        return kpa + strength * self._size * self.rig.high_kpa * (once + self._twice * twice)
