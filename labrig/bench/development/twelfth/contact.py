"""Contact of the twelfth portion: an end stop that one sensor sees and load cells feel, and a soft ball in the way."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import reached, some
from labrig.bench.development.twelfth._sensors import added, any_sensor, sensors, usual


class EndStopOfOneJoint(Law):
    """End stop of one joint: its angle, or its slide, goes no further, or hardly; the load cells feel what it holds.

    P. Flores, H. M. Lankarani, Contact Force Models for Multibody Dynamics, Springer, 2016: a one-sided spring, hard or
    soft. Any other joint goes on as if nothing had been met. It stands nearer than the joint would come.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig, path = setting.random, self.rig, setting.path
        self._which = any_sensor(setting, "deg", "mm", "1/m")
        shown = rig.settled(path.kpa)[:, self._which]
        rest = float(rig.at_rest[self._which])
        self._side = 1.0 if shown.max() - rest > rest - shown.min() else -1.0
        if min(shown.max() - rest, rest - shown.min()) > 0.3 * np.ptp(shown):
            self._side *= random.choice([-1.0, 1.0])
        self._most = float((self._side * shown).max())
        self._nearer = random.uniform(0.2, 0.45) * abs(self._most - self._side * rest)
        self._holds = 1.0 if random.random() < 0.5 else random.uniform(0.5, 0.9)
        self._forces = sensors(rig, "N")
        far = usual(rig, path)
        feels = random.normal(0, 0.4, len(self._forces)) * far[self._forces] / far[self._which]
        self._feels = feels if random.random() < 0.7 else 0.0 * feels

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength == 0:
            return values
        over = self._side * values[:, self._which] - (self._most - strength * self._nearer)
        held = self._holds * np.maximum(over, 0.0)
        values = added(values, self._which, -self._side * held)
        return added(values, self._forces, held[:, None] * self._feels)


class SoftBallInTheWay(Law):
    """Tatara: a pressed rubber ball resists by a power 1.5 at first, and by a third and a fifth power farther on.

    Y. Tatara, On compression of rubber elastic sphere over a large range of displacements, J. Engineering Materials and
    Technology 113, 1991. Some walls meet it on their way.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        most = reached(self.rig, setting.path)
        self._gap = random.uniform(0.25, 0.6) * random.uniform(0.85, 1.15, count) * most
        self._range = np.maximum(most - self._gap, 0.02)
        self._hard = some(random, count, 0.25, 0.6, 0.75)
        self._third, self._fifth = random.uniform(0.2, 1.0), random.uniform(0.2, 1.5)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        aim = np.minimum((deflection - self._gap) / self._range, 50.0)
        low, high = np.zeros_like(aim), np.maximum(aim, 0.0)
        for _ in range(40):
            deep = 0.5 * (low + high)
            force = strength * self._hard * (deep**1.5 + self._third * deep**3 + self._fifth * deep**5)
            further = deep + force < aim
            low, high = np.where(further, deep, low), np.where(further, high, deep)
        held = np.where((aim > 0) & (self._hard > 0), aim - 0.5 * (low + high), 0.0)
        return deflection - self._range * held
