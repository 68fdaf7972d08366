"""Regulators of the twelfth portion: a booster with a bias, and two valves that share a range with a gap between."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import either_way, full


class BoosterWithABias(Law):
    """Booster with a bias: a relay multiplies a pilot pressure by its ratio of areas, less what its spring keeps back.

    Emerson, Control Valve Handbook, fourth edition, 2005. Below its bias the chamber gets nothing; above it the ratio
    is a little more or less than it was ordered with.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._bias = random.uniform(0.02, 0.06) * random.uniform(0.6, 1.4, count)
        self._ratio = either_way(setting, 0.0, 0.06)
        self._round = random.uniform(0.01, 0.03)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        size = np.abs(load)
        # all of the bias once the load is beyond it, and as much as the load below
        kept = strength * self._bias * -np.expm1(-size / (strength * self._bias + self._round))
        ratio = np.clip(1 + strength * self._ratio, 0.3, 3.0)
        return np.sign(load) * np.maximum(size * ratio - kept, 0.0) * self.rig.high_kpa


class SplitRangeWithAGap(Law):
    """Split range: one valve serves the lower part of the range and another the upper, and neither a gap in between.

    B. G. Lipták, Instrument Engineers' Handbook: Process Control, CRC Press, fourth edition, 2005. In the gap the
    pressure does not follow; towards both ends it catches up.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._change = random.uniform(0.35, 0.65) * random.uniform(0.9, 1.1, count)
        self._gap = random.uniform(0.03, 0.09) * random.uniform(0.7, 1.3, count)
        self._fades = random.uniform(0.12, 0.3)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        off = np.abs(load) - self._change
        gap = strength * self._gap
        lacks = np.clip(off, -gap, gap) * np.exp(-np.maximum(np.abs(off) - gap, 0.0) / self._fades)
        open_ = np.clip(np.abs(load) / 0.05, 0.0, 1.0)
        return kpa - np.sign(load) * open_ * lacks * self.rig.high_kpa
