"""Leaks of the tenth portion: a chamber that shrinks as it leaks, and one that is topped up now and then."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some

_ROOM_KPA = 101.3


class ShrinksAsItLeaks(Law):
    """Balance of mass: air leaks in proportion to the pressure out of a chamber that gets smaller as it sinks.

    J. F. Blackburn, G. Reethof, J. L. Shearer, Fluid Power Control, MIT Press, 1960. In absolute units the air is
    pressure times volume, so that a full and soft chamber holds its pressure longer than one that is nearly empty.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._per_s = random.uniform(0.0025, 0.006) * random.lognormal(0.0, 0.5, count)  # at full pressure
        self._grows = random.uniform(0.5, 3.0)  # its volume, from empty to full, as a share
        self._parts = 24

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        room = _ROOM_KPA / self.rig.high_kpa
        part_s = path.hold_s[:, None] / self._parts
        at_full = 1 + self._grows * (2 + room)
        left = load
        for _ in range(self._parts):
            # how fast the air, (left + room) (1 + grows left), changes with what is left
            holds = np.maximum(1 + self._grows * (2 * left + room), 0.3)
            left = left * np.exp(-strength * self._per_s * part_s * at_full / holds)
        return kpa + (left - load) * self.rig.high_kpa


class ToppedUp(Law):
    """Two-point control: a chamber leaks until its valve notices, which then tops it up at once, again and again.

    K. J. Åström, T. Hägglund, PID Controllers: Theory, Design, and Tuning, ISA, 1995, on on-off control with a gap.
    In a long hold the pressure is a saw: exponential down, steep up; how soon it comes again differs by chamber.
    """

    effect = "leak"
    needs = frozenset({"holds"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._band = some(random, count, 0.12, 0.3, 0.75)  # of what is held
        self._every_s = random.uniform(15, 60) * random.uniform(0.7, 1.3, count)
        self._bends = random.uniform(0.2, 1.0)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        since = np.mod(path.hold_s[:, None] / self._every_s, 1.0)
        down = np.expm1(-self._bends * since) / np.expm1(-self._bends)
        return kpa * (1 - np.tanh(strength * self._band) * down)
