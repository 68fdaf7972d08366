"""Tension: the skin was mounted tighter than modelled: it holds the walls back, less and less as they come out."""

from abc import abstractmethod

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting


class HeldBack(Law):
    """What the laws below share: a part of the pressure, set by the deflection itself, is spent on the tension."""

    effect = "tension"
    needs = frozenset({"curved"})

    @abstractmethod
    def _held(self, deflection: Floats) -> Floats:
        """The share (T, C) of the upper limits that the tension takes at a deflection, at strength 1."""

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        free = self.rig.deflection(kpa)
        low, high = np.minimum(free, 0.0), np.maximum(free, 0.0)
        for _ in range(22):  # halves the interval in which the deflection lies
            middle = 0.5 * (low + high)
            left = self.rig.deflection(kpa - strength * self.rig.high_kpa * self._held(middle))
            far = middle > left
            low, high = np.where(far, low, middle), np.where(far, middle, high)
        return deflection + (0.5 * (low + high) - free)


class LaplaceTension(HeldBack):
    """Laplace's law in a bulge test: a residual stress holds back in proportion to the bulge's height.

    M. K. Small, W. D. Nix, Analysis of the accuracy of the bulge test in determining the mechanical properties of thin
    films, J. Materials Research 7, 1992.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._tight = setting.random.uniform(0.08, 0.25) * setting.random.uniform(
            0.8, 1.2, len(self.rig.chambers)
        )

    def _held(self, deflection: Floats) -> Floats:
        return self._tight * deflection


class StringTension(HeldBack):
    """Tight strings: a constant pull along the skin acts against the load by the sine of its slope, up to a limit.

    S. S. Antman, Nonlinear Problems of Elasticity, 2nd ed., Springer, 2005.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._pull = setting.random.uniform(0.05, 0.15) * setting.random.uniform(0.8, 1.2, count)
        self._reach = setting.random.uniform(0.2, 0.6)

    def _held(self, deflection: Floats) -> Floats:
        return self._pull * deflection / np.hypot(deflection, self._reach)


class OrthotropicTension(HeldBack):
    """Warp and weft: the two pulls of a fabric differ, so that some chambers are held back far more than others.

    B. Forster, M. Mollaert, European Design Guide for Tensile Surface Structures, TensiNet, 2004.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        angle, aspect = random.uniform(0, np.pi, count), random.uniform(1.0, 1.8, count)
        warp, weft = random.uniform(0.1, 0.35), random.uniform(0.0, 0.1)
        across = np.cos(angle) ** 2 * aspect + np.sin(angle) ** 2 / aspect
        self._tight = (warp * across + weft / across) / aspect
        self._fades_at = random.uniform(0.4, 1.0)

    def _held(self, deflection: Floats) -> Floats:
        return self._tight * deflection / (1 + (deflection / self._fades_at) ** 2)
