"""Signals that end a command that goes on until it is told to stop."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
"""Ctrl-C, kill, a terminal that is closed (POSIX), Ctrl-Break (Windows)."""


@contextmanager
def ending_on_signals() -> Iterator[threading.Event]:
    """An event that is set by whatever asks the command to end, so that it lets go of what it holds."""
    ended = threading.Event()
    numbers = [getattr(signal, name) for name in _NAMES if hasattr(signal, name)]
    before = {number: signal.getsignal(number) for number in numbers}
    try:
        for number in numbers:
            signal.signal(number, lambda *_: ended.set())
        yield ended
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
