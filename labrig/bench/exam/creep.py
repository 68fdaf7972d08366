"""Creep: the walls go on giving way under load, by superposition over the past, and recover when vented."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.exam.tools import history, lagged, lagged_each


class Springpot(Law):
    """A fractional Kelvin-Voigt element: creep 1 - E_a(-(t / tau)^a), a Mittag-Leffler function, as a sum of lags.

    R. L. Bagley and P. J. Torvik, Journal of Rheology, 1983.
    """

    effect: ClassVar[str] = "creep"
    needs: ClassVar[frozenset[str]] = frozenset({"holds"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        order = setting.random.uniform(0.3, 0.65)
        rate = np.linspace(-9, 9, 16)
        density = np.sin(order * np.pi) / (np.cosh(order * rate) + np.cos(order * np.pi)) / (2 * np.pi)
        self._share = density / density.sum()
        self._tau_s = setting.random.uniform(5, 40) * np.exp(-rate)
        self._amount = setting.random.uniform(0.06, 0.14) * setting.random.uniform(
            0.85, 1.2, len(setting.rig.chambers)
        )

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """Each share of the deflection follows its own lag."""
        past = history(path, deflection)
        change = np.zeros_like(past.load)
        for share, tau_s in zip(self._share, self._tau_s, strict=True):
            change += share * lagged(past.step_s, past.load, tau_s).real
        return deflection + strength * self._amount * past.back(change)


class Schapery(Law):
    """Nonlinear viscoelasticity: a clock that runs faster under load, and creep that grows more than in proportion.

    R. A. Schapery, Polymer Engineering and Science, 1969.
    """

    effect: ClassVar[str] = "creep"
    needs: ClassVar[frozenset[str]] = frozenset({"holds"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._tau_s = np.array([2.5, 14.0, 80.0]) * random.uniform(0.7, 1.4)
        self._share = random.dirichlet([3.0, 3.0, 3.0])
        self._hurry = random.uniform(0.8, 2.0)
        self._power = random.uniform(1.3, 2.2)
        self._amount = random.uniform(0.06, 0.14)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """Lags of a power of the deflection, in the time that each wall's load makes it feel."""
        past = history(path, deflection)
        size = np.abs(past.load)
        load = np.sign(past.load) * size**self._power
        felt_s = past.step_s[:, None] * np.exp(self._hurry * np.minimum((size[1:] + size[:-1]) / 2, 2.0))
        change = np.zeros_like(load)
        for share, tau_s in zip(self._share, self._tau_s, strict=True):
            change += share * lagged_each(felt_s, load, tau_s)
        return deflection + strength * self._amount * past.back(change)


class BroadProny(Law):
    """A chain with a broad bell of retardation times over six decades of time.

    S. W. Park and R. A. Schapery, International Journal of Solids and Structures, 1999.
    """

    effect: ClassVar[str] = "creep"
    needs: ClassVar[frozenset[str]] = frozenset({"holds"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        decade = np.linspace(-1.5, 4.0, 12)
        bell = np.exp(
            -((decade - setting.random.uniform(0.8, 2.0)) ** 2) / 2 / setting.random.uniform(0.8, 1.6) ** 2
        )
        self._share = bell / bell.sum()
        self._tau_s = 10.0**decade
        self._amount = setting.random.uniform(0.08, 0.2) * setting.random.uniform(
            0.8, 1.25, len(setting.rig.chambers)
        )

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """Each share of the deflection follows its own lag."""
        past = history(path, deflection)
        change = np.zeros_like(past.load)
        for share, tau_s in zip(self._share, self._tau_s, strict=True):
            change += share * lagged(past.step_s, past.load, tau_s).real
        return deflection + strength * self._amount * past.back(change)
