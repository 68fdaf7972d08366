"""Friction: the walls stay behind where they turn round, until they slip."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.exam.tools import history, stopped


class IwanPresliding(Law):
    """Many small sliders in parallel, with slip limits by a power law: they slip one after another before all slide.

    W. D. Iwan, Journal of Applied Mechanics, 1966, with the limits of D. J. Segalman, ibid., 2005.
    """

    effect: ClassVar[str] = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        largest = random.uniform(0.06, 0.18)
        self._width = largest * np.linspace(0.125, 1.0, 8) ** random.uniform(1.0, 2.0)
        share = self._width ** random.uniform(-0.6, 0.2)
        self._share = share / (share * self._width).sum()
        self._amount = random.uniform(0.02, 0.05) * random.uniform(0.8, 1.25, len(setting.rig.chambers))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """The sliders' forces hold the walls back."""
        past = history(path, deflection)
        force = np.einsum("njc,j->nc", stopped(past.load, self._width), self._share)
        return deflection - strength * self._amount * past.back(force)


class Capstan(Law):
    """A fibre wrapped around each chamber: its tension falls by exp(-mu angle), against the motion.

    M. Kaneko, M. Wada, H. Maekawa and K. Tanie, IEEE International Conference on Robotics and Automation, 1991.
    """

    effect: ClassVar[str] = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._mu = random.uniform(0.03, 0.07) * random.uniform(0.8, 1.25, len(setting.rig.chambers))
        self._wrap_rad = random.uniform(0.5, 1.0)
        self._more_rad = random.uniform(0.3, 0.9)
        self._slip = random.uniform(0.02, 0.08)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """What arrives of each wall's load, less while it rises and more while it falls."""
        past = history(path, deflection)
        way = past.back(stopped(past.load, np.array([self._slip]))[:, 0]) / self._slip
        angle = self._wrap_rad + self._more_rad * np.clip(deflection, 0, 3)
        return deflection * np.exp(-strength * self._mu * angle * way)
