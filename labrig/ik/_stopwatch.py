"""Time of a search, apart from the time in which numba compiles what it uses for the first time on a computer."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from numba.core.event import TimingListener, install_listener


@contextmanager
def stopwatch() -> Iterator[Callable[[], tuple[float, float]]]:
    """Gives what tells, when called, the seconds so far: of work, and of compiling."""
    began, compiling = time.perf_counter(), TimingListener()

    def so_far() -> tuple[float, float]:
        compiled_s = compiling.duration if compiling.done else 0.0
        return time.perf_counter() - began - compiled_s, compiled_s

    with install_listener("numba:compile", compiling):
        yield so_far
