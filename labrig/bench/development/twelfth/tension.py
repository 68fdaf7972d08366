"""Tension of the twelfth portion: a spring of constant force, and a close-wound one that must first be opened."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some


class ConstantForceSpring(Law):
    """Roll spring: a strip that is unrolled pulls back by one and the same force, as soon as it is off its drum.

    F. A. Votta, The theory and design of long-deflection constant-force spring elements, Transactions of the ASME 74,
    1952. It was mounted to bring the rig home, or is another one than modelled: that much of each pressure is spent.
    """

    effect = "tension"
    needs = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._pulls = some(random, count, 0.03, 0.09, share=0.85)
        self._begins = random.uniform(0.03, 0.1)  # of full pressure, until it pulls in full

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        spent = strength * self._pulls * np.tanh(load / (self._begins + strength * self._pulls))
        return deflection + self.rig.deflection((load - spent) * self.rig.high_kpa) - self.rig.deflection(kpa)


class CloseWoundSpring(Law):
    """Initial tension: coils of a close-wound spring press on each other, and open one after another when pulled.

    A. M. Wahl, Mechanical Springs, Penton, 1944. Until they are all open it gives next to nothing; then its rate adds
    to that of the wall, from the initial tension up.
    """

    effect = "tension"
    needs = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._first = random.uniform(0.03, 0.08) * random.uniform(0.8, 1.2, count)
        self._opens = random.uniform(0.04, 0.15)
        self._rate = random.uniform(0.1, 0.6)  # of the initial tension, over a full stroke

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength == 0:
            return deflection
        goes = self.rig.deflection(kpa)
        way, least, most = goes, np.minimum(goes, 0.0), np.maximum(goes, 0.0)
        for _ in range(45):  # halves the interval in which wall and spring together hold the load
            way = 0.5 * (least + most)
            size = np.abs(way)
            pull = self._first * (-np.expm1(-size / self._opens) + self._rate * size)
            left = kpa - strength * pull * np.sign(goes) * self.rig.high_kpa
            further = self.rig.deflection(left) > way
            least, most = np.where(further, way, least), np.where(further, most, way)
        return deflection + way - goes
