"""Laws outside the library, of the fourth portion: real phenomena that none of its names describes."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, moved, positions, some
from labrig.bench.development._story import steps


class SwappedLabels(Law):
    """Swapped labels: in some captures the tracker takes two neighbours for each other, in a part of the frames.

    I. J. Cox, S. L. Hingorani, An efficient implementation of Reid's multiple hypothesis tracking algorithm and its
    evaluation for the purpose of visual tracking, IEEE Trans. Pattern Analysis and Machine Intelligence 18, 1996.
    """

    effect = "swapped_labels"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rest = setting.random, self.rig.rest_mm
        assert rest is not None
        apart = np.linalg.norm(rest[:, None] - rest, axis=2) + np.diag(np.full(len(rest), np.inf))
        pairs: list[tuple[int, int]] = []
        for one in random.permutation(len(rest))[: int(random.integers(2, 5))].tolist():
            other = int(np.argmin(apart[one]))
            if not {one, other} & {m for pair in pairs for m in pair}:
                pairs.append((one, other))
        self._pairs = pairs
        seldom = random.uniform(0.15, 0.4)
        self._swapped = (random.random((997, len(pairs))) < seldom) * random.uniform(
            0.05, 0.3, (997, len(pairs))
        )

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        share = -np.expm1(-strength * self._swapped[path.event % len(self._swapped)])
        out = points.copy()
        for k, (one, other) in enumerate(self._pairs):
            between = share[:, k, None] * (points[:, other] - points[:, one])
            out[:, one] += between
            out[:, other] -= between
        return moved(self.rig, values, out)


class Hunting(Law):
    """Limit cycle: above a load some regulators no longer settle but hunt, by the root of what is too much.

    A. A. Andronov, A. A. Vitt, S. E. Khaikin, Theory of Oscillators, Pergamon, 1966.
    """

    effect = "hunting"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._above = random.uniform(0.2, 0.6)
        self._round_s = random.uniform(0.7, 3.5, count)
        self._phase = random.uniform(0, 2 * np.pi, (997, count))
        self._swings = some(random, count, 0.04, 0.12, 0.6)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = np.abs(full(self.rig, kpa))
        size = np.sqrt(np.maximum(load - self._above, 0.0) / (1 - self._above))
        angle = 2 * np.pi * path.hold_s[:, None] / self._round_s + self._phase[path.event % len(self._phase)]
        return kpa + strength * self._swings * self.rig.high_kpa * size * np.sin(angle)


class WaterInLine(Law):
    """Condensate: each filling leaves some water in the hose's lowest bend, whose head is lost until it is blown out.

    P. Croser, F. Ebel, Pneumatics: Basic Level, Festo Didactic, 2002.
    """

    effect = "water_in_line"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._wet = random.uniform(0.1, 0.4, count)  # of a full bend, for each full stroke
        self._blown_at = random.uniform(0.75, 0.95, count)
        self._head = some(random, count, 0.05, 0.15, 0.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        fills = np.maximum(steps(np.abs(load)), 0.0) * self._wet
        water, stands = np.zeros(kpa.shape[1]), np.empty_like(kpa)
        for t in range(len(kpa)):
            water = np.where(np.abs(load[t]) > self._blown_at, 0.0, np.minimum(water + fills[t], 1.0))
            stands[t] = water
        return kpa - strength * self._head * self.rig.high_kpa * stands * np.tanh(load / 0.1)


class Ratcheting(Law):
    """Ratcheting: each cycle leaves the wall a little further out than the one before, the more, the more it carries.

    C. O. Frederick, P. J. Armstrong, A mathematical representation of the multiaxial Bauschinger effect, Materials at
    High Temperatures 24, 2007.
    """

    effect = "ratcheting"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._power, self._slower = random.uniform(1.0, 3.0), random.uniform(0.4, 1.0)
        self._whole = np.maximum(self._gone(self.rig.deflection(setting.path.kpa))[-1], 1e-6)
        self._size = some(random, count, 0.04, 0.12, 0.8)

    def _gone(self, deflection: Floats) -> Floats:
        """What all strokes so far add up to, (T, C), each by its length and by the load that it ends at."""
        size = np.abs(deflection)
        return np.cumsum(np.maximum(steps(size), 0.0) * size**self._power, axis=0) ** self._slower

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return deflection + strength * self._size * np.minimum(self._gone(deflection) / self._whole, 2.0)
