"""Drift: something changes with the clock or the temperature, whatever the pressures do."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import direction, shift, some, span


def _session_length_s(path: Path) -> float:
    """How long the longest session is looked at."""
    return max(float(path.session_s[path.row].max()), 1.0)


class SteadyDrift(Law):
    """Zero drift: everything that is measured moves away steadily, from the start of each session.

    J. P. Bentley, Principles of Measurement Systems, 4th ed., Pearson, 2005.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        size = span(self.rig) * setting.random.uniform(0.05, 0.15)
        self._per_s = shift(self.rig, size * direction(setting.random)) / _session_length_s(setting.path)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * path.session_s[:, None] * self._per_s


class CameraWarmUp(Law):
    """Warm-up: the measuring frame moves exponentially towards where it stays once the cameras are warm.

    H. Handel, Analyzing the influences of camera warm-up effects on image acquisition, Asian Conference on Computer
    Vision, Springer LNCS 4844, 2007.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._way = shift(
            self.rig, span(self.rig) * setting.random.uniform(0.08, 0.2) * direction(setting.random)
        )
        self._tau_s = _session_length_s(setting.path) * setting.random.uniform(0.12, 0.5)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values - strength * np.expm1(-path.session_s / self._tau_s)[:, None] * self._way


class Wander(Law):
    """Random walk: the zero wanders smoothly, otherwise in each session (the slowest waves of Brownian motion).

    M. Loève, Probability Theory II, 4th ed., Springer, 1978.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._length_s = _session_length_s(setting.path)
        sessions = int(setting.path.session.max()) + 1
        waves = np.arange(4) + 0.5
        size = span(self.rig) * setting.random.uniform(0.05, 0.15)
        each = setting.random.normal(size=(sessions, 4, 3)) / waves[:, None]
        self._waves, self._each = np.pi * waves, size * shift(self.rig, each)  # (S, 4, K)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        wave = np.sin(path.session_s[:, None] / self._length_s * self._waves)  # (T, 4)
        change = np.zeros_like(values)
        for session in np.unique(path.session):
            here = path.session == session
            change[here] = wave[here] @ self._each[session % len(self._each)]
        return values + strength * change


class WarmingRubber(Law):
    """Gain drift: the rubber's modulus follows its temperature, which nears the room's through each session.

    L. R. G. Treloar, The Physics of Rubber Elasticity, 3rd ed., Clarendon Press, 1975.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        sign = float(setting.random.choice([-1.0, 1.0], p=[0.3, 0.7]))
        self._gain = (
            sign
            * setting.random.uniform(0.05, 0.15)
            * setting.random.uniform(0.7, 1.3, len(self.rig.chambers))
        )
        self._tau_s = _session_length_s(setting.path) * setting.random.uniform(0.3, 1.5)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        warmed = -np.expm1(-path.session_s / self._tau_s)[:, None] / -np.expm1(-1.0)
        return deflection * np.exp(strength * self._gain * warmed)


class SensorZeroDrift(Law):
    """Thermal zero shift: the zeros of the pressure sensors move with the electronics' temperature.

    J. Fraden, Handbook of Modern Sensors, 4th ed., Springer, 2010.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._zero = some(setting.random, count, 0.03, 0.1, 0.8) * setting.random.choice([-1.0, 1.0])
        self._tau_s = _session_length_s(setting.path) * setting.random.uniform(0.2, 1.5)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        warmed = -np.expm1(-path.session_s / self._tau_s)[:, None]
        return kpa + strength * self.rig.high_kpa * self._zero * warmed
