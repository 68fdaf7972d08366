"""A glove whose four or five finger actuators each press on a force sensor."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers


class Glove(Rig):
    """Blocked force: a finger first closes a gap, and then presses in proportion to its pressure.

    P. Polygerinos et al., Soft robotic glove for combined assistance and at-home rehabilitation, Robotics and
    Autonomous Systems 73, 2015. The palm passes a little of each finger's force on to its neighbours.
    """

    kind = "glove"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(4, 6))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(120, 250) * random.uniform(0.95, 1.05, count)
        self.observables = tuple(Observable(f"f{i + 1}", "N") for i in range(count))
        self.noise = float(random.uniform(0.02, 0.05))
        apart = np.abs(np.arange(count)[:, None] - np.arange(count))
        passed = random.uniform(0.01, 0.08) * np.exp(1.0 - apart) * random.choice([-1.0, 1.0], p=[0.7, 0.3])
        self._force_n = random.uniform(5, 14) * random.uniform(0.7, 1.2, count)
        self._mix = np.where(apart == 0, 1.0, passed)
        self._gap = random.uniform(0.0, 0.35, count)
        self._rounded = random.uniform(0.03, 0.12, count)

    def deflection(self, kpa: Floats) -> Floats:
        def press(load: Floats) -> Floats:
            return self._rounded * np.logaddexp(0.0, (load - self._gap) / self._rounded)

        none = press(np.zeros(len(self._gap)))
        return (press(kpa / self.high_kpa) - none) / (press(np.ones(len(self._gap))) - none)

    def shape(self, deflection: Floats) -> Floats:
        return (deflection * self._force_n) @ self._mix
