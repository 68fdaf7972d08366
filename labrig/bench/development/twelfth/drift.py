"""Drift of the twelfth portion: bridges that warm up, a wiper that wears its track, and a mounting that settles."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development.twelfth._sensors import added, any_sensor, sensors, usual


class BridgesWarmUp(Law):
    """Zero of a load cell: its gauges heat themselves once they are fed, and their zero goes with the temperature.

    K. Hoffmann, An Introduction to Measurements using Strain Gages, HBM, 1989. Each session it begins anew, each cell
    with a size and a sign of its own; the other sensors have no bridge.
    """

    effect = "drift"
    needs = frozenset({"force"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._forces = sensors(self.rig, "N")
        count = len(self._forces)
        far = usual(self.rig, setting.path)[self._forces]
        self._tau_s = np.exp(random.uniform(np.log(60.0), np.log(500.0))) * random.uniform(0.8, 1.25, count)
        side = random.choice([-1.0, 1.0], count, p=[0.3, 0.7]) * random.choice([-1.0, 1.0])
        self._size = random.uniform(0.15, 0.4) * random.uniform(0.5, 1.5, count) * side * far

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        warm = -np.expm1(-path.session_s[:, None] / self._tau_s)
        return added(values, self._forces, strength * self._size * warm)


class WiperWearsItsTrack(Law):
    """Worn potentiometer: its wiper rubs its track off, and the reading shifts by the way that it has gone on it.

    J. F. Archard, Contact and rubbing of flat surfaces, J. Applied Physics 24, 1953: what is worn off goes with the
    way. Of one sensor only; rest does it no harm.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig, path = setting.random, self.rig, setting.path
        self._which = any_sensor(setting)
        self._far = float(usual(rig, path)[self._which])
        gone = np.abs(np.diff(rig.settled(path.kpa)[:, self._which])).sum() / self._far
        self._size = random.choice([-1.0, 1.0]) * random.uniform(0.4, 0.9) * self._far / max(float(gone), 1.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        told = values[:, self._which]
        gone = np.cumsum(np.abs(np.diff(told, prepend=told[0]))) / self._far
        return added(values, self._which, strength * self._size * gone)


class MountingSettles(Law):
    """Terzaghi: a sensor's soft pad settles under its screw, with the root of time at first, and then exponentially.

    K. Terzaghi, Theoretical Soil Mechanics, Wiley, 1943, on consolidation. The clock runs from when the sensors were
    mounted, shortly before; each has a pad and a screw of its own, and some sit on metal.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        self._which = sensors(self.rig)
        count = len(self._which)
        soft = random.random(count) < 0.5
        soft[random.integers(count)] = True
        far = usual(self.rig, path)[self._which]
        side = random.choice([-1.0, 1.0], count)
        self._size = np.where(soft, random.uniform(0.2, 0.5, count) * side * far, 0.0)
        whole_s = float(path.time_s[-1] - path.time_s[0])
        self._tau_s = whole_s * np.exp(random.uniform(np.log(0.15), np.log(1.5)))
        self._before_s = random.uniform(20.0, 120.0)

    def _settled(self, time_s: Floats) -> Floats:
        """The degree of consolidation (T,) after times, by Terzaghi's series."""
        odd = np.pi * (np.arange(12)[:, None] + 0.5)
        return 1 - np.sum(2 / odd**2 * np.exp(-(odd**2) * time_s / self._tau_s), axis=0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        since_s = self._before_s + path.time_s - path.time_s[0]
        gone = self._settled(since_s) - self._settled(np.array([self._before_s]))
        return added(values, self._which, strength * gone[:, None] * self._size)
