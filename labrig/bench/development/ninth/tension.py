"""Tension of the ninth portion: membranes mounted tighter than modelled, or slacker."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting


def _mounted(setting: Setting, low: float, high: float) -> Floats:
    """One size for the way in which all was clamped, a little different at each chamber, (C,)."""
    count = len(setting.rig.chambers)
    return setting.random.uniform(low, high) * setting.random.uniform(0.8, 1.2, count)


def _held(deflection: Floats, load: Callable[[Floats], Floats], tight: Callable[[Floats], Floats]) -> Floats:
    """How far a membrane comes that needs `tight`, where the modelled one needs `load` for `deflection`."""
    size = np.abs(deflection)
    wanted, low, high = load(size), np.zeros_like(size), size.copy()
    for _ in range(45):
        middle = (low + high) / 2
        enough = tight(middle) > wanted
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    return np.sign(deflection) * (low + high) / 2


class BulgeEquation(Law):
    """Bulge equation: residual stress adds a linear term to the cubic one of the stretching.

    J. J. Vlassak and W. D. Nix, A new bulge test technique for the determination of Young's modulus and
    Poisson's ratio of thin films, Journal of Materials Research 7(12), 1992: p = c1 s t h / a^2 + c2 E t h^3
    / a^4.
    """

    effect = "tension"
    needs = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._stress = _mounted(setting, 0.12, 0.3)
        self._cubic = setting.random.uniform(0.6, 0.85)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        def load(h: Floats) -> Floats:
            return (1 - self._cubic) * h + self._cubic * h**3

        return _held(deflection, load, lambda h: load(h) + strength * self._stress * h)


class Prestretched(Law):
    """Prestretched rubber: a sheet was drawn over its frame by some per cent, and is taut before it bulges.

    J. E. Adkins and R. S. Rivlin, Large elastic deformations of isotropic materials IX: the deformation of
    thin shells, Philosophical Transactions A 244, 1952. The tension goes with 1 - r^-6 at equal stretch r
    both ways; r begins at the prestretch, and grows with the square of the bulge.
    """

    effect = "tension"
    needs = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._drawn = _mounted(setting, 0.015, 0.035)
        self._modelled = setting.random.uniform(1.01, 1.03)
        self._bulge = setting.random.uniform(0.12, 0.25)

    def _load(self, h: Floats, first: Floats | float) -> Floats:
        return h * (1 - (first * (1 + self._bulge * h**2)) ** -6)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        first = self._modelled + strength * self._drawn
        return _held(deflection, lambda h: self._load(h, self._modelled), lambda h: self._load(h, first))


class Slack(Law):
    """Slack: the membrane is longer than its frame, and the first air only blows it out.

    H. M. Irvine, Cable Structures, MIT Press, 1981, on sag from excess length: squares of sags add, as length
    goes with the square of sag. So the slack adds much at first, and little to what the stretching makes at
    full pressure.
    """

    effect = "tension"
    needs = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._sag = _mounted(setting, 0.22, 0.4)
        self._blown = setting.random.uniform(0.15, 0.35)  # the deflection by which the slack is out

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        out = -np.expm1(-((deflection / self._blown) ** 2))
        return np.sign(deflection) * np.sqrt(deflection**2 + strength * self._sag**2 * out)


class TautString(Law):
    """Taut string: drawn aside at its middle, it holds with its tension times the sine of its angle.

    A. H. Nayfeh and D. T. Mook, Nonlinear Oscillations, Wiley, 1979. The tension is what it was mounted with,
    and what its lengthening adds; the model has less of the first. The sine levels off, and lengthening takes
    over.
    """

    effect = "tension"
    needs = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._tighter = _mounted(setting, 0.03, 0.07)
        self._modelled = random.uniform(0.03, 0.06)
        self._slope = random.uniform(0.7, 1.2)

    def _load(self, h: Floats, tension: Floats | float) -> Floats:
        length = np.sqrt(1 + (self._slope * h) ** 2)
        return (tension + length - 1) * self._slope * h / length

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        tension = self._modelled + strength * self._tighter
        return _held(deflection, lambda h: self._load(h, self._modelled), lambda h: self._load(h, tension))


class CapOfLaplace(Law):
    """Cap of Laplace: a constant tension in the skin holds a cap of height h by its curvature.

    L. R. G. Treloar, Strains in an inflated rubber sheet, and the mechanism of bursting, Transactions of the
    Institution of the Rubber Industry 19, 1944; p = 4 T h / (a^2 + h^2) is Laplace's law, and falls again
    beyond the half sphere.
    """

    effect = "tension"
    needs = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._tension = _mounted(setting, 0.15, 0.35)
        self._height = random.uniform(0.7, 1.3)  # of the cap at full pressure, as a share of its radius
        self._power = random.uniform(1.8, 2.6)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        def load(h: Floats) -> Floats:
            return 0.25 * h + 0.75 * h**self._power

        def tight(h: Floats) -> Floats:
            return load(h) + strength * self._tension * h / (1 + (self._height * h) ** 2)

        return _held(deflection, load, tight)
