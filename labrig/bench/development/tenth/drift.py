"""Drift of the tenth portion: a gyroscope's bias turns the frame, and rubber that warms by its own work."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, full, moved, positions, span, turned
from labrig.bench.development._story import pauses, steps


class GyroscopesBias(Law):
    """Bias of a gyroscope: what keeps the frame level is off by so much a second, and the frame turns evenly.

    IEEE Std 952, Specification Format Guide and Test Procedure for Single-Axis Interferometric Fiber Optic Gyros, 1997.
    It turns about where the cameras stand, so that all goes aside as well.
    """

    effect = "drift"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        centre, radius_mm = body_mm(self.rig)
        self._about_mm = centre + random.uniform(0.3, 2.0) * radius_mm * direction(random)
        far = np.linalg.norm(self._about_mm - centre) + radius_mm
        end_s = max(float(setting.path.time_s[-1]), 1.0)
        ends = random.uniform(0.4, 0.8) * span(self.rig) * np.sqrt(3.0) / far
        self._per_s = direction(random) * min(ends, 0.15) / end_s

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength == 0:
            return values
        turn = strength * (path.time_s - path.time_s[0])[:, None] * self._per_s
        return moved(self.rig, values, turned(positions(self.rig, values), self._about_mm, turn))


class WarmsByItsWork(Law):
    """Self-heating: rubber that is moved gets warm by what it loses, and softer; at rest it cools down again.

    G. Kraus, Mechanical losses in carbon-black-filled rubbers, J. Applied Polymer Science: Applied Polymer Symp. 39,
    1984: the loss of a cycle goes with the square of its width. Heat leaves by Newton's law, within tens of minutes, so
    that the body is warm in busy times, and cold after each pause. One body has one temperature.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._cools_s = np.exp(random.uniform(np.log(300.0), np.log(1500.0)))
        self._softens = random.uniform(0.12, 0.25) * random.uniform(0.9, 1.1, count)
        heat = self._heat(setting.path, setting.path.kpa)
        self._usual = max(float(heat.max()), 1e-9)

    def _heat(self, path: Path, kpa: Floats) -> Floats:
        """The heat (T,) that is in the body, in units of its own."""
        work = np.sum(steps(full(self.rig, kpa)) ** 2, axis=1)
        kept = np.exp(-pauses(path) / self._cools_s)
        heat, out = 0.0, np.empty(len(work))
        for i in range(len(work)):
            heat = heat * kept[i] + work[i]
            out[i] = heat
        return out

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        warm = (self._heat(path, kpa) / self._usual)[:, None]
        return deflection * (1 + strength * self._softens * warm)
