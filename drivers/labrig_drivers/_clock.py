"""Clocks: what waits for time to pass is handed one, so that a simulated campaign costs no waiting."""

import time
from typing import Protocol


class Clock(Protocol):
    """Seconds since the Unix epoch that never run backward, and a way to wait."""

    def wall_s(self) -> float:
        """What a clock on the wall says: the time of day, s since the Unix epoch; somebody may set it."""
        ...

    def now_s(self) -> float:
        """The time now, s since the Unix epoch."""
        ...

    def sleep(self, duration_s: float) -> None:
        """Return once `duration_s` seconds of this clock have passed."""
        ...

    def advance_to(self, time_s: float) -> None:
        """Go on from `time_s`, unless it is later already: a run that is resumed never goes back in time."""
        ...


class RealClock:
    """The computer's monotonic clock, counted from what its wall clock said when this one was made.

    Setting the computer's clock during a run moves nothing here. Two clocks, also of two processes, agree when they
    have the same `offset_s`: the monotonic clock is the computer's, not a process's. It is `time.perf_counter`: before
    Python 3.13 `time.monotonic` moves in steps of 16 ms on Windows.
    """

    def __init__(self, offset_s: float | None = None) -> None:
        self.offset_s = time.time() - time.perf_counter() if offset_s is None else float(offset_s)

    def now_s(self) -> float:
        """The time now, s since the Unix epoch."""
        return self.offset_s + time.perf_counter()

    def wall_s(self) -> float:
        """What the computer's wall clock says now."""
        return time.time()

    def sleep(self, duration_s: float) -> None:
        """Wait for `duration_s` seconds."""
        if duration_s > 0:
            time.sleep(duration_s)

    def advance_to(self, time_s: float) -> None:
        """Go on from `time_s`, unless it is later already."""
        self.offset_s += max(0.0, time_s - self.now_s())


class SimulatedClock:
    """A clock that only moves when somebody sleeps: deterministic, and free of waiting."""

    def __init__(self, start_s: float = 1_767_225_600.0) -> None:
        self._now_s = float(start_s)

    def now_s(self) -> float:
        """The time now, s since the Unix epoch."""
        return self._now_s

    def wall_s(self) -> float:
        """The same: nobody sets a simulated clock."""
        return self._now_s

    def sleep(self, duration_s: float) -> None:
        """Move the clock forward by `duration_s` seconds, at once."""
        self._now_s += max(0.0, float(duration_s))

    def advance_to(self, time_s: float) -> None:
        """Go on from `time_s`, unless it is later already."""
        self._now_s = max(self._now_s, float(time_s))
