"""Leaks of the third portion: a crack, a hidden pocket, a hole that stretches, a seat that closes on dirt."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some
from labrig.bench.development.leak import bled


def _left(kpa: Floats, age_s: Floats, rate: Callable[[Floats], Floats]) -> Floats:
    """What is left (T,) of a pressure or of a vacuum after `age_s` (T,), with a rate in kPa/s that its size sets."""
    return np.sign(kpa) * bled(np.abs(kpa), age_s, rate)


class Crack(Law):
    """Forchheimer's crack: viscous loss in proportion to the flow and a turbulent one to its square share the pressure.

    P. Forchheimer, Wasserbewegung durch Boden, Zeitschrift des Vereins Deutscher Ingenieure 45, 1901.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._turbulent = setting.random.uniform(1.0, 12.0)  # at full pressure, against the viscous loss
        self._per_s = some(setting.random, len(self.rig.chambers), 1 / 400, 1 / 80, 0.7)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        out = kpa.copy()
        for c in np.flatnonzero(strength * self._per_s):
            high, full_rate = float(self.rig.high_kpa[c]), strength * self._per_s[c]
            most = np.sqrt(1 + 4 * self._turbulent) - 1

            def rate(p: Floats, high: float = high, most: float = full_rate * high / most) -> Floats:
                return most * (np.sqrt(1 + 4 * self._turbulent * p / high) - 1)

            out[:, c] = _left(kpa[:, c], path.hold_s, rate)
        return out


class HiddenPocket(Law):
    """Virtual leak: air seeps into a closed pocket in the wall until it is as full, and out of it again while vented.

    D. J. Hucknall, Vacuum Technology and Applications, Butterworth-Heinemann, 1991.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._takes = some(random, count, 0.1, 0.4, 0.7)  # volume of the pocket, against the chamber's
        self._tau_s = np.exp(random.uniform(np.log(8), np.log(60))) * random.uniform(0.7, 1.4, count)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        takes = strength * self._takes
        out, inside = kpa.copy(), np.zeros(kpa.shape[1])
        begins = np.flatnonzero(np.diff(path.event, prepend=-1))
        ends = np.append(begins[1:], len(kpa))
        for first, end in zip(begins, ends, strict=True):
            long_s = path.hold_s[first:end, None]
            last_s = path.time_s[min(end, len(kpa) - 1)] - path.time_s[first]
            held = kpa[end - 1]
            gone = -np.expm1(-(1 + takes) * long_s / self._tau_s)
            out[first:end] -= takes / (1 + takes) * gone * (kpa[first:end] - inside)
            whole = -np.expm1(-(1 + takes) * last_s / self._tau_s)
            inside = inside + whole * (held - inside) / (1 + takes)
        return out


class StretchedPinhole(Law):
    """Pinhole in rubber: inflation widens it, and the flow through a narrow tube goes with its radius' fourth power.

    J. L. M. Poiseuille, Recherches expérimentales sur le mouvement des liquides, Comptes Rendus 11, 1840.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._widens = random.uniform(0.3, 1.0)
        self._per_s = np.zeros(count)
        which = random.permutation(count)[: int(random.integers(1, min(count, 3) + 1))]
        self._per_s[which] = random.uniform(1 / 400, 1 / 80, len(which))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        out = kpa.copy()
        for c in np.flatnonzero(strength * self._per_s):
            high, slow = float(self.rig.high_kpa[c]), strength * self._per_s[c]

            def rate(p: Floats, high: float = high, slow: float = slow) -> Floats:
                return slow * p * (1 + self._widens * p / high) ** 4

            out[:, c] = _left(kpa[:, c], path.hold_s, rate)
        return out


class DirtySeat(Law):
    """Dirty seat: each time the valve closes on another grain, and for that hold lets through more, or less.

    P. Smith, R. W. Zappe, Valve Selection Handbook, 5th ed., Gulf Professional Publishing, 2004.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._per_s = some(random, count, 1 / 300, 1 / 80, 0.8)
        self._dirt = np.exp(random.normal(0, random.uniform(0.3, 0.7), (997, count)))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        open_ = self._per_s * self._dirt[path.event % len(self._dirt)]
        return kpa * np.exp(-strength * open_ * path.hold_s[:, None])
