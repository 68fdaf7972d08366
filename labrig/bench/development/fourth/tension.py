"""Tension of the fourth portion: bands over hinges, preload that is used up, hoops around a core."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Setting
from labrig.bench.development._places import some
from labrig.bench.development.tension import HeldBack


class BandOverHinge(HeldBack):
    """Band over a hinge: its lever goes with the sine of the angle, and is less again once the hinge is far open.

    J. E. Shigley, J. J. Uicker, Theory of Machines and Mechanisms, McGraw-Hill, 1980.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._opens_rad = random.uniform(1.2, 2.6) * random.uniform(0.9, 1.1, count)
        self._tight = some(random, count, 0.06, 0.16, random.uniform(0.6, 1.0))

    def _held(self, deflection: Floats) -> Floats:
        return self._tight * np.sin(np.clip(self._opens_rad * deflection, -np.pi, np.pi))


class PreloadUsedUp(HeldBack):
    """Preload: each part of the way takes as much of it off, until nothing is left and the wall is as free as modelled.

    VDI 2230, Systematic calculation of highly stressed bolted joints, Verein Deutscher Ingenieure, 2003.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._used_at = random.uniform(0.4, 1.0) * random.uniform(0.85, 1.15, count)
        self._tight = some(random, count, 0.2, 0.5, 0.9)

    def _held(self, deflection: Floats) -> Floats:
        return self._tight * deflection * np.maximum(1 - np.abs(deflection) / self._used_at, 0.0)


class TightHoop(HeldBack):
    """Hoop: a band drawn tight around a core presses by its pull over its radius, in full as soon as the wall lifts.

    S. Timoshenko, Strength of Materials, Part II: Advanced Theory and Problems, Van Nostrand, 1930.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._lifts_at = random.uniform(0.05, 0.12)
        self._wider = random.uniform(0.3, 1.5)  # the radius at full deflection, against the core's, less 1
        self._pull = random.uniform(0.04, 0.1) * random.uniform(0.75, 1.25, count)

    def _held(self, deflection: Floats) -> Floats:
        return self._pull * np.tanh(deflection / self._lifts_at) / (1 + self._wider * np.abs(deflection))
