"""What the server tells its pages, on one stream of server-sent events: jobs as they go on, and what parts publish."""

import asyncio
import threading
import time
from collections.abc import AsyncIterator
from typing import TYPE_CHECKING, Any

from labrig.workbench._answers import told

if TYPE_CHECKING:
    from labrig.workbench._desk import Desk

LOOK_S = 0.25
_MOST = 500
_QUIET_LOOKS = 8
"""A page that hears nothing for much longer says so: a server that hangs keeps its connections."""


class Events:
    """News for every open page; `publish` may be called from any thread, and never waits for a page."""

    def __init__(self) -> None:
        self._readers: dict[int, list[str]] = {}
        self._lock = threading.Lock()
        self.closed = threading.Event()

    def publish(self, name: str, data: Any) -> None:
        """Tell every page; one that does not read for long loses the oldest news."""
        text = encoded(name, data)
        with self._lock:
            for waiting in self._readers.values():
                waiting.append(text)
                del waiting[:-_MOST]

    def enter(self) -> int:
        """A new reader's number."""
        with self._lock:
            number = max(self._readers, default=0) + 1
            self._readers[number] = []
            return number

    def leave(self, number: int) -> None:
        """A reader has gone."""
        with self._lock:
            self._readers.pop(number, None)

    def take(self, number: int) -> list[str]:
        """What a reader has not seen yet."""
        with self._lock:
            waiting, self._readers[number] = self._readers[number], []
            return waiting

    def close(self) -> None:
        """End all streams."""
        self.closed.set()


def encoded(name: str, data: Any) -> str:
    """One event as it goes over the line; moments as they are, with all of their ten digits."""
    return f"event: {name}\ndata: {told(data)}\n\n"


async def stream(desk: "Desk") -> AsyncIterator[str]:
    """The events of one page, until it goes or the server ends.

    Jobs are read from their files, so that a page sees those of another server on the same folder as well.
    """
    events, said, quiet = desk.events, "", 0
    number = events.enter()
    try:
        yield encoded("clock", time.time())
        while not events.closed.is_set():
            jobs = await asyncio.to_thread(lambda: encoded("jobs", [job.facts() for job in desk.jobs.all()]))
            news = events.take(number)
            if jobs != said:
                news, said = [*news, jobs], jobs
            quiet = 0 if news else quiet + 1
            if quiet == _QUIET_LOOKS:
                news, quiet = [encoded("clock", time.time())], 0
            if news:
                yield "".join(news)
            await asyncio.sleep(LOOK_S)
    finally:
        events.leave(number)
