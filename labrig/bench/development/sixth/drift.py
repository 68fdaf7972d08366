"""Drift of the sixth portion: doors that are opened, a sensor that is integrated twice, silicone that still cures."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import direction, shift, span


class OpenedDoors(Law):
    """Shots: now and then a door lets cold air in, which shifts the zero at once, and the room is slow to warm again.

    W. Schottky, Über spontane Stromschwankungen in verschiedenen Elektrizitätsleitern, Annalen der Physik 362, 1918.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, seen_s = setting.random, setting.path.time_s[setting.path.row]
        count, long_s = int(random.integers(3, 12)), float(np.ptp(seen_s))
        self._at_s = float(seen_s.min()) + long_s * random.uniform(-0.1, 0.95, count)
        self._size = random.gamma(2.0, 0.5, count)
        self._comes_s, self._goes_s = long_s * random.uniform(0.005, 0.03), long_s * random.uniform(0.08, 0.4)
        self._way = shift(self.rig, span(self.rig) * random.uniform(0.1, 0.3) * direction(random))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        since = np.maximum(path.time_s[:, None] - self._at_s, 0.0)
        cold = (np.exp(-since / self._goes_s) - np.exp(-since / self._comes_s)) @ self._size
        return values + strength * cold[:, None] * self._way


class IntegratedTwice(Law):
    """Inertial sensors: their bias, integrated twice, makes a parabola of time, which each session begins anew.

    O. J. Woodman, An introduction to inertial navigation, Technical Report 696, University of Cambridge, 2007.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        self._long_s = max(float(path.session_s[path.row].max()), 1.0)
        size = span(self.rig) * random.uniform(0.15, 0.5)
        bias = direction(random) + random.uniform(0.0, 0.8) * random.normal(size=(64, 3))  # of each session
        speed = random.uniform(0.0, 0.5) * random.normal(size=(64, 3))
        self._bias, self._speed = shift(self.rig, size * bias), shift(self.rig, size * speed)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        late, which = (path.session_s / self._long_s)[:, None], path.session % 64
        return values + strength * late * (self._speed[which] + late * self._bias[which])


class StillCuring(Law):
    """Kamal-Sourour: silicone that was used too soon cures on, late and then fast, and its walls give way ever less.

    M. R. Kamal, S. Sourour, Kinetics and thermal characterization of thermoset cure, Polymer Engineering and Science
    13, 1973.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path, count = setting.random, setting.path, len(self.rig.chambers)
        long_s = float(path.time_s[-1])
        self._time_s = np.linspace(0.0, 5.0 * long_s + 20_000.0, 4000)
        first, fast = random.uniform(0.1, 0.6), random.uniform(1.0, 6.0)  # per campaign
        power = random.uniform(0.7, 1.5)
        gone, cured = np.diff(self._time_s)[0] / long_s, np.zeros(len(self._time_s))
        for k in range(1, len(cured)):
            now = cured[k - 1]
            cured[k] = min(now + gone * (first + fast * now**power) * (1 - now) ** 1.3, 1.0)
        self._cured = cured
        self._stiffens = random.uniform(0.1, 0.3) * random.uniform(0.8, 1.2, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        cured = np.interp(path.time_s, self._time_s, self._cured)[:, None]
        return deflection * np.exp(-strength * self._stiffens * cured)
