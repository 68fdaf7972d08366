"""Leak: a held chamber loses air, the faster the higher its pressure; the next actuation fills it up again."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some

_AIR_KPA = 101.3


def bled(kpa: Floats, age_s: Floats, rate_kpa_per_s: Callable[[Floats], Floats]) -> Floats:
    """The pressure (T,) that is left of `kpa` (T,) after `age_s` (T,), if it falls by a rate that it alone sets."""
    level = np.geomspace(1e-3, max(float(kpa.max()), 1.0) * 1.01, 600)
    slow = 1 / rate_kpa_per_s(level)
    takes_s = np.concatenate([[0.0], np.cumsum(0.5 * (slow[1:] + slow[:-1]) * np.diff(level))])
    left_s = np.interp(kpa, level, takes_s) - age_s
    return np.where(kpa > level[0], np.interp(left_s, takes_s, level, left=0.0), kpa)


class ExponentialLeak(Law):
    """Laminar leak: through a narrow gap air escapes in proportion to the pressure, so that it falls exponentially.

    A. Roth, Vacuum Technology, 3rd ed., North-Holland, 1990.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._per_s = some(setting.random, len(self.rig.chambers), 1 / 500, 1 / 100, 0.7)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa * np.exp(-strength * self._per_s * path.hold_s[:, None])


class OrificeLeak(Law):
    """Orifice: air escapes through a hole, choked at high pressure, by a quarter ellipse below (ISO 6358).

    ISO 6358-1, Pneumatic fluid power: determination of flow-rate characteristics, 2013.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._critical = setting.random.uniform(0.2, 0.5)
        self._per_s = some(setting.random, len(self.rig.chambers), 1 / 600, 1 / 120, 0.6)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        out = kpa.copy()
        for c in np.flatnonzero(strength * self._per_s):
            high = float(self.rig.high_kpa[c])
            scale = strength * self._per_s[c] * high / self._flow(np.array([high]))[0]
            out[:, c] = bled(kpa[:, c], path.hold_s, lambda p, scale=scale: scale * self._flow(p))
        return out

    def _flow(self, kpa: Floats) -> Floats:
        inside = kpa + _AIR_KPA
        past = np.maximum(_AIR_KPA / inside - self._critical, 0.0) / (1 - self._critical)
        return inside * np.sqrt(1 - past**2)


class PorousWall(Law):
    """Porous wall: gas seeps through the skin by Darcy's law, with the difference of the squared pressures.

    M. Muskat, The Flow of Homogeneous Fluids through Porous Media, McGraw-Hill, 1937.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._per_s = some(setting.random, len(self.rig.chambers), 1 / 500, 1 / 120)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        twice = 2 * _AIR_KPA
        start = np.maximum(kpa, 0.0)
        lost = -np.expm1(-strength * self._per_s * twice / (self.rig.high_kpa + twice) * path.hold_s[:, None])
        return kpa - start * lost * (twice + start) / (twice + start * lost)  # of dp/dt = -k p (p + 2 air)


class LiftingSeal(Law):
    """Lifting seal: one chamber's lip seal opens above a pressure of its own, and leaks until it closes again.

    H. K. Müller, B. S. Nau, Fluid Sealing Technology, Marcel Dekker, 1998.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        high = self.rig.high_kpa
        self._chamber = int(setting.random.integers(len(high)))
        self._opens_kpa = setting.random.uniform(0.05, 0.3) * high[self._chamber]
        self._per_s = setting.random.uniform(1 / 80, 1 / 12)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        out = kpa.copy()
        above = np.maximum(kpa[:, self._chamber] - self._opens_kpa, 0.0)
        out[:, self._chamber] += above * np.expm1(-strength * self._per_s * path.hold_s)
        return out
