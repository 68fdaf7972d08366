"""A joint that two pneumatic muscles turn against each other, with one angle that an encoder reads."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers


class Joint(Rig):
    """Antagonists on a pulley: the difference of their pulls turns it, their sum and a spring hold it.

    C.-P. Chou, B. Hannaford, Measurement and modeling of McKibben pneumatic artificial muscles, IEEE Trans. Robotics
    and Automation 12, 1996. A muscle pulls only once its bladder has filled the braid.
    """

    kind = "joint"

    def __init__(self, random: np.random.Generator) -> None:
        self.chambers = chambers(2)
        self.high_kpa = random.uniform(180, 400) * random.uniform(0.95, 1.05, 2)
        self.observables = (Observable("angle", "deg"),)
        self.noise = float(random.uniform(0.08, 0.18))
        self._spring = random.uniform(0.4, 1.2)
        self._firm = random.uniform(0.4, 1.0, 2)
        self._pull_deg = random.uniform(35, 60) * random.uniform(0.92, 1.08, 2) * np.array([1.0, -1.0])
        self._zero_deg = random.uniform(-3, 3)
        self._fills_at = random.uniform(0.02, 0.3, 2)

    def deflection(self, kpa: Floats) -> Floats:
        load, slack = kpa / self.high_kpa, self._fills_at
        return load * np.abs(load) * (1 + slack) / (np.abs(load) + slack)

    def shape(self, deflection: Floats) -> Floats:
        firm = np.hypot(deflection, 0.05) - 0.05
        stiff = 1 + firm @ self._firm / self._spring
        most = 1 + self._firm.mean() / self._spring
        angle = deflection @ self._pull_deg * most / stiff
        return (self._zero_deg + angle)[:, None]
