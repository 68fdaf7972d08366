"""How long nothing was heard of a device: by when it arrived, on the run's own clock, and by what it is dated."""

from collections.abc import Sequence

import numpy as np

from labrig.arrays import Floats

_AGAIN_S = 10.0
_LATE_S = 20.0
"""A delay, not another clock."""

_OTHER_CLOCK_S = 1e6
"""So far behind is no delay: it is the time of day, or since the computer's start."""


class Silence:
    """Since when a device is silent. What is dated long ago is as good as nothing, however fresh it came in."""

    def __init__(self, now_s: float) -> None:
        self._dated_s = self._came_s = now_s

    def hear(self, dated_s: float, now_s: float) -> None:
        """Something arrived; a date ahead of the clock counts as now."""
        self._dated_s, self._came_s = min(dated_s, now_s), now_s

    def forget(self, now_s: float) -> None:
        """Begin anew, after something that did not listen."""
        self._dated_s = self._came_s = now_s

    def lasts_s(self, now_s: float) -> float:
        """How long it has lasted, s."""
        return now_s - self._dated_s

    def behind(self, now_s: float) -> bool:
        """Whether things do arrive, and only their dates are old."""
        return now_s - self._came_s < 0.5 * (now_s - self._dated_s)


class Gaps:
    """Chambers that had a reading and give none (NaN) now. One that never had any has no sensor."""

    def __init__(self, names: Sequence[str], now_s: float) -> None:
        self._names = names
        self._measured = np.zeros(len(names), bool)
        self._last_s = np.full(len(names), now_s)
        self._told_s = -np.inf

    def take(self, pressure_kpa: Floats, now_s: float) -> str:
        """Look at one reading; returns the chambers that a person should hear of: a gap has begun."""
        finite = np.isfinite(pressure_kpa)
        self._measured |= finite
        self._last_s[finite] = now_s
        missing = self._named(self._measured & ~finite)
        if not missing or now_s - self._told_s < _AGAIN_S:
            return ""
        self._told_s = now_s
        return missing

    def longer_than(self, limit_s: float, now_s: float) -> tuple[str, float]:
        """The chambers without a reading for longer than that, and the longest time, s."""
        silent_s = np.where(self._measured, now_s - self._last_s, 0.0)
        return self._named(silent_s > limit_s), float(silent_s.max(initial=0.0))

    def forget(self, now_s: float) -> None:
        """Begin anew, after something that did not listen."""
        self._last_s[:] = now_s

    def _named(self, which: np.ndarray) -> str:
        return ", ".join(name for name, yes in zip(self._names, which, strict=True) if yes)


def dated(behind_s: float) -> str:
    """What is wrong where things come in and are dated long ago."""
    why = ""
    if behind_s < _LATE_S:
        why = "; it comes late, as where this computer is too busy to read it"
    elif behind_s > _OTHER_CLOCK_S:
        why = "; its driver takes times from another clock than it was given"
    return f"what it measures is dated {behind_s:.4g} s before labrig's clock{why}"
