"""Who watches a run: observers live on a thread of their own and can neither delay nor break it."""

import contextlib
import queue
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from labrig.campaign._procedure import RigInfo
from labrig.campaign._steps import Completed, Step
from labrig_drivers import MarkerFrame, PressureSample

_QUEUE_LENGTH = 2000
_LAST_WORDS_S = 2.0


@dataclass(frozen=True)
class Progress:
    """How far a run is: steps and captures done, of how many (None: not known), and the time that remains."""

    steps_done: int
    steps: int | None
    captures_done: int
    captures: int | None
    elapsed_s: float
    remaining_s: float | None
    step: str
    paused: bool = False

    def __str__(self) -> str:
        """One line, for `progress=print`: "12 of 40 captures, 37 of 120 steps done (settle), 125 s left"."""
        captures, steps = ("" if n is None else f" of {n}" for n in (self.captures, self.steps))
        left = "" if self.remaining_s is None else f", {self.remaining_s:.0f} s left"
        doing = "paused" if self.paused else self.step
        return f"{self.captures_done}{captures} captures, {self.steps_done}{steps} steps done ({doing}){left}"


class Observer:
    """Base of everything that watches a run; override what you need.

    The methods are called in order on a thread of the observer's own. Nothing that happens in them reaches the
    run: an observer that is slow misses frames and samples, one that raises is not called again.
    """

    def started(self, rig: RigInfo, rest_mm: Any) -> None:
        """The run begins; `rest_mm` is (M, 3) or None."""

    def step_started(self, index: int, step: Step) -> None:
        """A step begins."""

    def step_done(self, completed: Completed) -> None:
        """A step is done and durable in the log."""

    def commanded(self, time_s: float, pressure_kpa: Sequence[float]) -> None:
        """The chambers were commanded."""

    def sample(self, sample: PressureSample) -> None:
        """Pressures were measured."""

    def frame(self, frame: MarkerFrame) -> None:
        """A motion capture frame arrived."""

    def event(self, time_s: float, text: str, level: str) -> None:
        """A line for people; `level` is INFO, WARNING, ERROR or FATAL."""

    def progress(self, progress: Progress) -> None:
        """How far the run is; after every step and about twice a second."""

    def vented(self, pressure_kpa: Sequence[float]) -> None:
        """The vent at the end is confirmed; what the chambers read, (C,)."""

    def finished(self, reason: str) -> None:
        """The run has ended: `completed`, or why not, and that the chambers are not vented where they are not."""


class Observation:
    """Hands what happens in a run to its observers, each on its own thread, through a queue that may overflow."""

    def __init__(self, observers: Sequence[Observer]) -> None:
        self._channels = [_Channel(observer) for observer in observers]

    def tell(self, method: str, *arguments: Any) -> None:
        """Call `method` of every observer, some time soon; never waits, never raises."""
        for channel in self._channels:
            if channel.listens(method):
                channel.put((method, arguments))

    def close(self) -> None:
        """Let the observers finish what is queued, for two seconds at most altogether."""
        for channel in self._channels:
            channel.put(None)
        for channel in self._channels:
            channel.join(_LAST_WORDS_S / len(self._channels))


class _Channel:
    def __init__(self, observer: Observer) -> None:
        self._observer = observer
        self._queue: queue.Queue[Any] = queue.Queue(_QUEUE_LENGTH)
        self._thread = threading.Thread(
            target=self._work, name=f"observer {type(observer).__name__}", daemon=True
        )
        self._broken = False
        self._thread.start()

    def listens(self, method: str) -> bool:
        """Whether the observer does anything with it: what nobody looks at wakes no thread."""
        return getattr(getattr(self._observer, method), "__func__", None) is not getattr(Observer, method)

    def put(self, item: Any) -> None:
        if item is not None and self._broken:
            return
        droppable = item is not None and item[0] in ("frame", "sample", "commanded", "progress")
        if droppable and self._queue.qsize() > _QUEUE_LENGTH // 2:
            return  # leave room for what happens rarely
        try:
            self._queue.put_nowait(item)
        except queue.Full:
            if item is None:  # the end must arrive
                with contextlib.suppress(queue.Empty):
                    self._queue.get_nowait()
                with contextlib.suppress(queue.Full):
                    self._queue.put_nowait(None)

    def join(self, timeout_s: float) -> None:
        self._thread.join(timeout_s)

    def _work(self) -> None:
        while (item := self._queue.get()) is not None:
            method, arguments = item
            if self._broken:
                continue
            try:
                getattr(self._observer, method)(*arguments)
            except Exception:
                self._broken = True
