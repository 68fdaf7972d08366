"""Drift of the eighth portion: with the clock, with warmth, with the heating, of gauges, and with damp air."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import direction, shift, smooth_field, span, spread


def _lasts_s(path: Path) -> float:
    """How long a campaign lasts, in s."""
    return float(max(path.time_s[-1] - path.time_s[0], 1.0))


class ClockDrift(Law):
    """Drift with the clock: what is read goes away steadily, all of it in one direction, whatever the rig does.

    Joint Committee for Guides in Metrology, International Vocabulary of Metrology (VIM), JCGM 200, 2012: 4.21,
    instrumental drift.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        size = random.uniform(0.1, 0.2) * span(rig)
        if rig.rest_mm is None:
            away = random.normal(size=len(rig.observables))
            self._away = size * away / np.sqrt(np.mean(away**2))
        else:
            self._away = np.sqrt(3) * size * shift(rig, direction(random))
        self._lasts_s, self._start_s = _lasts_s(setting.path), setting.path.time_s[0]

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * ((path.time_s - self._start_s) / self._lasts_s)[:, None] * self._away


class SoftensAsItWarms(Law):
    """Softens as it warms: once the lamps are on, the walls warm exponentially, and get softer or stiffer.

    L. R. G. Treloar, The Physics of Rubber Elasticity, Clarendon Press, 1975: the stress of rubber at a given stretch
    goes with the absolute temperature, where plastics and their fillers get softer instead.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tau_s = random.uniform(0.2, 0.7) * _lasts_s(setting.path)
        self._start_s = setting.path.time_s[0]
        more = random.choice([-1.0, 1.0], p=[0.3, 0.7]) * random.uniform(0.1, 0.2)
        self._more = more * random.uniform(0.8, 1.2, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        warm = -np.expm1(-(path.time_s - self._start_s) / self._tau_s)
        return deflection * np.exp(strength * self._more * warm[:, None])


class HeatingOnAndOff(Law):
    """Heating on and off: a thermostat lets the room warm and cool in turns, and what holds the rig grows and shrinks.

    S. T. Smith, D. G. Chetwynd, Foundations of Ultraprecision Mechanism Design, Gordon and Breach, 1992, on thermal
    loops. The room goes up exponentially, and down more slowly.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._on_s, self._off_s = random.uniform(120.0, 420.0), random.uniform(300.0, 900.0)
        self._phase_s = random.uniform(0.0, self._on_s + self._off_s)
        self._bend = random.uniform(0.5, 2.0, 2)
        size = random.uniform(0.1, 0.2) * span(rig)
        away = shift(rig, direction(random)) * random.uniform(0.8, 1.2, len(rig.observables))
        self._away = size * away / np.sqrt(np.mean(away**2))

    def _warm(self, time_s: Floats) -> Floats:
        since = (time_s + self._phase_s) % (self._on_s + self._off_s)
        up, down = since / self._on_s, (since - self._on_s) / self._off_s
        rises = np.expm1(-self._bend[0] * up) / np.expm1(-self._bend[0])
        falls = 1 - np.expm1(-self._bend[1] * down) / np.expm1(-self._bend[1])
        return 2 * np.where(up < 1, rises, falls) - 1

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._warm(path.time_s)[:, None] * self._away


class GaugesWalk(Law):
    """Gauges that walk: the zero of each regulator's gauge goes up and down at random, the further the longer it takes.

    IEEE Std 952-1997, on rate random walk. A regulator holds what its gauge reads, so that the true pressure walks.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig, path = setting.random, self.rig, setting.path
        knots, count = 160, len(rig.chambers)
        self._time_s = np.linspace(path.time_s[0], path.time_s[-1], knots)
        far = random.uniform(0.06, 0.12) * random.uniform(0.5, 1.2, count) * rig.high_kpa
        walk = np.cumsum(random.normal(size=(knots, count)), axis=0)
        walk -= walk[0]
        self._zero_kpa = far * walk / np.maximum(np.sqrt(np.mean(walk**2, axis=0)), 1e-9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        zero = [np.interp(path.time_s, self._time_s, own) for own in self._zero_kpa.T]
        return kpa + strength * np.column_stack(zero)


class NylonDrinksWater(Law):
    """Nylon drinks water: fabric from a dry box swells in damp air, with the root of time until it has enough.

    J. Crank, The Mathematics of Diffusion, Clarendon Press, 1956. It swells unevenly, and warps the body.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._full_s = random.uniform(0.5, 1.5) * _lasts_s(setting.path)
        self._start_s = setting.path.time_s[0]
        numbers = random.normal(size=len(rig.observables))
        warp = numbers if rig.rest_mm is None else spread(rig, smooth_field(setting))
        self._warp = random.uniform(0.1, 0.18) * span(rig) * warp / np.sqrt(np.mean(warp**2))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        soaked = np.tanh(np.sqrt(np.maximum(path.time_s - self._start_s, 0.0) / self._full_s))
        return values + strength * soaked[:, None] * self._warp
