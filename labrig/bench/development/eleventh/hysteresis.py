"""Hysteresis of the eleventh portion: rubber as in a bridge's bearings, and cell walls that stick."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import reached
from labrig.bench.development._story import finely


class RubberBearing(Law):
    """Kikuchi-Aiken: from a turn on the force goes over by an exponential with a hump, on the scale of the widest way.

    M. Kikuchi, I. D. Aiken, An analytical hysteresis model for elastomeric seismic isolation bearings, Earthquake
    Engineering and Structural Dynamics 26, 1997. Filled rubber that has once been taken far makes wide loops there,
    and small ones in small motions; the loops' height goes with a power of how far it has been.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._size = random.uniform(0.04, 0.1) * random.uniform(0.85, 1.15, count)
        self._steep = random.uniform(3.0, 8.0)
        self._hump, self._hump_ends = random.uniform(0.5, 2.5), 6.0
        self._power = random.uniform(0.4, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        step, _, where = finely(path, deflection, 0.02)
        count = step.shape[1]
        at, low, high = np.zeros(count), np.zeros(count), np.zeros(count)
        way, since, begun, held = np.ones(count), np.zeros(count), np.zeros(count), np.zeros(count)
        out = np.empty_like(step)
        for i in range(len(step)):
            turns = step[i] * way < 0
            begun, since = np.where(turns, held, begun), np.where(turns, 0.0, since)
            way = np.where(turns, -way, way)
            at, since = at + step[i], since + np.abs(step[i])
            low, high = np.minimum(low, at), np.maximum(high, at)
            widest = np.maximum(0.5 * (high - low), 0.08)
            gone, most = since / widest, way * widest**self._power
            hump = self._hump * gone * np.exp(-self._hump_ends * gone)
            held = most * (1 + hump) + (begun - most) * np.exp(-self._steep * gone)
            out[i] = held
        return deflection - strength * self._size * out[where]


class TackyCells(Law):
    """Tacky walls: cell walls that have met stick, and part later than they met, the later, the harder they pressed.

    K. Kendall, The adhesion and surface energy of elastic solids, J. Physics D 4, 1971; D. Maugis, Contact, Adhesion
    and Rupture of Elastic Solids, Springer, 2000. The patch grows as a root, as round walls flatten on each other; on
    the way back its edge stays where it is until it begins to peel. Bare silicone does so, unless it is powdered.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        most = reached(self.rig, setting.path)
        self._meet = random.uniform(0.15, 0.4) * random.uniform(0.8, 1.2, count) * most
        self._range = most - self._meet
        self._tack = random.uniform(0.25, 0.5) * random.uniform(0.8, 1.2, count)
        self._share = random.uniform(0.15, 0.35) * random.uniform(0.85, 1.15, count)
        self._power = random.uniform(0.5, 0.8)

    def _patch(self, deflection: Floats) -> Floats:
        """How large the patches (..., C) are on the way up."""
        return np.clip((deflection - self._meet) / self._range, 0.0, None) ** self._power

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        up = self._patch(deflection)
        now, pressed = np.zeros(up.shape[1]), np.zeros(up.shape[1])
        out = np.empty_like(up)
        for i in range(len(up)):
            pressed = np.where(now > 0, np.maximum(pressed, up[i]), up[i])
            late = self._tack * np.sqrt(pressed) * self._range
            now = np.clip(
                now, up[i], np.minimum(self._patch(deflection[i] + late), np.maximum(pressed, up[i]))
            )
            out[i] = now
        return deflection + strength * self._share * (out - up)
