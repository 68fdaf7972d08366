"""A sheet, clamped at one edge, that coils bend up and down: set-points of both signs, and up to fifty markers."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, markers

_ROOTS = np.array([1.8751, 4.6941, 7.8548])  # of cos x cosh x = -1


class Sheet(Rig):
    """Bending modes of a clamped sheet, driven by magnetic coils whose pull saturates either way.

    G. Z. Lum et al., Shape-programmable magnetic soft matter, PNAS 113, 2016; modes after S. Timoshenko, Vibration
    Problems in Engineering, 2nd ed., Van Nostrand, 1937. What is bent comes nearer to the clamp. A coil's current is
    commanded like a pressure (kPa on its surface), and may be turned round.
    """

    kind = "sheet"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(2, 6))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(5, 30) * random.uniform(0.9, 1.1, count)
        self._low_kpa = -self.high_kpa * random.uniform(0.5, 1.0)
        rows, across = int(random.integers(5, 11)), int(random.integers(4, 6))
        self.marker_names, self.observables = markers(rows * across)
        self.noise = float(random.uniform(0.05, 0.1))
        long_mm, wide_mm = random.uniform(70, 130), random.uniform(40, 80)
        u, v = np.meshgrid((np.arange(rows) + 1) / rows, np.linspace(-1, 1, across), indexing="ij")
        u = np.clip(u.ravel() + random.normal(0, 0.015, u.size), 0.05, 1.0)
        v = v.ravel() + random.normal(0, 0.03, v.size)
        self.rest_mm = np.column_stack([long_mm * u, 0.5 * wide_mm * v, 0.0 * u])
        lift, steep = _modes(u)
        sideways = np.stack([np.ones_like(v), v, 0.5 * (3 * v**2 - 1)])
        size = np.array([1.0, 0.25, 0.08])[:, None] * np.array([1.0, 0.5, 0.2])
        mix = random.normal(size=(count, 3, 3)) * size + 0.8 * random.choice([-1.0, 1.0]) * (size > 0.9)
        height_mm = long_mm * random.uniform(0.12, 0.25)
        self._lift_mm = height_mm * np.einsum("cab,am,bm->cm", mix, lift, sideways)
        self._steep = height_mm / long_mm * np.einsum("cab,am,bm->cm", mix, steep, sideways)
        self._near_mm = 0.35 * long_mm * u
        self._saturates = random.uniform(0.3, 2.5, count)

    @property
    def low_kpa(self) -> Floats:
        return self._low_kpa

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * np.sqrt((1 + self._saturates) / (1 + self._saturates * load**2))

    def shape(self, deflection: Floats) -> Floats:
        assert self.rest_mm is not None
        up, slope = deflection @ self._lift_mm, deflection @ self._steep
        moved = np.stack([-self._near_mm * slope**2, 0.0 * up, up], axis=2)
        return (self.rest_mm + moved).reshape(len(deflection), -1)


def _modes(u: Floats) -> tuple[Floats, Floats]:
    """The first three bending modes of a cantilever, 1 at the tip, and their slopes, (3, M) at places `u` (M,)."""
    root = _ROOTS[:, None]
    share = (np.cosh(root) + np.cos(root)) / (np.sinh(root) + np.sin(root))

    def mode(x: Floats) -> Floats:
        return np.cosh(x) - np.cos(x) - share * (np.sinh(x) - np.sin(x))

    x, tip = root * u, mode(root)
    slope = np.sinh(x) + np.sin(x) - share * (np.cosh(x) - np.cos(x))
    return mode(x) / tip, root * slope / tip
