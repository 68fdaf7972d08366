"""Delay of the seventh portion: a valve that saturates, and a filter and a hole side by side.

The stronger the law, the longer it takes.
"""

from abc import abstractmethod

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some


class _Late(Law):
    """What both share: each actuation begins where the last one ended, and has a size on which its pace depends."""

    effect = "delay"
    _on: Floats

    @abstractmethod
    def _left(self, size: Floats, hold_s: Floats, strength: float) -> Floats:
        """The share of steps of a size (C,) that is left after times (T, 1)."""

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        out, before = kpa.copy(), np.zeros(kpa.shape[1])
        first = np.flatnonzero(np.diff(path.event, prepend=-1)).tolist()
        for begin, end in zip(first, [*first[1:], len(path.event)], strict=True):
            size = np.abs(kpa[end - 1] - before) / self.rig.high_kpa
            left = self._left(size, path.hold_s[begin:end, None], strength)
            late = kpa[begin:end] + (before - kpa[begin:end]) * left
            out[begin:end] = np.where(self._on > 0, late, kpa[begin:end])
            before = out[end - 1]
        return out


class SaturatedValve(_Late):
    """Saturated valve: far from its set-point it is wide open and goes evenly, and only near it in proportion.

    G. F. Franklin, J. D. Powell, A. Emami-Naeini, Feedback Control of Dynamic Systems, Addison-Wesley, 1986.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._on = some(random, count, 0.85, 1.15, random.uniform(0.6, 1.0))
        self._tau_s = random.uniform(0.3, 0.7) * np.maximum(self._on, 0.1)
        self._band = random.uniform(0.1, 0.4, count)  # where it begins to close

    def _left(self, size: Floats, hold_s: Floats, strength: float) -> Floats:
        late = hold_s / (strength * self._tau_s)
        whole = np.maximum(size, 1e-9)
        even = np.maximum(whole / self._band - 1, 0.0)  # so long it goes evenly
        slow = np.exp(-np.minimum(np.maximum(late - even, 0.0), 60.0)) * np.minimum(self._band / whole, 1.0)
        return np.where(late < even, 1 - late * self._band / whole, slow)


class FilterAndHole(_Late):
    """Filter and hole side by side: one passes air with the difference, one with its root, which ends after a while.

    I. E. Idelchik, Handbook of Hydraulic Resistance, Israel Program for Scientific Translations, 1966. The root of
    what is left falls exponentially towards a value below zero.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._on = some(random, count, 0.85, 1.15, random.uniform(0.6, 1.0))
        self._tau_s = random.uniform(1.5, 3.0) * np.maximum(self._on, 0.1)
        self._hole = random.uniform(0.15, 1.2, count)

    def _left(self, size: Floats, hold_s: Floats, strength: float) -> Floats:
        root = np.sqrt(np.maximum(size, 1e-9))
        falls = np.exp(-np.minimum(0.5 * hold_s / (strength * self._tau_s), 60.0))
        return (np.maximum((root + self._hole) * falls - self._hole, 0.0) / root) ** 2
