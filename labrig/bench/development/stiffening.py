"""Stiffening: each further kPa moves a wall by less, or by more, than the one before, whatever the history."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some


class CubicSpring(Law):
    """Duffing's cubic spring: a part of the pressure, growing with its cube, is spent on stretching the wall.

    G. Duffing, Erzwungene Schwingungen bei veränderlicher Eigenfrequenz, Vieweg, 1918.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._cubic = some(setting.random, len(self.rig.chambers), 0.15, 0.6, 0.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        cubic = np.maximum(strength * self._cubic, 1e-12)
        scale = 2 / np.sqrt(3 * cubic)  # of x + cubic x^3 = load
        left = scale * np.sinh(np.arcsinh(3 * full(self.rig, kpa) / scale) / 3)
        return np.where(strength * self._cubic > 0, left * self.rig.high_kpa, kpa)


class Fung(Law):
    """Fung's exponential: like soft tissue, a wall's stiffness grows in proportion to its stress.

    Y. C. Fung, Elasticity of soft tissues in simple elongation, American J. Physiology 213, 1967.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._steep = some(setting.random, len(self.rig.chambers), 0.25, 0.9, 0.8)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        steep = np.maximum(strength * self._steep, 1e-9)
        size = np.abs(deflection)
        return deflection + np.sign(deflection) * (np.log1p(steep * size) / steep - size)


class GentLimit(Law):
    """Gent's limiting stretch: the chains of the rubber run out, and the wall cannot go beyond.

    A. N. Gent, A new constitutive relation for rubber, Rubber Chemistry and Technology 69, 1996.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._limit = setting.random.uniform(1.2, 2.2, len(self.rig.chambers))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        tight = strength / self._limit**2
        return 2 * deflection / (1 + np.sqrt(1 + 4 * tight * deflection**2))  # of d = x / (1 - tight x^2)


class SofteningBalloon(Law):
    """Neo-Hookean balloon: rubber gets thinner as it stretches, so that each further kPa moves the wall by more.

    I. Müller, P. Strehlow, Rubber and Rubber Balloons, Springer, 2004.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._near = some(setting.random, len(self.rig.chambers), 0.2, 0.7, 0.8)
        stretch = 1 + 0.38 * np.linspace(0.0, 1.0, 1000) ** 2
        load = stretch**-1 - stretch**-7  # rises up to a stretch of 7^(1/6)
        self._load, self._way = load / load[-1], 6 * (stretch - 1) / load[-1]

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        heavy = np.maximum(strength * self._near, 1e-6)
        near = heavy / (1 + heavy)  # of the load at which a balloon gives way
        further = np.interp(np.minimum(near * np.abs(deflection), 1.0), self._load, self._way)
        return deflection + np.sign(deflection) * (further / near - np.abs(deflection))
