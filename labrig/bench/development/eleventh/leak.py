"""Leaks of the eleventh portion: needle holes along a stitched seam, and a fitting that is pulled aside."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full

_ROOM_KPA = 101.3


class ThroughStitches(Law):
    """Forchheimer: what drives air through cloth and stitches is a line and a square of its flow.

    P. Forchheimer, Wasserbewegung durch Boden, Zeitschrift des Vereines deutscher Ingenieure 45, 1901; as air is
    compressed, the drive is the difference of the squares of both pressures. A chamber's volume stays the same.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._per_s = random.uniform(0.002, 0.006) * random.lognormal(0.0, 0.6, count)  # at full pressure
        self._square = random.uniform(0.3, 0.95)  # of the drive at full pressure, what its square takes
        self._parts = 20

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        room = 2 * _ROOM_KPA / self.rig.high_kpa
        part_s = path.hold_s[:, None] / self._parts
        line, left = 1 - self._square, load
        for _ in range(self._parts):
            over = np.maximum(left + room, 0.1 * room) / (1 + room)  # the drive over the load
            drive = np.minimum(np.abs(left) * over, 1e100)
            flow = 2 * over / (line + np.sqrt(line**2 + 4 * self._square * drive))  # over the load, too
            left = left * np.exp(-strength * self._per_s * part_s * flow)
        return kpa + (left - load) * self.rig.high_kpa


class FittingPulledAside(Law):
    """Fitting pulled aside: beyond some bend the body pulls at a hose, and its fitting leaks by the square of that.

    ISO 14743, Pneumatic fluid power, Push-in connectors for thermoplastic tubes, 2004, tests them for such side loads.
    Which poses pull at which hose depends on where it leaves the body; straight up, a fitting is nearly tight.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        count = len(rig.chambers)
        pulls = random.normal(0, 1, (count, count)) + np.diag(random.uniform(0.0, 1.5, count))
        usual = np.abs(rig.deflection(setting.path.kpa) @ pulls)
        self._pulls = pulls / np.maximum(np.quantile(usual, 0.8, axis=0), 1e-6)
        self._from = random.uniform(0.1, 0.5, count)
        self._per_s = random.uniform(0.002, 0.007) * random.lognormal(0.0, 0.5, count)
        self._always = random.uniform(0.02, 0.1)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        pulled = np.minimum(np.abs(self.rig.deflection(kpa) @ self._pulls), 1e3)
        opens = self._always + np.maximum(pulled - self._from, 0.0) ** 2
        return kpa * np.exp(-strength * self._per_s * opens * path.hold_s[:, None])
