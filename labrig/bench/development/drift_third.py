"""Drift of the third portion: clocks that age, flicker noise, a weather front, a wooden frame that gets moist."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, shift, span


class LogarithmOfTime(Law):
    """Ageing: since the system was switched on its zero moves with the logarithm of time, sessions or not.

    J. R. Vig, T. R. Meeker, The aging of bulk acoustic wave resonators, filters and oscillators, 45th Annual Symposium
    on Frequency Control, IEEE, 1991.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, end_s = setting.random, float(setting.path.time_s[-1])
        self._begins_s = end_s * random.uniform(0.005, 0.08)
        self._way = shift(self.rig, span(self.rig) * random.uniform(0.08, 0.2) * direction(random))
        self._way = self._way / np.log1p(end_s / self._begins_s)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * np.log1p(path.time_s / self._begins_s)[:, None] * self._way


class Flicker(Law):
    """Flicker noise of the zero: as much in each octave, from twice the campaign's length down to a twelfth of it.

    M. S. Keshner, 1/f noise, Proc. IEEE 70, 1982.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, length_s = setting.random, float(np.ptp(setting.path.time_s))
        octave = 2.0 ** -np.arange(5)
        self._waves_per_s = 2 * np.pi / (2 * length_s * octave * random.uniform(0.8, 1.2, 5))
        self._phase = random.uniform(0, 2 * np.pi, 5)
        size = span(self.rig) * random.uniform(0.05, 0.12)
        self._ways = size * shift(self.rig, np.stack([direction(random) for _ in octave]))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        wave = np.sin(path.time_s[:, None] * self._waves_per_s + self._phase) - np.sin(self._phase)
        return values + strength * wave @ self._ways


class WeatherFront(Law):
    """Passing front: the room's pressure, against which all gauges measure, goes to another level within minutes.

    J. M. Wallace, P. V. Hobbs, Atmospheric Science: An Introductory Survey, 2nd ed., Academic Press, 2006.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        seen_s = path.time_s[path.row]
        self._at_s = float(seen_s.min() + np.ptp(seen_s) * random.uniform(0.25, 0.75))
        self._takes_s = float(np.ptp(seen_s)) * random.uniform(0.05, 0.25)
        sign = random.choice([-1.0, 1.0])
        self._jump_kpa = sign * random.uniform(0.03, 0.09) * float(np.mean(self.rig.high_kpa))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        passed = 0.5 + 0.5 * np.tanh((path.time_s - self._at_s) / self._takes_s)
        return kpa + strength * self._jump_kpa * passed[:, None]


class SwellingFrame(Law):
    """Moisture: a wooden frame swells across its grain, and hardly along it, as water diffuses in (Fick's series).

    A. J. Stamm, Wood and Cellulose Science, Ronald Press, 1964.
    """

    effect = "drift"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        self._foot_mm = centre + radius * random.uniform(0.8, 2.0) * direction(random)
        grain = direction(random)
        across = np.eye(3) - np.outer(grain, grain) + 0.05 * np.outer(grain, grain)
        self._swells = span(self.rig) / radius * random.uniform(0.04, 0.12) * across
        self._whole_s = float(setting.path.time_s[-1]) * random.uniform(0.5, 3.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        odd = 2 * np.arange(12) + 1
        left = np.exp(-((np.pi * odd) ** 2) * path.time_s[:, None] / (4 * self._whole_s))
        wet = 1 - left @ (8 / (np.pi * odd) ** 2)
        points = positions(self.rig, values)
        swollen = (points - self._foot_mm) @ self._swells
        return moved(self.rig, values, points + strength * wet[:, None, None] * swollen)
