"""Turns signals into an exception that a run can vent on, but never in the middle of a vent or a write."""

import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import Self

from labrig._outliving import outlives_terminal

_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")  # SIGHUP is POSIX only, SIGBREAK Windows only
_WORDS = {"SIGINT": "Ctrl-C", "SIGBREAK": "Ctrl-Break"}


class Interrupted(KeyboardInterrupt):
    """Somebody asked the run to stop; the message says how."""


class SignalGuard:
    """While it is entered, signals that end a program raise `Interrupted` in the main thread.

    Inside `with guard.shield():` they wait until the shield is left. In another thread than the main one nothing
    is installed, and nothing for SIGHUP where it is ignored: `nohup` says so that a run outlives its terminal.
    `on_pause` is called on SIGUSR1 (POSIX only).
    """

    def __init__(self, on_pause: Callable[[], None] | None = None) -> None:
        self._on_pause = on_pause
        self._old: dict[int, object] = {}
        self._depth = 0
        self._pending: str | None = None
        self._raised: str | None = None
        self._closed = False

    def __enter__(self) -> Self:
        if threading.current_thread() is not threading.main_thread():
            return self
        for name in _NAMES:
            number = getattr(signal, name, None)
            if number is not None and not outlives_terminal(name):
                self._old[number] = signal.signal(number, self._handle)
        if self._on_pause is not None and hasattr(signal, "SIGUSR1"):
            self._old[signal.SIGUSR1] = signal.signal(signal.SIGUSR1, self._pause)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._old.items():
            signal.signal(number, handler)  # type: ignore[arg-type]
        self._old.clear()

    def _handle(self, number: int, _frame: FrameType | None) -> None:
        name = signal.Signals(number).name
        word = _WORDS.get(name, name)
        if self._depth or self._closed or self._raised:
            self._pending = self._pending or word
        else:
            self._raise(word)

    def _raise(self, word: str) -> None:
        """Raise, once: a second one could hit the code that answers the first."""
        self._raised = word
        raise Interrupted(word)

    def check(self, asked: str | None = None) -> None:
        """Raise if the run was `asked` to end, and again if a procedure swallowed that and the run still goes on."""
        if asked is not None and not (self._raised or self._closed or self._depth):
            self._raise(asked)
        if self._raised and not self._closed and not self._depth:
            raise Interrupted(self._raised)

    def _pause(self, _number: int, _frame: FrameType | None) -> None:
        if self._on_pause is not None:
            self._on_pause()

    @property
    def unheard(self) -> str | None:
        """Who asked for the end after all that there was to end had been done: whoever goes on must hear of it."""
        return None if self._raised else self._pending

    def shield(self) -> "_Shield":
        """A context in which signals wait."""
        return _Shield(self)

    def close(self) -> None:
        """From here on signals are remembered and raise nothing: the run is ending, and vents."""
        self._closed = True

    def _enter_shield(self) -> None:
        self._depth += 1

    def _leave_shield(self, failing: bool) -> None:
        self._depth -= 1
        if self._depth == 0 and self._pending and not (self._closed or self._raised or failing):
            self._raise(self._pending)


class _Shield:
    def __init__(self, guard: SignalGuard) -> None:
        self._guard = guard

    def __enter__(self) -> None:
        self._guard._enter_shield()

    def __exit__(self, kind: object, *_: object) -> None:
        self._guard._leave_shield(failing=kind is not None)
