"""Hysteresis of the sixth portion: loops like flags, rubber springs of trains, a back stress and an error function."""

import numpy as np
from scipy.special import erf

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some
from labrig.bench.development._story import finely, steps


class FlagLoops(Law):
    """Flag: only above a load does a wall lose energy, on a band as wide as it is above; unloaded it is where it was.

    C. Christopoulos, A. Filiatrault, B. Folz, Seismic response of self-centring hysteretic SDOF systems, Earthquake
    Engineering and Structural Dynamics 31, 2002.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._above = random.uniform(0.1, 0.4, count)
        self._opens = random.uniform(0.1, 0.25)
        self._give = random.uniform(0.08, 0.2, count)
        self._held = some(random, count, 0.05, 0.12, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        size = np.abs(load)
        wide = np.clip((size - self._above) / self._opens, 0.0, 1.0)
        moves, state, out = steps(size), np.zeros(kpa.shape[1]), np.empty_like(load)
        for t, move in enumerate(moves):
            state = np.clip(state + move / self._give, -wide[t], wide[t])
            out[t] = state
        return kpa - strength * self._held * self.rig.high_kpa * np.sign(load) * out


class TrainsRubberSpring(Law):
    """Berg: after each turn the force nears its limit by a hyperbola of the way since, from wherever it was.

    M. Berg, A non-linear rubber spring model for rail vehicle dynamics analysis, Vehicle System Dynamics 30, 1998.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._half_at = random.uniform(0.04, 0.25) * random.uniform(0.9, 1.1, count)
        self._held = some(random, count, 0.05, 0.12, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        count = deflection.shape[1]
        way, turn, gone, force = np.ones(count), np.zeros(count), np.zeros(count), np.zeros(count)
        out = np.empty_like(deflection)
        for t, move in enumerate(steps(deflection)):
            turned = move * way < 0
            way, turn = np.where(turned, -way, way), np.where(turned, force, turn)
            gone = np.where(turned, 0.0, gone) + np.abs(move)
            force = turn + gone / (self._half_at * (1 - way * turn) + gone + 1e-12) * (way - turn)
            out[t] = force
        return deflection - strength * self._held * out


class RoundedPlateaus(Law):
    """Graesser-Cozzarelli: a force follows the way up to a limit about a back stress, which an error function shapes.

    E. J. Graesser, F. A. Cozzarelli, Shape-memory alloys as new materials for aseismic isolation, J. Engineering
    Mechanics 117, 1991.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._stiff = random.uniform(5, 14, count)  # limits to full scale
        self._power = int(random.choice([1, 3]))
        self._slope, self._comes_back = random.uniform(0.0, 0.5), random.uniform(0.0, 0.8)
        self._steep = random.uniform(1.0, 4.0)
        self._held = some(random, count, 0.04, 0.1, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        moves, _, last = finely(path, full(self.rig, kpa), 0.02)
        way = np.cumsum(moves, axis=0)
        shape = self._comes_back * np.asarray(erf(self._steep * way), dtype=float)
        force, out = np.zeros(kpa.shape[1]), np.empty_like(way)
        for t, move in enumerate(moves):
            back = self._slope * (way[t] - force / self._stiff) + shape[t]
            over = force - back
            force = force + self._stiff * (move - np.abs(move) * np.clip(over, -1.5, 1.5) ** self._power)
            out[t] = force
        # what the wall would do without loss is as modelled: the back stress counts as a part of it
        return kpa - strength * self._held * self.rig.high_kpa * (out - shape - self._slope * way)[last]
