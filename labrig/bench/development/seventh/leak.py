"""Leaks of the seventh portion: a gap that pressure opens, by the cubic law, and fittings that ease open in a hold."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some


class GapUnderASeal(Law):
    """Cubic law: pressure lifts a soft seal evenly, and what flows under it goes with the third power of the gap.

    P. A. Witherspoon, J. S. Y. Wang, K. Iwai, J. E. Gale, Validity of cubic law for fluid flow in a deformable rock
    fracture, Water Resources Research 16, 1980.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._lifts = random.uniform(0.3, 3.0, count)  # the gap at full pressure, over that without any
        self._loses = some(random, count, 0.0025, 0.01, 0.75)  # in a second, at full pressure

    def _clock(self, load: Floats) -> Floats:
        """The time (in natural units) that it takes to fall from full pressure to a load, with its sign turned."""
        gap = 1 + self._lifts * load
        return np.log(load / gap) + 1 / gap + 0.5 / gap**2

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = np.maximum(np.abs(full(self.rig, kpa)), 1e-9)
        rate = strength * self._loses / (1 + self._lifts) ** 3
        until = self._clock(load) - rate * path.hold_s[:, None]
        low, high = np.full_like(load, -60.0), np.zeros_like(load)  # logarithms of what is left
        for _ in range(40):
            middle = 0.5 * (low + high)
            far = self._clock(load * np.exp(middle)) > until
            low, high = np.where(far, low, middle), np.where(far, middle, high)
        return kpa * np.where(rate > 0, np.exp(0.5 * (low + high)), 1.0)


class EasesOpen(Law):
    """Fitting that eases open: the seal relaxes in each hold, and the leak gets faster by a power of time (Weibull).

    W. Weibull, A statistical distribution function of wide applicability, J. Applied Mechanics 18, 1951. The next
    actuation presses it home again.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._power = random.uniform(1.2, 1.7)
        self._loses = some(random, count, 0.05, 0.15, 0.75)  # in the first minute

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa * np.exp(-strength * self._loses * (path.hold_s[:, None] / 60.0) ** self._power)
