"""Stiffening of the seventh portion: foamed rubber, which gets ever softer, and grains that yield by a hyperbola."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some


def _way(free: Floats, load_of: Callable[[Floats], Floats]) -> Floats:
    """The way (T, C) at which a growing `load_of` it is as large as `free`; it keeps the sign."""
    load = np.abs(free)
    low, high = np.zeros_like(load), 12.0 * load + 1e-9
    for _ in range(36):
        middle = 0.5 * (low + high)
        far = load_of(middle) > load
        low, high = np.where(far, low, middle), np.where(far, middle, high)
    return np.sign(free) * 0.5 * (low + high)


class FoamedRubber(Law):
    """Blatz-Ko: foamed rubber pulls by one over the root of its stretch, less one over the cube: ever less so.

    P. J. Blatz, W. L. Ko, Application of finite elastic theory to the deformation of rubbery materials, Trans. Society
    of Rheology 6, 1962. A thin skin around it is as modelled.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._strain = some(random, count, 0.06, 0.2, 0.9)
        self._skin = random.uniform(0.3, 0.6)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        strain = np.maximum(strength * self._strain, 1e-9)

        def load_of(way: Floats) -> Floats:
            stretch = 1 + strain * way
            pull = (stretch**-0.5 - stretch**-3) / (2.5 * strain)
            return self._skin * way + (1 - self._skin) * pull

        return np.where(self._strain > 0, _way(deflection, load_of), deflection)


class GrainsYield(Law):
    """Kondner: a bag of grains carries a hyperbola of the strain: straight at first, and level where the grains yield.

    R. L. Kondner, Hyperbolic stress-strain response: cohesive soils, J. Soil Mechanics and Foundations Division, ASCE
    89, 1963. The wall around them is as modelled; pressure may pack them instead, so that they get stiffer.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._yields = some(random, count, 0.1, 0.35, 0.85)  # one over the strain at half of what they carry
        self._wall = random.uniform(0.25, 0.5)
        self._packs = random.random() < 0.35

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        by = strength * self._yields
        if self._packs:
            size = np.abs(deflection)
            return deflection * (self._wall + (1 - self._wall) / (1 + by * size))

        def load_of(way: Floats) -> Floats:
            return self._wall * way + (1 - self._wall) * way / (1 + by * way)

        return np.where(by > 0, _way(deflection, load_of), deflection)
