"""Drift of the ninth portion: cameras warm up, zeros wander, a frame breathes, rubber warms, sensors age."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, shift, span


def _longest_s(path: Path) -> float:
    """How long the longest session is."""
    return max(float(path.session_s.max()), 1.0)


class WarmsUp(Law):
    """Warms up: after switching on, all readings move to one side until the instruments are warm.

    H. Handel, Analyzing the influences of camera warm-up effects on image acquisition, Asian Conference on
    Computer Vision, 2007: 1 - exp(-t / tau), with tau of some ten minutes. Each session begins cold.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._tau_s = min(random.uniform(500, 2000), random.uniform(0.2, 0.6) * _longest_s(setting.path))
        self._moves = random.uniform(0.12, 0.3) * span(self.rig) * shift(self.rig, direction(random))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        warm = -np.expm1(-path.session_s / self._tau_s)
        return values + strength * warm[:, None] * self._moves


class ZerosWander(Law):
    """Zeros wander: the zero of each pressure sensor walks at random, and its valve follows it.

    D. W. Allan, Statistics of atomic frequency standards, Proceedings of the IEEE 54, 1966; IEEE Std 952,
    1997, where it is the random walk of a sensor's bias. All are right at the first moment.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path, count = setting.random, setting.path, len(self.rig.chambers)
        rows_s = path.time_s[path.row]
        self._at_s = np.unique(np.append(path.time_s[0], rows_s))
        steps = np.sqrt(np.diff(self._at_s, prepend=self._at_s[0]))[:, None]
        walk = np.cumsum(steps * random.normal(size=(len(steps), count)), axis=0)
        size = max(float(np.sqrt(np.mean(walk**2))), 1e-9)
        self._zero_kpa = random.uniform(0.03, 0.07) * self.rig.high_kpa * walk / size

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        zero = [np.interp(path.time_s, self._at_s, each) for each in self._zero_kpa.T]
        return kpa + strength * np.stack(zero, axis=1)


class FrameBreathes(Law):
    """Frame breathes: what holds the cameras grows and shrinks with the temperature of the room.

    J. B. Bryan, International status of thermal error research, CIRP Annals 39, 1990: growth is the
    coefficient times the length times the temperature; all points go away from the foot, which stands at some
    distance. A room warms by day, and as its heating goes on and off.
    """

    effect = "drift"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        centre, radius = body_mm(rig)
        far_mm = random.uniform(4, 12) * radius
        self._foot_mm = centre + far_mm * direction(random)
        self._growth = random.uniform(0.12, 0.3) * span(rig) / far_mm  # at one unit of temperature
        self._cycle_s = random.uniform(0.25, 1.0) * min(3600.0, _longest_s(setting.path))
        self._phase = random.uniform(0, 2 * np.pi, 2)
        self._by_day = random.uniform(0.5, 1.5)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        turns = 2 * np.pi * path.time_s[:, None] / np.array([self._cycle_s, 86400.0])
        cycle, day = (np.sin(turns + self._phase) - np.sin(self._phase)).T
        growth = self._growth * (cycle + self._by_day * day)
        points = positions(self.rig, values)
        return moved(self.rig, values, points + strength * growth[:, None, None] * (points - self._foot_mm))


class RubberWarms(Law):
    """Rubber warms: its modulus changes with temperature, and so does how far the walls give way.

    L. R. G. Treloar, The Physics of Rubber Elasticity, Oxford, 1975: the modulus is N k T, so warm rubber
    gives less; filled or plasticized rubber gives more (A. N. Gent, Engineering with Rubber, Hanser, 1992).
    Each session begins at a temperature of its own and comes closer to that of the room.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tau_s = random.uniform(0.3, 1.5) * _longest_s(setting.path)
        self._begins = random.uniform(-0.5, 0.5, int(setting.path.session.max()) + 1)
        self._begins -= self._begins[0]  # as calibrated at the first one's beginning
        self._room = random.uniform(0.8, 1.5)
        gain = random.uniform(0.08, 0.2) * random.choice([-1.0, 1.0])
        self._gain = gain * random.uniform(0.8, 1.2, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        begins = self._begins[np.clip(path.session, 0, len(self._begins) - 1)]
        warm = self._room + (begins - self._room) * np.exp(-path.session_s / self._tau_s)
        return deflection * (1 + strength * warm[:, None] * self._gain)


class SensorsAge(Law):
    """Sensors age: zero and gain of each go steadily away from what they were at the calibration.

    J. Fraden, Handbook of Modern Sensors, Springer, 2010, on drift as so much of the full scale per hour; the
    International Vocabulary of Metrology (JCGM 200, 2012) has it as instrumental drift. Markers have one
    sensor per axis.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        seen = self.rig.observables
        of = np.array([o.axis if o.marker >= 0 else 3 + k for k, o in enumerate(seen)])
        self._from_s = float(path.time_s[0])
        self._whole_s = max(float(path.time_s[-1]) - self._from_s, 1.0)
        self._zero = random.uniform(0.1, 0.25) * span(self.rig) * random.normal(size=3 + len(seen))[of]
        self._gain = random.uniform(0.05, 0.2) * random.normal(size=3 + len(seen))[of]

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        age = (path.time_s - self._from_s)[:, None] / self._whole_s
        return values + strength * age * (self._zero + self._gain * (values - self.rig.at_rest))
