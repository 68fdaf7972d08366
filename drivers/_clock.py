"""Clocks: what waits for time to pass is handed one, so that a simulated campaign costs no waiting."""

import time
from typing import Protocol


class Clock(Protocol):
    """Seconds since the Unix epoch, and a way to wait."""

    def now_s(self) -> float:
        """The time now, s since the Unix epoch."""
        ...

    def sleep(self, duration_s: float) -> None:
        """Return once `duration_s` seconds of this clock have passed."""
        ...


class RealClock:
    """The computer's own clock."""

    def now_s(self) -> float:
        """The time now, s since the Unix epoch."""
        return time.time()

    def sleep(self, duration_s: float) -> None:
        """Wait for `duration_s` seconds."""
        if duration_s > 0:
            time.sleep(duration_s)


class SimulatedClock:
    """A clock that only moves when somebody sleeps: deterministic, and free of waiting."""

    def __init__(self, start_s: float = 1_767_225_600.0) -> None:
        self._now_s = float(start_s)

    def now_s(self) -> float:
        """The time now, s since the Unix epoch."""
        return self._now_s

    def sleep(self, duration_s: float) -> None:
        """Move the clock forward by `duration_s` seconds, at once."""
        self._now_s += max(0.0, float(duration_s))
