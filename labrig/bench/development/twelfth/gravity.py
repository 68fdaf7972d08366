"""Gravity of the twelfth portion: links that turn, and slides and load cells on a base that is inclined."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import direction, down
from labrig.bench.development.twelfth._sensors import added, sensors, usual


class LinksTurn(Law):
    """Links that turn: each joint bears the moment of all links beyond it, by the sines of how they stand to the plumb.

    B. Siciliano, L. Sciavicco, L. Villani, G. Oriolo, Robotics: Modelling, Planning and Control, Springer, 2009,
    chapter 7. A payload hangs on the last link. The model lacks all of the weight, at every pose and tilt.
    """

    effect = "gravity"
    needs = frozenset({"angle", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._angles = sensors(self.rig, "deg")
        count = len(self._angles)
        axis = np.array([1.0, 0.0, 0.0]) + 0.5 * direction(random)  # of all joints, near that of the tilt
        axis /= np.linalg.norm(axis)
        first = np.cross(axis, direction(random))
        first /= np.linalg.norm(first)
        self._plane = np.stack([first, np.cross(axis, first)])
        self._beyond = np.triu(np.ones((count, count))) * random.uniform(0.4, 1.0, count)
        self._hangs = 1 / random.uniform(0.1, 0.4)  # per kg, over the last link
        far = usual(self.rig, setting.path)[self._angles]
        self._gives = random.uniform(0.06, 0.15) * random.uniform(0.7, 1.3, count) * far

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        stands = np.cumsum(np.deg2rad(values[:, self._angles]), axis=1)
        pull = down(path.tilt_deg) @ self._plane.T  # along and across the links at zero
        moment = np.cos(stands) * pull[:, 1:] - np.sin(stands) * pull[:, :1]
        moment[:, -1] *= 1 + self._hangs * path.payload_kg
        return added(values, self._angles, strength * self._gives * (moment @ self._beyond.T))


class SlidesOnItsSlope(Law):
    """Slope: on an inclined base a part of the weight acts along each slide and each load cell, as the sine has it.

    J. L. Meriam, L. G. Kraige, Engineering Mechanics: Statics, Wiley, 2012, after S. Stevin. Load cells were tared
    while it stood level; slides, rules and cords give way by the part along them over their stiffness. What hangs on
    the rig counts as well.
    """

    effect = "gravity"
    needs = frozenset({"force", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._which = sensors(rig, "N", "mm", "1/m")
        count = len(self._which)
        main = direction(random)  # most of them lie along one line
        main[0] *= 0.3
        ways = main + 0.4 * np.array([direction(random) for _ in range(count)])
        self._ways = ways / np.linalg.norm(ways, axis=1, keepdims=True)
        far = usual(rig, setting.path)[self._which]
        self._gives = random.uniform(0.06, 0.15) * random.uniform(0.6, 1.4, count) * far
        self._hangs = 1 / random.uniform(0.1, 0.5)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        weight = (1 + self._hangs * path.payload_kg)[:, None] * down(path.tilt_deg)
        along = (weight - np.array([0.0, 0.0, -1.0])) @ self._ways.T
        return added(values, self._which, strength * self._gives * along)
