"""Regulators of the sixth portion: capacitive gauges, slanted pointers, too low a supply, a diode in the line."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import either_way, full, some


def _share(law: Law, kpa: Floats) -> tuple[Floats, Floats]:
    """Where pressures (T, C) are between the limits, 0 to 1, and how far the limits (C,) are apart."""
    low, high = law.rig.low_kpa, law.rig.high_kpa
    return np.clip((kpa - low) / (high - low), 0.0, 1.0), high - low


class CapacitiveGauge(Law):
    """Capacitive gauge: its membrane bows towards a plate, and what it reads grows ever faster, by an artanh.

    W. H. Ko, Q. Wang, Touch mode capacitive pressure sensors, Sensors and Actuators A 75, 1999 (normal mode). It was
    set right at both ends.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._near = random.uniform(0.3, 0.85, count)  # how much of the gap is gone at full scale
        self._takes = some(random, count, 0.3, 0.9, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        x, wide = _share(self, kpa)

        def more(gone: Floats) -> Floats:
            root = np.sqrt(np.maximum(gone, 1e-12))
            return np.arctanh(root) / root - 1

        return kpa - strength * wide * self._takes * (x - more(self._near * x) / more(self._near))


class SlantedPointer(Law):
    """Pointer gauge: its lever is not square to its link, so that the scale is wider on one side of the middle.

    J. P. Holman, Experimental Methods for Engineers, McGraw-Hill, 1966 (angularity of the Bourdon gauge's linkage). All
    regulators were set by the same gauge, and one or two have another one.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        same = random.random(count) < 0.75
        self._turns = np.where(same, random.uniform(0.7, 1.4), random.uniform(0.7, 1.4, count))
        first, own = random.uniform(-1.2, 0.5), random.uniform(-1.2, 0.5, count)
        self._first = np.where(same, first, own)
        self._factor = random.normal(0, 0.02)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        x, wide = _share(self, kpa)
        none, whole = np.sin(self._first), np.sin(self._first + self._turns)
        reads = (np.sin(self._first + self._turns * x) - none) / np.where(
            np.abs(whole - none) < 0.2, 0.2, whole - none
        )
        return kpa + strength * wide * (0.5 * (reads - x) + self._factor * x)


class LowSupply(Law):
    """Low supply: no regulator gives more than the line has left behind its own seat, some of them less than others.

    ISO 6953-1, Pneumatic fluid power: compressed air pressure regulators and filter-regulators, 2015. Vacuum lines are
    as weak. The stronger the law, the lower is the ceiling.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._lower = random.uniform(0.15, 0.4) * some(random, count, 0.6, 1.4, random.uniform(0.5, 1.0))
        self._round = random.uniform(0.01, 0.05)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        over = np.maximum(np.abs(load) - np.exp(-strength * self._lower), 0.0)
        less = np.where(self._lower > 0, over**2 / (over + self._round), 0.0)
        return kpa - np.sign(load) * less * self.rig.high_kpa


class DiodeDrop(Law):
    """Diode in the line: a protective diode takes its voltage off each set-point, by the logarithm of the current.

    W. Shockley, The theory of p-n junctions in semiconductors and p-n junction transistors, Bell System Technical
    Journal 28, 1949. Some drivers add as much, since they were trimmed for it.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._knee = random.uniform(0.01, 0.1) * random.uniform(0.9, 1.1, count)
        alike = random.random() < 0.6
        sizes = some(random, count, 0.03, 0.08, 0.8)
        self._drop = sizes if alike else np.abs(sizes) * np.sign(either_way(setting, 0.5, 1.0))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        drop = self._drop * np.log1p(np.abs(load) / self._knee) / np.log1p(1 / self._knee)
        return kpa - strength * self.rig.high_kpa * np.sign(load) * drop
