"""Lets other processes on this computer see how a run stands, and pause, continue or end it."""

import contextlib
import threading
from collections import deque
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from labrig._errors import LabrigError
from labrig._running import Reception
from labrig.campaign._kept import Kept, listed
from labrig.campaign._observe import Observer, Progress
from labrig.campaign._procedure import Procedure, RigInfo
from labrig.campaign._session import Control
from labrig.campaign._steps import Answered, Completed, Step
from labrig.rig import RigConfig, link_of
from labrig.run_contents import Asking, Facts, RunState, RunStatus, VentContent
from labrig_drivers import Clock, MarkerFrame, PressureSample, RealClock

KEPT_S = 120.0
"""How far back the pressures are kept for whoever begins to watch, s."""

_EVERY_S = 0.2
_KEPT_EVENTS = 200
_END_S = 90.0


class Reachable(Observer):
    """The state of a run for those who ask, from memory alone: the log is not read, and nothing is computed unasked.

    A context manager. On a simulated clock nobody has the time to ask: nothing listens then. A request names what to
    `do`: `status` (with `since_s` and `event`, what is known already), `captures` (with `capture` and `actuation`, how
    many are known), `pause`, `go_on`, `end`, or `vent`, which ends the run and answers with the pressures once they are
    confirmed.
    """

    def __init__(
        self, procedure: Procedure, config: RigConfig, folder: Path, clock: Clock, control: Control
    ) -> None:
        self._control, self._folder = control, folder
        self._real = isinstance(clock, RealClock)
        self._lock = threading.Lock()
        self._facts: Facts = {
            "folder": str(folder.resolve()),
            "procedure": procedure.procedure_name(),
            "rig": config.name,
            "rig_folder": str(config.folder.resolve()),
            "link": link_of(config),
        }
        self._state: RunState = {
            "chambers": [c.name for c in config.chambers],
            "limits_kpa": [[c.min_kpa, c.max_kpa] for c in config.chambers],
        }
        self._kept = Kept(len(config.chambers))
        self._history: deque[tuple[float, list[Any], list[Any]]] = deque(maxlen=round(KEPT_S / _EVERY_S))
        self._events: deque[tuple[int, float, str, str]] = deque(maxlen=_KEPT_EVENTS)
        self._event = 0
        self._frame: MarkerFrame | None = None
        self._sample: PressureSample | None = None
        self._commanded: list[Any] = [0.0] * len(config.chambers)
        self._vented: list[Any] | None = None
        self._finished = threading.Event()
        self._reception: Reception | None = None

    def __enter__(self) -> Self:
        if self._real:
            with contextlib.suppress(OSError):  # nobody can watch then; the run needs nobody
                self._reception = Reception("run", self._facts, self._answer)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._finished.set()
        if self._reception is not None:
            self._reception.close()

    def started(self, rig: RigInfo, rest_mm: Any) -> None:
        """Keep what the rig is."""
        with self._lock:
            self._state["chambers"] = list(rig.chamber_names)
            self._state["markers"] = list(rig.marker_names)
            self._state["rest_mm"] = None if rest_mm is None else _plain(rest_mm)

    def step_started(self, index: int, step: Step) -> None:
        """Keep the step."""
        with self._lock:
            self._state["step"] = {"index": index, **step.to_dict()}

    def step_done(self, completed: Completed) -> None:
        """Keep how many are done, what a capture measured, and what a live diagnosis said."""
        with self._lock:
            self._state["steps_done"] = completed.index + 1
            self._kept.done(completed)
            if isinstance(completed.result, Answered) and (look := completed.result.content.get("look")):
                self._state["looks"] = [*self._state.get("looks", ()), look]

    def commanded(self, time_s: float, pressure_kpa: Sequence[float]) -> None:
        """Keep the set-points."""
        self._commanded = _plain(pressure_kpa)

    def sample(self, sample: PressureSample) -> None:
        """Keep the pressures: the last, and five a second for the curves."""
        self._sample = sample
        if not self._history or sample.time_s - self._history[-1][0] >= _EVERY_S:
            with self._lock:
                self._history.append((sample.time_s, _plain(sample.pressure_kpa), self._commanded))

    def frame(self, frame: MarkerFrame) -> None:
        """Keep the last frame."""
        self._frame = frame

    def event(self, time_s: float, text: str, level: str) -> None:
        """Keep the line."""
        with self._lock:
            self._event += 1
            self._events.append((self._event, time_s, level, text))
            if text.startswith("paused"):
                self._kept.vented(time_s)

    def progress(self, progress: Progress) -> None:
        """Keep how far the run is."""
        with self._lock:
            self._state["progress"] = asdict(progress)

    def vented(self, pressure_kpa: Sequence[float]) -> None:
        """Keep what the chambers read at the end."""
        self._vented = _plain(pressure_kpa)

    def finished(self, reason: str) -> None:
        """Keep why it ended; who asked for the vent hears of it now."""
        with self._lock:
            self._state["ended"] = reason
        self._finished.set()

    def _answer(self, request: Asking) -> Any:
        do, why = request.get("do"), str(request.get("why") or "another process on this computer")
        if do == "status":
            return self._status(float(request.get("since_s") or 0.0), int(request.get("event") or 0))
        if do == "captures":
            with self._lock:
                return self._kept.since(int(request.get("capture") or 0), int(request.get("actuation") or 0))
        if do == "pause":
            self._control.pause()
        elif do == "go_on":
            self._control.go_on()
        elif do == "end":
            self._control.end(why)
        elif do == "vent":
            self._control.end(why)
            return self._vent()
        else:
            raise LabrigError(
                f"a run is not asked to {do!r}; there are status, captures, pause, go_on, end, vent"
            )
        return {"paused": self._control.paused}

    def _vent(self) -> VentContent:
        if not self._finished.wait(_END_S):
            raise LabrigError(f"the run does not end within {_END_S:g} s: is it in a procedure's own code?")
        if self._vented is None:
            raise LabrigError("the run has ended without a confirmed vent")
        return {"pressure_kpa": [np.nan if value is None else value for value in self._vented]}

    def _status(self, since_s: float, event: int) -> RunStatus:
        frame, sample = self._frame, self._sample
        with self._lock:
            new = [entry for entry in self._history if entry[0] > since_s]
            events = [entry for entry in self._events if entry[0] > event]
            state = self._state.copy()
        return {
            **self._facts,
            **state,
            "paused": self._control.paused,
            "commanded_kpa": self._commanded,
            "measured_kpa": None if sample is None else _plain(sample.pressure_kpa),
            "time_s": None if sample is None else sample.time_s,
            "position_mm": None if frame is None else _plain(frame.position_mm),
            "history": {
                "time_s": [round(entry[0], 3) for entry in new],
                "measured_kpa": [entry[1] for entry in new],
                "commanded_kpa": [entry[2] for entry in new],
            },
            "events": [list(entry) for entry in events],
            "vented_kpa": self._vented,
        }


def _plain(values: Any) -> list[Any]:
    return listed(values, 2)
