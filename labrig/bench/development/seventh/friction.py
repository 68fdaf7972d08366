"""Friction of the seventh portion: a sleeve pulled from one end, and parts that go up a wedge and down again."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some
from labrig.bench.development._story import steps


class PulledFromOneEnd(Law):
    """Pulled from one end: an elastic sleeve slides ever further along its core, and holds by the root of the way.

    L. E. Goodman, J. H. Klumpp, Analysis of slip damping with reference to turbine-blade vibration, J. Applied
    Mechanics 23, 1956. Once it slides along all of its length the force is constant; each turn begins at the end anew.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        whole = random.uniform(0.01, 0.04)
        edges = whole * np.linspace(0.0, 1.0, 7) ** 2
        # so many sliders, each of its own give, that the first loading is a root
        self._give = np.append(0.5 * (edges[1:] + edges[:-1]), whole)[:, None]
        self._part = np.append(0.5 * np.diff(np.sqrt(edges / whole)), 0.5)
        self._held = some(random, count, 0.025, 0.07, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        bend, out = np.zeros((len(self._part), kpa.shape[1])), np.empty_like(load)
        for t, move in enumerate(steps(load)):
            bend = np.clip(bend + move / self._give, -1.0, 1.0)
            out[t] = self._part @ bend
        return kpa - strength * self._held * self.rig.high_kpa * out


class UpTheWedge(Law):
    """Wedge: the load costs the tangent of both angles on the way up, and gives back that of their difference down.

    J. E. Shigley, Mechanical Engineering Design, McGraw-Hill, 1963 (power screws). A spring always loads it a little.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        slope, rubs = np.deg2rad(random.uniform(20, 40)), np.deg2rad(random.uniform(5, 15))
        up, down = np.tan(slope + rubs) / np.tan(slope) - 1, 1 - np.tan(slope - rubs) / np.tan(slope)
        self._up, self._down = up / (up + down), down / (up + down)
        self._always, self._give = random.uniform(0.1, 0.5), random.uniform(0.005, 0.02, count)
        self._held = some(random, count, 0.06, 0.16, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        size = np.abs(deflection)
        bend, out = np.zeros(deflection.shape[1]), np.empty_like(deflection)
        for t, move in enumerate(steps(size)):
            bend = np.clip(bend + move / self._give, -1.0, 1.0)
            out[t] = np.where(bend > 0, self._up, self._down) * bend
        return deflection - strength * self._held * np.tanh(deflection / 0.03) * (self._always + size) * out
