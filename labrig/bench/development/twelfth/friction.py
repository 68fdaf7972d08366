"""Friction of the twelfth portion, in single joints: Dahl's, which the load cells feel, and that of a loaded pivot."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._story import finely
from labrig.bench.development.twelfth._sensors import added, loaded, sensors, usual


class DahlInTheJoint(Law):
    """Dahl, in a joint: bearings hold each angle back by a force that turns exponentially, which load cells feel.

    P. R. Dahl, A solid friction model, Aerospace Corporation TOR-0158, 1968. What holds the joint is missing, or is
    too much, in what pulls at it, so that angles and forces are both off, with the same memory.
    """

    effect = "friction"
    needs = frozenset({"angle"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._angles, self._forces = sensors(rig, "deg"), sensors(rig, "N")
        self._far = usual(rig, setting.path)
        self._size = random.uniform(0.04, 0.1) * random.uniform(0.7, 1.3, len(self._angles))
        self._gives = random.uniform(0.05, 0.2)  # the way, in usual ones, in which most of the force turns
        passes = random.normal(0, 0.5, (len(self._angles), len(self._forces)))
        self._passes = random.uniform(0.3, 0.8) * passes * self._far[self._forces]

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        way = (values - self.rig.at_rest)[:, self._angles] / self._far[self._angles]
        step, _, where = finely(path, way, 0.02)
        force = np.zeros(step.shape[1])
        out = np.empty_like(step)
        for i in range(len(step)):
            way_on = np.where(step[i] < 0, -1.0, 1.0)
            force = way_on + (force - way_on) * np.exp(-np.abs(step[i]) / self._gives)
            out[i] = force
        held = strength * self._size * out[where]
        values = added(values, self._angles, -held * self._far[self._angles])
        return added(values, self._forces, held @ self._passes)


class LoadedPivot(Law):
    """Loaded pivot: a plain bearing's friction goes with what presses on its pin, so with what all the chambers pull.

    C.-A. de Coulomb, Théorie des machines simples, 1785, on pins; the friction circle of every textbook. A joint that
    is pulled from both sides at once stays where it was; let loose it goes nearly where it should.
    """

    effect = "friction"
    needs = frozenset({"angle"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._angles = sensors(self.rig, "deg")
        far = usual(self.rig, setting.path)[self._angles]
        self._size = random.uniform(0.12, 0.25) * random.uniform(0.7, 1.3, len(far)) * far
        self._weight = random.uniform(0.05, 0.2)  # what presses on the pin anyway

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        free = values[:, self._angles]
        wide = strength * self._size * (self._weight + loaded(self.rig, deflection))[:, None]
        at = self.rig.at_rest[self._angles]
        out = np.empty_like(free)
        for i in range(len(free)):
            at = np.clip(at, free[i] - wide[i], free[i] + wide[i])
            out[i] = at
        return added(values, self._angles, out - free)
