"""A pneumatic muscle that pulls at a force sensor, or two that pull against each other."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers


class Muscle(Rig):
    """Force at fixed length: nearly proportional to pressure, or curved: the bladder must first fill its sleeve."""

    kind = "muscle"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(1, 3))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(200, 450) * random.uniform(0.95, 1.05, count)
        self.observables = (Observable("force", "N"),)
        self.noise = float(random.uniform(0.15, 0.35))
        self._pull_n = random.uniform(40, 95, count) * np.array([1.0, -1.0])[:count]
        self._together = random.uniform(-0.15, 0.15)
        curved = random.random() < 0.5
        self._sleeve = random.uniform(0.3, 0.7, count) if curved else random.uniform(0.0, 0.05, count)
        self._fills_at = random.uniform(0.15, 0.3, count)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        taken = self._sleeve * self._fills_at
        held_back = taken * np.tanh(load / self._fills_at)
        return (load - held_back) / (1 - taken * np.tanh(1 / self._fills_at))

    def shape(self, deflection: Floats) -> Floats:
        force_n = deflection @ self._pull_n
        if len(self.chambers) == 2:
            force_n = force_n + self._together * abs(self._pull_n[1]) * deflection.prod(axis=1)
        return force_n[:, None]
