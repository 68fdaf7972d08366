"""Stiffening of the fourth portion: foam that gets dense, fibres that lock, a network of real chains."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some


def _left(load: Floats, spent: Callable[[Floats], Floats]) -> Floats:
    """The loads x (T, C) with x + spent(x) = load, where what is spent on the wall grows from 0 with x."""
    size = np.abs(load)
    low, high = np.zeros_like(size), size.copy()
    for _ in range(32):
        middle = 0.5 * (low + high)
        far = middle + spent(middle) > size
        low, high = np.where(far, low, middle), np.where(far, middle, high)
    return np.sign(load) * 0.5 * (low + high)


class CrushedFoam(Law):
    """Rusch: a foam core gives way hardly at first, then easily, and gets dense in the end: two powers of the way.

    K. C. Rusch, Load-compression behavior of flexible foams, J. Applied Polymer Science 13, 1969.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._first, self._last = random.uniform(0.15, 0.5), random.uniform(3.0, 5.0)
        self._plateau = some(random, count, 0.04, 0.15, 0.85)
        self._dense = random.uniform(1.0, 4.0)  # against the plateau

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa

        def spent(x: Floats) -> Floats:
            return strength * self._plateau * (x**self._first + self._dense * x**self._last)

        return self.rig.high_kpa * _left(full(self.rig, kpa), spent)


class LockingFibres(Law):
    """Holzapfel-Gasser-Ogden: fibres pull with the exponential of their squared strain, hardly and then very hard.

    G. A. Holzapfel, T. C. Gasser, R. W. Ogden, A new constitutive framework for arterial wall mechanics and a
    comparative study of material models, J. Elasticity 61, 2000.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._locks = random.uniform(0.5, 3.0)
        self._fibres = some(random, count, 0.1, 0.4, 0.85)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa

        def spent(x: Floats) -> Floats:
            return strength * self._fibres * x**3 * np.exp(np.minimum(self._locks * x**4, 40.0))

        return self.rig.high_kpa * _left(full(self.rig, kpa), spent)


class RealNetwork(Law):
    """Kilian's van der Waals network: chains attract each other, and soften the wall, until their length runs out.

    H.-G. Kilian, Equation of state of real networks, Polymer 22, 1981.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._stretch = 1 + np.concatenate([[0.0], np.geomspace(1e-5, 8.0, 1600)])
        bent = 0.5 * (self._stretch**2 + 2 / self._stretch - 3)
        longest = random.uniform(4.5, 8.0)
        runs_out = np.minimum(np.sqrt(bent / (0.5 * (longest**2 + 2 / longest - 3))), 0.97)
        attracts = random.uniform(0.15, 0.35)
        force = (self._stretch - self._stretch**-2) * (1 / (1 - runs_out) - attracts * np.sqrt(bent))
        rise = np.maximum(np.diff(force, prepend=0.0), 0.03 * np.diff(self._stretch, prepend=1.0))
        self._force = np.cumsum(rise) / 3.0  # its slope is 1 at first
        self._along = some(random, count, 0.03, 0.12, 0.85)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        along = strength * self._along
        out = deflection.copy()
        for c in np.flatnonzero(along > 1e-4):
            way = np.interp(along[c] * np.abs(out[:, c]), self._force, self._stretch - 1) / along[c]
            out[:, c] = np.sign(out[:, c]) * way
        return out
