"""Drift of the fifth portion: a stand that creeps in jerks, the sun on a mount, a battery that runs down."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import direction, shift, span


class JerkyStand(Law):
    """Shot process: a loaded stand gives way in many small jerks, at moments by chance, and mostly in one direction.

    D. R. Cox, P. A. W. Lewis, The Statistical Analysis of Series of Events, Methuen, 1966.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        count = int(random.integers(8, 40))
        begin_s, end_s = float(path.time_s[0]), float(path.time_s[path.row].max())
        self._at_s = np.sort(random.uniform(begin_s, end_s, count))
        size = random.exponential(1.0, count)[:, None]
        way = direction(random) + 0.6 * random.normal(size=(count, 3))
        gone = np.vstack([np.zeros(3), np.cumsum(size * way, axis=0)])
        gone *= (
            span(self.rig) * random.uniform(0.1, 0.3) / max(float(np.linalg.norm(gone, axis=1).max()), 1e-9)
        )
        self._gone = shift(self.rig, gone)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._gone[np.searchsorted(self._at_s, path.time_s, side="right")]


class SunPatch(Law):
    """Sun on the mount: for a part of the day it shines in, moves the zero, and goes again (a raised cosine of time).

    A. H. Slocum, Precision Machine Design, Prentice Hall, 1992; from laboratory experience. It warms faster than it
    cools.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, seen_s = setting.random, setting.path.time_s[setting.path.row]
        long_s = float(np.ptp(seen_s))
        self._peak_s = float(seen_s.min()) + long_s * random.uniform(0.15, 0.85)
        self._comes_s, self._goes_s = long_s * random.uniform(0.15, 0.5), long_s * random.uniform(0.3, 0.9)
        self._way = shift(self.rig, span(self.rig) * random.uniform(0.1, 0.3) * direction(random))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        away_s = path.time_s - self._peak_s
        away = np.clip(away_s / np.where(away_s < 0, self._comes_s, self._goes_s), -1.0, 1.0)
        return values + strength * (0.5 * (1 + np.cos(np.pi * away)))[:, None] * self._way


class RunDownBattery(Law):
    """Battery: what feeds the sensors runs down, slowly for long and then ever faster; all readings shrink with it.

    C. M. Shepherd, Design of primary and secondary cells, J. Electrochemical Society 112, 1965. Readings shrink towards
    the zero of the electronics, which is not the vented rig's.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        self._empty_s = float(path.time_s[-1]) * random.uniform(1.1, 1.8)
        self._at_end = float(path.time_s[-1]) / (self._empty_s - float(path.time_s[-1]))
        self._loses = random.uniform(0.05, 0.2)
        self._zero = self.rig.at_rest - shift(
            self.rig, span(self.rig) * random.uniform(0.3, 1.5) * direction(random)
        )

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        time_s = np.minimum(path.time_s, 0.98 * self._empty_s)
        down = time_s / (self._empty_s - time_s) / self._at_end
        return values - (strength * self._loses * down)[:, None] * (values - self._zero)
