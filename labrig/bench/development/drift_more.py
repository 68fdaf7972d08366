"""Further drift: two warming times, a root of time, the room's cycle, a growing mount, wandering gains, ageing."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, shift, some, span


def _length_s(path: Path) -> float:
    """How long the longest session is looked at."""
    return max(float(path.session_s[path.row].max()), 1.0)


class TwoTimes(Law):
    """Two heat capacities: the zero moves fast one way as the electronics warm up, and slowly on as the room does.

    E. O. Doebelin, Measurement Systems: Application and Design, 5th ed., McGraw-Hill, 2004.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, length_s = setting.random, _length_s(setting.path)
        self._tau_s = length_s * np.array([random.uniform(0.03, 0.1), random.uniform(0.4, 1.2)])
        ways = np.stack([direction(random), direction(random)])
        sizes = span(self.rig) * random.uniform(0.06, 0.18, (2, 1))
        self._ways = shift(self.rig, sizes * ways)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values - strength * np.expm1(-path.session_s[:, None] / self._tau_s) @ self._ways


class RootOfTime(Law):
    """Heat that soaks in: a thick mount is warmed at its face, and moves what it carries with the root of time.

    H. S. Carslaw, J. C. Jaeger, Conduction of Heat in Solids, 2nd ed., Clarendon Press, 1959.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        size = span(self.rig) * setting.random.uniform(0.06, 0.18)
        self._way = shift(self.rig, size * direction(setting.random)) / np.sqrt(_length_s(setting.path))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * np.sqrt(path.session_s)[:, None] * self._way


class RoomCycle(Law):
    """Room temperature: the air conditioning swings it to and fro, by the clock, and the zero with it.

    ASHRAE Handbook: Fundamentals, American Society of Heating, Refrigerating and Air-Conditioning Engineers, 2017.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._period_s = np.clip(_length_s(setting.path) * random.uniform(0.6, 2.0), 300.0, 86400.0)
        self._phase = random.uniform(0, 2 * np.pi)
        self._way = shift(self.rig, span(self.rig) * random.uniform(0.05, 0.15) * direction(random))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        angle = 2 * np.pi * path.time_s / self._period_s + self._phase
        return values + strength * (np.sin(angle) - np.sin(self._phase))[:, None] * self._way


class GrowingMount(Law):
    """Thermal expansion: the mount, and with it the body, grows from its foot as it warms up in each session.

    S. T. Smith, D. G. Chetwynd, Foundations of Ultraprecision Mechanism Design, Gordon and Breach, 1992.
    """

    effect = "drift"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        centre, radius = body_mm(self.rig)
        self._foot_mm = centre + radius * random.uniform(1.0, 2.5) * direction(random)
        self._grows = span(self.rig) / radius * random.uniform(0.03, 0.1)
        self._tau_s = _length_s(setting.path) * random.uniform(0.2, 0.8)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        grown = -strength * self._grows * np.expm1(-path.session_s / self._tau_s)
        points = positions(self.rig, values)
        return moved(self.rig, values, points + grown[:, None, None] * (points - self._foot_mm))


class WanderingGain(Law):
    """Wandering gains: each pressure sensor's factor goes its own slow way (waves of an Ornstein-Uhlenbeck process).

    G. E. Uhlenbeck, L. S. Ornstein, On the theory of the Brownian motion, Physical Review 36, 1930.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        waves = 2 * np.pi / (_length_s(setting.path) * random.uniform(0.5, 2.5, 5))
        self._waves, self._phase = waves, random.uniform(0, 2 * np.pi, 5)
        self._each = random.normal(size=(5, count)) * some(random, count, 0.03, 0.1, 0.7) / np.sqrt(2)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        now = np.sin(path.time_s[:, None] * self._waves + self._phase) - np.sin(self._phase)
        return kpa * np.exp(np.clip(strength * now @ self._each, -2.0, 1.0))


class AgeingWalls(Law):
    """Physical ageing: all walls get a little stiffer with the logarithm of the time since the rig was set up.

    L. C. E. Struik, Physical Aging in Amorphous Polymers and Other Materials, Elsevier, 1978.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, end_s = setting.random, float(setting.path.time_s[-1])
        self._begins_s = end_s * random.uniform(0.03, 0.3)
        whole = np.log1p(end_s / self._begins_s)
        self._stiffer = random.uniform(0.08, 0.2) * random.uniform(0.9, 1.1, len(self.rig.chambers)) / whole

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        aged = np.log1p(path.time_s / self._begins_s)[:, None]
        return deflection * np.exp(-strength * self._stiffer * aged)
