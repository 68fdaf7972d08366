"""Stiffening of the fifth portion: walls that level off, elasticity of the second order, chains like worms."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some


class LevelsOff(Law):
    """Voce: as a wall goes on it hardens towards an end, which it nears exponentially; at first it is as modelled.

    E. Voce, The relationship between stress and strain for homogeneous deformation, J. Institute of Metals 74, 1948.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._hardens = some(random, count, 0.1, 0.35, 0.85)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        hardens = strength * self._hardens
        levels = -np.expm1(-hardens * np.abs(deflection)) / np.maximum(hardens, 1e-9)
        return np.where(hardens > 1e-9, np.sign(deflection) * levels, deflection)


class SecondOrder(Law):
    """Second-order elasticity: beside the strain its square counts, so that a wall gets stiffer, or softer, evenly.

    F. D. Murnaghan, Finite Deformation of an Elastic Solid, Wiley, 1951.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._softens = random.random() < 0.35
        self._second = some(random, count, 0.08, 0.3, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        second, size = strength * self._second, np.abs(load)
        if self._softens:  # what it gives way by is the second-order series itself
            return kpa * (1 + second * size)
        return kpa * 2 / (1 + np.sqrt(1 + 4 * second * size))


class WormLikeChains(Law):
    """Worm-like chains: thermally crumpled fibres pull by one over the square of the length that they have left.

    J. F. Marko, E. D. Siggia, Stretching DNA, Macromolecules 28, 1995.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._pulls = random.uniform(0.2, 0.5)  # of the wall's stiffness, at first
        self._reach = some(random, count, 0.25, 0.5, 0.9)  # the way at full load, of the fibres' whole length

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        reach = 0.95 * np.tanh(np.maximum(strength * self._reach, 1e-6) / 0.95)
        load = np.abs(deflection)
        low, high = np.zeros_like(load), np.minimum(load, 0.999 / reach)
        for _ in range(36):
            middle = 0.5 * (low + high)
            x = reach * middle
            more = (0.25 / (1 - x) ** 2 - 0.25 + x) / 1.5 / reach - middle  # beyond the straight part
            far = middle + self._pulls * more > load
            low, high = np.where(far, low, middle), np.where(far, middle, high)
        on = strength * self._reach > 0
        return np.where(on, np.sign(deflection) * 0.5 * (low + high), deflection)
