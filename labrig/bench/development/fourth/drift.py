"""Drift of the fourth portion: electronics that warm and cool, a boom that the lamps bend, a stand that settles."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, shift, span
from labrig.bench.development._story import pauses


class WarmsAndCools(Law):
    """Newton's law of cooling: the zero follows electronics that warm up in each session, and cool in the pauses.

    I. Newton, Scala graduum caloris, Philosophical Transactions 22, 1701.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        self._warms_s = float(np.ptp(path.time_s[path.row])) * random.uniform(0.08, 0.4)
        self._cools_s = np.exp(random.uniform(np.log(200), np.log(2000)))
        self._way = shift(self.rig, span(self.rig) * random.uniform(0.08, 0.25) * direction(random))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        ends = {int(s): float(path.time_s[path.row][path.session[path.row] == s].max(initial=-1.0))
                for s in np.unique(path.session)}  # fmt: skip
        on = path.time_s <= np.array([ends[int(s)] for s in path.session])
        pause_s, warm, now = pauses(path), np.empty(len(values)), 0.0
        for t in range(len(values)):
            now += (float(on[t]) - now) * -np.expm1(-pause_s[t] / (self._warms_s if on[t] else self._cools_s))
            warm[t] = now
        return values + strength * warm[:, None] * self._way


class BentBoom(Law):
    """Heat on one side: a boom bends while its lit face is warmer, and straightens as the other face gets as warm.

    S. Timoshenko, Analysis of bi-metal thermostats, J. Optical Society of America 11, 1925.
    """

    effect = "drift"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path, (centre, radius) = setting.random, setting.path, body_mm(self.rig)
        self._far_s = float(path.session_s[path.row].max()) * random.uniform(0.3, 1.5)
        self._lit_s = self._far_s * random.uniform(0.05, 0.4)
        peak_s = np.log(self._far_s / self._lit_s) * self._far_s * self._lit_s / (self._far_s - self._lit_s)
        self._peak = float(np.exp(-peak_s / self._far_s) - np.exp(-peak_s / self._lit_s))
        boom = direction(random)
        bends = np.cross(boom, direction(random))
        bends /= np.linalg.norm(bends)
        long_mm = radius * random.uniform(2.0, 6.0)
        self._foot_mm = centre - long_mm * boom
        self._tip_mm = self._foot_mm + 0.5 * long_mm * boom  # the end of a bent boom turns about its middle
        self._turn_rad = bends * span(self.rig) * random.uniform(0.15, 0.4) / long_mm

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        warmer = (np.exp(-path.session_s / self._far_s) - np.exp(-path.session_s / self._lit_s)) / self._peak
        points = positions(self.rig, values)
        change = np.cross(self._turn_rad, points - self._tip_mm)
        return moved(self.rig, values, points + strength * warmer[:, None, None] * change)


class SettlingStand(Law):
    """Settlement: a newly set-up stand sinks along a hyperbola of time, fast at first and then ever more slowly.

    R. L. Kondner, Hyperbolic stress-strain response: cohesive soils, J. Soil Mechanics and Foundations Division ASCE
    89, 1963.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._half_s = float(setting.path.time_s[-1]) * random.uniform(0.03, 0.4)
        sinks = np.array([0.0, 0.0, -1.0]) + 0.5 * random.normal(size=3)
        self._way = shift(self.rig, span(self.rig) * random.uniform(0.1, 0.3) * sinks)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        gone = path.time_s / (path.time_s + self._half_s)
        return values + strength * gone[:, None] * self._way
