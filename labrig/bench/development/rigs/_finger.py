"""A finger of three chambers that bends into an arc of a circle and grows a little longer."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, markers

_COUNT = 8


class Finger(Rig):
    """Constant curvature (R. J. Webster, B. A. Jones, Int. J. Robotics Research 29, 2010); bellows that saturate."""

    kind = "finger"

    def __init__(self, random: np.random.Generator) -> None:
        self.chambers = chambers(3)
        self.high_kpa = random.uniform(60, 150) * random.uniform(0.9, 1.1, 3)
        self.marker_names, self.observables = markers(_COUNT)
        self.noise = float(random.uniform(0.07, 0.14))
        self._length_mm = random.uniform(55, 95)
        self._radius_mm = random.uniform(8, 13)
        around = random.uniform(0, 2 * np.pi) + np.arange(3) * 2 * np.pi / 3 + random.normal(0, 0.05, 3)
        bend_rad = np.deg2rad(random.uniform(45, 100, 3))
        self._bend = -bend_rad[:, None] * np.stack([np.cos(around), np.sin(around)], axis=1)
        self._longer = random.uniform(0.02, 0.08, 3)
        self._curve = random.uniform(0.8, 3.0, 3)
        self._up = np.linspace(0.25, 1.0, _COUNT) + random.normal(0, 0.015, _COUNT)
        side = random.uniform(0, 2 * np.pi) + np.arange(_COUNT) * np.deg2rad(137)
        self._skin_mm = self._radius_mm * np.stack([np.cos(side), np.sin(side)], axis=1)
        self.rest_mm = self.shape(np.zeros((1, 3))).reshape(_COUNT, 3)

    def deflection(self, kpa: Floats) -> Floats:
        return np.arcsinh(self._curve * kpa / self.high_kpa) / np.arcsinh(self._curve)

    def shape(self, deflection: Floats) -> Floats:
        bend = deflection @ self._bend
        angle = np.hypot(bend[:, 0], bend[:, 1])
        toward = bend / np.maximum(angle, 1e-12)[:, None]  # the side to which the tip goes
        turned = angle[:, None] * self._up  # (T, M)
        length = (self._length_mm * (1 + deflection @ self._longer))[:, None] * self._up
        half = np.sinc(turned / (2 * np.pi))
        out = length * half * np.sin(turned / 2)
        up = length * half * np.cos(turned / 2)
        beside = self._skin_mm @ toward.T  # (M, T)
        out = out + beside.T * (np.cos(turned) - 1)
        up = up - beside.T * np.sin(turned)
        flat = self._skin_mm + out[..., None] * toward[:, None]
        return np.concatenate([flat, up[..., None]], axis=2).reshape(len(deflection), -1)
