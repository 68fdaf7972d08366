"""Friction of the sixth portion: bristles that are reset, Dahl's other powers, contacts whose area fills up."""

import numpy as np
from scipy.special import erf

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some
from labrig.bench.development._story import finely, steps


class ResetBristles(Law):
    """Reset integrator: bristles bend up to a length with an extra hold, which they lose as soon as they slide.

    D. A. Haessig, B. Friedland, On the modeling and simulation of friction, J. Dynamic Systems, Measurement, and
    Control 113, 1991.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._long = random.uniform(0.01, 0.03, count)
        self._extra = random.uniform(0.1, 0.4)
        self._held = some(random, count, 0.02, 0.06)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        moves, _, last = finely(path, full(self.rig, kpa), 0.01)
        bend, out = np.zeros(kpa.shape[1]), np.empty_like(moves)
        for t, move in enumerate(moves):
            bend = np.clip(bend + move / self._long, -1.0, 1.0)
            slides = np.clip((np.abs(bend) - 0.97) / 0.03, 0.0, 1.0)
            out[t] = bend * (1 + self._extra * (1 - slides))
        return kpa - strength * self._held * self.rig.high_kpa * out[last]


class BrittleOrDuctile(Law):
    """Dahl's exponent: with a half the force turns along a parabola and is there, with two along a hyperbola.

    P. R. Dahl, Solid friction damping of mechanical vibrations, AIAA J. 14, 1976.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._power = float(random.choice([0.5, 2.0]))
        self._stiff = random.uniform(1 / 0.03, 1 / 0.008, count)
        self._held = some(random, count, 0.02, 0.06)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        force, out, up = np.zeros(deflection.shape[1]), np.empty_like(deflection), 1 - self._power
        for t, move in enumerate(steps(deflection)):
            way = np.sign(move)
            room = np.maximum(1 - way * force, 1e-9)  # how far the force can still go
            base = np.maximum(room**up - up * self._stiff * np.abs(move), 0.0)
            left = np.where(base > 0, np.maximum(base, 1e-12) ** (1 / up), 0.0)
            force = np.where(move != 0, way * (1 - left), force)
            out[t] = force
        return deflection - strength * self._held * out


class AreaFillsUp(Law):
    """Persson: friction goes with the area in true contact, an error function of the load, full at high ones.

    B. N. J. Persson, Theory of rubber friction and contact mechanics, J. Chemical Physics 115, 2001. A part of the load
    is there when vented.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._give = random.uniform(0.005, 0.02, count)
        self._always, self._fills_at = random.uniform(0.02, 0.1), random.uniform(0.2, 0.7)
        self._held = some(random, count, 0.025, 0.07, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        area = np.asarray(erf((self._always + np.abs(load)) / self._fills_at), dtype=float)
        bend, out = np.zeros(kpa.shape[1]), np.empty_like(load)
        for t, move in enumerate(steps(load)):
            bend = np.clip(bend + move / self._give, -1.0, 1.0)
            out[t] = bend
        return kpa - strength * self._held * self.rig.high_kpa * area * out
