"""Leaks of the fourth portion: wet pores that open at a pressure, labyrinths, punctures that close themselves."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some
from labrig.bench.development.leak import bled

_AIR_KPA = 101.3


def _left(kpa: Floats, age_s: Floats, rate: Callable[[Floats], Floats]) -> Floats:
    """What is left (T,) of a pressure or of a vacuum after `age_s` (T,), with a rate in kPa/s that its size sets."""
    return np.sign(kpa) * bled(np.abs(kpa), age_s, rate)


class WetPores(Law):
    """Bubble points: water closes each pore of the skin up to a pressure of its own, above which air goes through.

    E. W. Washburn, The dynamics of capillary flow, Physical Review 17, 1921.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._opens = random.uniform(0.12, 0.4) * np.exp(random.normal(0, 0.6, 9))  # of the upper limit
        self._per_s = some(random, len(self.rig.chambers), 1 / 250, 1 / 60, 0.7)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        out = kpa.copy()
        for c in np.flatnonzero(strength * self._per_s):
            high, per_s = float(self.rig.high_kpa[c]), strength * self._per_s[c]

            def rate(p: Floats, high: float = high, per_s: float = per_s) -> Floats:
                above = np.maximum(p[:, None] - high * self._opens, 0.0)
                return per_s * (above.mean(axis=1) + 1e-7 * high)

            out[:, c] = _left(kpa[:, c], path.hold_s, rate)
        return out


class Labyrinth(Law):
    """Labyrinth: air that leaks past the teeth of a rod's seal loses its pressure from one to the next.

    H. M. Martin, Labyrinth packings, Engineering 85, 1908.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._teeth = float(random.integers(2, 13))
        self._per_s = some(random, len(self.rig.chambers), 1 / 500, 1 / 120, 0.7)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        out = kpa.copy()
        for c in np.flatnonzero(strength * self._per_s):
            high = np.array([float(self.rig.high_kpa[c])])
            most = strength * self._per_s[c] * float(high[0] / self._flow(high)[0])

            def rate(p: Floats, most: float = most) -> Floats:
                return most * self._flow(p)

            out[:, c] = _left(kpa[:, c], path.hold_s, rate)
        return out

    def _flow(self, p: Floats) -> Floats:
        """How much leaks at gauge pressures (N,), in arbitrary units."""
        inside = p + _AIR_KPA
        ratio = _AIR_KPA / inside
        return inside * np.sqrt((1 - ratio**2) / (self._teeth - np.log(ratio)))


class SelfSealing(Law):
    """Puncture that closes itself: each filling blows it open, and in the hold the soft wall swells back over it.

    R. F. Shepherd, A. A. Stokes, R. M. D. Nunes, G. M. Whitesides, Soft machines that are resistant to puncture and
    that self seal, Advanced Materials 25, 2013.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._closes_s = np.exp(random.uniform(np.log(6), np.log(40)))
        self._per_s = some(random, count, 1 / 150, 1 / 40, 0.6)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        open_s = self._closes_s * -np.expm1(-path.hold_s[:, None] / self._closes_s)
        return kpa * np.exp(-strength * self._per_s * open_s)
