"""Stiffening of the tenth portion: logarithmic strain, and pleats that unfold one after another."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting


class LogarithmicStrain(Law):
    """Hencky: the wall's true stress goes with the logarithm of its stretch, and it thins: its load levels off early.

    H. Hencky, Welche Umstände bedingen die Verfestigung bei der bildsamen Verformung von festen isotropen Körpern?,
    Zeitschrift für Physik 55, 1929. The load is the logarithm of the stretch over the stretch, to a power that tells
    along how many directions it thins; the model's wall is right at half pressure.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._strain = random.uniform(0.12, 0.3) * random.uniform(0.9, 1.1, count)  # at full pressure
        self._thins = random.uniform(0.6, 1.4)
        self._right = random.uniform(0.4, 0.7)  # the deflection at which both agree
        self._stiffer = random.choice([-1.0, 1.0])  # the model's wall may be the one that thins

    def _softened(self, deflection: Floats, strain: Floats) -> Floats:
        """How much further (factor) such a wall is than a linear one."""
        stretch = 1 + strain * np.clip(deflection, -0.9, 3.0)
        small = np.abs(stretch - 1) < 1e-6
        log = np.where(small, 1.0, np.log(stretch) / np.where(small, 1.0, stretch - 1))
        return stretch**self._thins / log

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        strain = 1 - np.exp(-strength * self._strain)
        as_modelled = self._softened(np.full_like(deflection, self._right), strain)
        ratio = self._softened(deflection, strain) / as_modelled
        return deflection * ratio**self._stiffer


class PleatsOneByOne(Law):
    """Unfolding in turn: pleats open one after another, each with a stretch of little stiffness and one of much.

    J. T. B. Overvelde, T. Kloek, J. J. A. D'haen, K. Bertoldi, Amplifying the response of soft actuators by harnessing
    snap-through instabilities, PNAS 112(35), 2015. The pleats here do not snap. Each opens over a range of loads of its
    own, as a logistic curve, and what is between two of them is stiffer than modelled.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        pleats = int(random.integers(2, 5))
        even = (np.arange(pleats) + 0.5) / pleats
        self._opens = even[:, None] + random.normal(0, 0.06 / pleats, (pleats, count))
        self._within = random.uniform(0.09, 0.16) / pleats
        self._share = random.uniform(0.3, 0.6) * random.uniform(0.85, 1.15, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        at = 0.5 * (1 + np.tanh((deflection[:, None] - self._opens) / (2 * self._within)))
        none = 0.5 * (1 + np.tanh(-self._opens / (2 * self._within)))
        every = 0.5 * (1 + np.tanh((1 - self._opens) / (2 * self._within)))
        stairs = np.mean(at - none, axis=1) / np.mean(every - none, axis=0)
        inside = np.where((deflection > 0) & (deflection < 1), stairs - deflection, 0.0)
        return deflection + strength * self._share * inside
