"""The process that computes for the pages, so that the server answers (and vents) whatever is computed.

One process, which holds what is open; what is asked waits its turn. Results are plain values.
"""

import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import Any

from labrig._errors import LabrigError
from labrig._executor import spawned
from labrig.workbench._held import Key, names, ready, warm

_PATIENCE_S = 3.0
"""How long who asks next waits for what was asked before."""
_CLOSING = "the workbench is closing"


@dataclass(eq=False)
class _Asked:
    """What was asked for last of `ask_newest`, and whether another took its place."""

    future: Future[Any]
    replaced: bool = False


class Worker:
    """A process for `ask`; started when it is first needed, and again when it died."""

    def __init__(self) -> None:
        self._pool: ProcessPoolExecutor | None = None
        self._lock = threading.Lock()
        self._warmed: set[Key] = set()
        self._closed = False
        self._turn = threading.Lock()
        self._newest: _Asked | None = None

    def ask(self, work: Callable[..., Any], *given: Any) -> Any:
        """Run `work` there and wait for what it gives; its errors are raised here."""
        try:
            return self._submit(work, *given).result()
        except (BrokenProcessPool, CancelledError):
            raise self._lost() from None

    def ask_newest(self, timeout_s: float, work: Callable[..., Any], *given: Any) -> Any:
        """As `ask`, for what may take too long: who asks next waits a moment for it, and then takes its place.

        After `timeout_s`, or where another took its place, the process is ended, and `LabrigError` says which.
        """
        with self._turn:
            before = self._newest
            if before is not None and not wait([before.future], _PATIENCE_S).done:
                before.replaced = True
                self._end()
            asked = self._newest = _Asked(self._submit(work, *given))
        try:
            return asked.future.result(timeout_s)
        except TimeoutError:
            with self._turn:
                if self._newest is asked:
                    self._end()
            raise LabrigError(f"not done after {timeout_s:g} s, and given up") from None
        except (BrokenProcessPool, CancelledError):
            if asked.replaced:
                raise LabrigError(
                    "it took long, and another one was asked for meanwhile; ask again"
                ) from None
            raise self._lost() from None

    def begin(self) -> None:
        """Start the process before somebody needs it; once."""
        if self._pool is None and not self._closed:
            self._submit(ready)

    def warm(self, key: Key) -> None:
        """While nobody asks, find the forms of every effect of what was opened, one after the other."""
        if key in self._warmed:
            return
        self._warmed.add(key)
        self._submit(names, key).add_done_callback(lambda done: self._next(key, _given(done)))

    def close(self) -> None:
        """End the process."""
        self._closed = True
        self._end()

    def _end(self) -> None:
        with self._lock:
            pool, self._pool = self._pool, None
        if pool is not None:
            for process in list((pool._processes or {}).values()):
                process.terminate()
            pool.shutdown(wait=True, cancel_futures=True)

    def _lost(self) -> LabrigError:
        if self._closed:
            return LabrigError(_CLOSING)
        return LabrigError("the computation ended unexpectedly (out of memory?); try again")

    def _submit(self, work: Callable[..., Any], *given: Any) -> Future[Any]:
        with self._lock:
            if self._closed:
                raise LabrigError(_CLOSING)
            if self._pool is None:
                self._pool = spawned(1)
            try:
                return self._pool.submit(work, *given)
            except BrokenProcessPool:
                self._warmed.clear()
                self._pool = spawned(1)
                return self._pool.submit(work, *given)

    def _next(self, key: Key, left: list[str]) -> None:
        if not left or self._closed:
            return
        try:
            future = self._submit(warm, key, left[0])
        except LabrigError:
            return
        future.add_done_callback(lambda _: self._next(key, left[1:]))


def _given(done: Future[Any]) -> list[str]:
    return [] if done.cancelled() or done.exception() is not None else done.result()
