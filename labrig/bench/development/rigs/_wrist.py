"""A wrist that three or four pneumatic muscles tilt about two axes, with one encoder on each."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers

_STEPS = 10


class Wrist(Rig):
    """McKibben muscles around a universal joint: the tilt at which their torques and a spring's balance.

    F. Daerden, D. Lefeber, Pneumatic artificial muscles, European J. Mechanical and Environmental Engineering 47, 2002.
    A muscle pulls less the more it is contracted, so that each one's stiffness counts against all the others.
    """

    kind = "wrist"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(3, 5))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(200, 450) * random.uniform(0.95, 1.05, count)
        self.observables = (Observable("pitch", "deg"), Observable("roll", "deg"))
        self.noise = float(random.uniform(0.06, 0.14))
        around = random.uniform(0, 2 * np.pi) + np.arange(count) * 2 * np.pi / count
        around += random.normal(0, 0.05, count)
        self._arm = np.stack([np.cos(around), np.sin(around)], axis=1)
        self._short = random.uniform(0.35, 0.6)  # contraction that a tilt of 1 rad makes, along an arm
        self._before = random.uniform(0.05, 0.1)  # contraction when level
        self._angle = random.uniform(2.6, 3.2)  # 3 / tan^2 of the braid's angle
        self._pull = random.uniform(0.9, 1.1, count)
        self._spring = random.uniform(0.5, 1.2) * np.array([1.0, random.uniform(0.7, 1.4)])
        self._zero_deg = random.uniform(-2, 2, 2)
        self._sticks = random.uniform(0.2, 0.7, count)  # share that comes once the bladder fills the braid
        self._fills = random.uniform(0.01, 0.08, count)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        fills = load**2 * (1 + self._fills) / (load**2 + self._fills)
        return load * (1 - self._sticks + self._sticks * fills)

    def shape(self, deflection: Floats) -> Floats:
        pull, level = np.maximum(deflection * self._pull, 0.0), (1 - self._before) ** 2
        pushes = np.minimum(deflection * self._pull, 0.0) * (self._angle * level - 1)
        tilt = np.zeros((len(deflection), 2))
        for _ in range(_STEPS):  # Newton; a muscle pulls with (1 - contraction)^2, so its slope never turns
            left = 1 - self._before - self._short * tilt @ self._arm.T
            force = (pull * (self._angle * left * np.abs(left) - 1) + pushes) / (self._angle - 1)
            stiff = pull * 2 * self._angle * self._short * np.abs(left) / (self._angle - 1)
            rest = force @ self._arm - self._spring * tilt
            slope = np.einsum("tc,cx,cy->txy", stiff, self._arm, self._arm) + np.diag(self._spring)
            tilt = tilt + np.clip(np.linalg.solve(slope, rest[..., None])[..., 0], -0.5, 0.5)
        return self._zero_deg + np.rad2deg(tilt)
