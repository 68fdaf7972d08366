"""Signals that end a command that goes on until it is told to stop."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from labrig._outliving import outlives_terminal

_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
"""Ctrl-C, kill, a terminal that is closed (POSIX; not heard under `nohup`), Ctrl-Break (Windows)."""


@contextmanager
def ending_on_signals() -> Iterator[threading.Event]:
    """An event that is set by whatever asks the command to end, so that it lets go of what it holds."""
    ended = threading.Event()
    heard = [name for name in _NAMES if hasattr(signal, name) and not outlives_terminal(name)]
    numbers = [getattr(signal, name) for name in heard]
    before = {number: signal.getsignal(number) for number in numbers}
    try:
        for number in numbers:
            signal.signal(number, lambda *_: ended.set())
        yield ended
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
