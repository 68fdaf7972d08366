"""Drift: the response changes with the clock or the temperature, whatever is done."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.exam.tools import pattern, scale


class RoomTemperature(Law):
    """A room that is heated and cools in cycles: rubber is stiffer when warm, and the mount of the body grows.

    L. R. G. Treloar, The Physics of Rubber Elasticity, Oxford University Press, 1975.
    """

    effect: ClassVar[str] = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._period_s = random.uniform(700, 2400)
        self._phase = random.uniform(0, 2 * np.pi)
        self._gain = random.uniform(0.01, 0.04)
        self._offset = random.uniform(0.01, 0.04) * scale(setting) * pattern(setting)

    def _warm(self, path: Path) -> Floats:
        return np.sin(2 * np.pi * path.time_s / self._period_s + self._phase)[:, None]

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """The walls give way less while it is warm."""
        return deflection * (1 - strength * self._gain * self._warm(path))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """The mount moves all."""
        return values + strength * self._offset * self._warm(path)


class LogSettling(Law):
    """A mount that settles with the logarithm of time since each session's start, less in later sessions.

    A. Amir, Y. Oreg and Y. Imry, Proceedings of the National Academy of Sciences, 2012 (logarithmic relaxation).
    """

    effect: ClassVar[str] = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._first_s = random.uniform(20, 150)
        self._later = random.uniform(0.4, 0.9)
        self._offset = random.uniform(0.02, 0.05) * scale(setting) * pattern(setting)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """All sinks along with the mount."""
        number = path.session - path.session.min()
        sunk = self._later**number * np.log1p(np.maximum(path.session_s, 0.0) / self._first_s)
        return values + strength * sunk[:, None] * self._offset


class RandomWalk(Law):
    """A zero that walks at random: the variance of its offset grows with time.

    D. W. Allan, Proceedings of the IEEE, 1966 (random walk of frequency standards).
    """

    effect: ClassVar[str] = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, time_s = setting.random, setting.path.time_s
        self._time_s = np.linspace(time_s.min(), time_s.max() + 1e-6, 240)
        walks = np.cumsum(random.standard_normal((240, 2)), axis=0) / np.sqrt(240)
        self._walk = walks * random.uniform(0.04, 0.1) * scale(setting)
        self._pattern = np.stack([pattern(setting), 0.5 * pattern(setting)])

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """Two patterns, each as far off as its walk has come."""
        walk = np.column_stack([np.interp(path.time_s, self._time_s, one) for one in self._walk.T])
        return values + strength * walk @ self._pattern
