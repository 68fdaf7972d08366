"""The runs that go on now, and how far the open model is from them while they do."""

import json
import subprocess
import sys
import threading
import time
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig._running import GoneError, Note, notes
from labrig.api._run import DIAGNOSED
from labrig.log import RunSummary, read_run_yaml, summarise
from labrig.rig import runs_on
from labrig.run_contents import LiveError
from labrig.view import ERROR_SCALE, STEPS, skin
from labrig.workbench._desk import Desk
from labrig.workbench._ended import events_said, said

UNWATCHED_S = 20.0
"""A page that is closed asks no more: after this the errors are no longer computed."""
FLOOR_MM = 0.2
"""Noise floor that the colours of the error count in: while a run goes on nobody knows its own."""
_SENT = 400
_ENDS_S = 3.0
_MEASURING = (("run",), ("validate",))
"""How commands begin that make a run."""


def live_runs(desk: Desk) -> list[Note]:
    """The runs that go on with the desk's rig or in its folder, the latest first; others on this computer are not."""
    rig = desk.known_rig()
    on_rig = [] if rig is None else runs_on(rig)
    ports = {note.port for note in on_rig}
    inside = [note for note in notes("run") if _inside(desk, note)]
    return [*on_rig, *(note for note in inside if note.port not in ports)]


def _inside(desk: Desk, note: Note) -> bool:
    return Path(str(note.facts.get("folder"))).is_relative_to(desk.folder)


def name_of(desk: Desk, note: Note) -> str:
    """What a run is called: its name below the folder, else its whole path."""
    folder = Path(str(note.facts["folder"]))
    return desk.name(folder) if _inside(desk, note) else str(folder)


def live_run(desk: Desk, name: str) -> Note | None:
    """The run of this name, if it goes on."""
    return next((note for note in live_runs(desk) if name_of(desk, note) == name), None)


def alive(desk: Desk) -> list[str]:
    """The names of the runs that go on and answer."""
    names = []
    for note in live_runs(desk):
        with suppress(LabrigError):
            note.ask("status", 2.0, since_s=1e12, event=10**9)
            names.append(name_of(desk, note))
    return names


def now(desk: Desk, name: str, since_s: float, event: int) -> dict[str, Any]:
    """How a run stands: what it says of itself while it goes on, how it ended after that."""
    note = live_run(desk, name)
    if note is not None:
        with suppress(GoneError):
            return {"live": True, "run": name, **note.ask("status", since_s=since_s, event=event)}
    try:
        summary = summarise(desk.existing(name))
    except LabrigError as error:
        return _not_begun(desk, name, error)
    return {
        "live": False,
        "run": name,
        "state": said(summary.state),
        "procedure": str(summary.run.get("procedure") or ""),
        "vented": _is_vented(summary),
        "captures": summary.captures,
        "duration_s": summary.duration_s,
        "missed": summary.missed,
        "events": [
            [index, time_s, "", text] for index, (time_s, text) in enumerate(events_said(summary, 30))
        ],
    }


def diagnosed_with(folder: Path) -> str:
    """The model with which a run is diagnosed while it goes on, as run.yaml names it; empty where it is not."""
    try:
        return _diagnosed(str(folder), (folder / "run.yaml").stat().st_mtime_ns)
    except OSError:
        return ""


@lru_cache(maxsize=16)
def _diagnosed(folder: str, _changed_ns: int) -> str:
    asked = read_run_yaml(Path(folder)).get(DIAGNOSED)
    return str(asked.get("model", "")) if isinstance(asked, dict) else ""


def _not_begun(desk: Desk, name: str, error: LabrigError) -> dict[str, Any]:
    """Why a run that was started here left no log, in the words of its command; for others raises the `error`."""
    job = next((job for job in desk.jobs.all() if job.run == name and job.words[:1] in _MEASURING), None)
    if job is None or job.state == "done":
        raise error
    if job.state == "running":
        raise LabrigError(f"{name}: begins, or has just ended")
    why = job.facts()["last"].removeprefix("labrig: ") or f"it was {job.state}"
    return {"live": False, "run": name, "state": "not begun", "why": why}


def _is_vented(summary: RunSummary) -> bool:
    """Whether the log says so: a run that was killed wrote no end, one that could not vent wrote that."""
    ended = not summary.state.startswith("not closed")
    return ended and not any("vent not confirmed" in text for _, text in summary.events[-5:])


def surface(rest_mm: list[Any]) -> dict[str, Any]:
    """The skin over markers at rest (M, 3): `weight` (V, M) takes values of markers to its vertices, `triangles`.

    And the colours of errors, the same as in reports: `scale`, from one to `steps` floors of `floor_mm`.
    """
    found = skin(np.array(rest_mm, float))
    if found is None:
        raise LabrigError("the markers span no surface")
    return {
        "weight": np.round(found.weight, 4),
        "triangles": found.triangles,
        "scale": [[position, colour] for position, colour in ERROR_SCALE],
        "steps": STEPS[-1],
        "floor_mm": FLOOR_MM,
    }


class Errors:
    """The processes that hold a model against a run while it goes on; at most one for each pair, while watched."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._of: dict[tuple[str, str], _Process] = {}

    def of(self, folder: Path, model: Path) -> LiveError:
        """What is known so far of a run that goes on; begins to find out where nobody asked before, or where the
        process that did could not reach the run for a moment.
        """
        key = (str(folder), f"{model}@{model.stat().st_mtime_ns}")  # a model that was saved anew is another
        with self._lock:
            for other, process in list(self._of.items()):
                if process.unwatched:
                    process.close()
                    del self._of[other]
            before = self._of.get(key)
            if before is None:
                self._of[key] = _Process(folder, model, LiveError())
            elif before.lost_it:
                before.close()
                self._of[key] = _Process(folder, model, before.latest())
            return self._of[key].latest()

    def close(self) -> None:
        """End all of them."""
        with self._lock:
            for process in self._of.values():
                process.close()
            self._of.clear()


class _Process:
    def __init__(self, folder: Path, model: Path, latest: LiveError) -> None:
        self._asked = time.monotonic()
        self._latest = latest
        self._process = subprocess.Popen(
            [sys.executable, "-m", "labrig.workbench._live_error", str(folder), str(model)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            creationflags=subprocess.CREATE_NEW_PROCESS_GROUP if sys.platform == "win32" else 0,
            start_new_session=sys.platform != "win32",
        )
        self._thread = threading.Thread(target=self._read, name="labrig live error", daemon=True)
        self._thread.start()
        threading.Thread(target=self._end_unwatched, name="labrig live error end", daemon=True).start()

    def _read(self) -> None:
        if self._process.stdout is None:
            return
        with suppress(ValueError, OSError):  # closed meanwhile
            for line in self._process.stdout:
                content: LiveError = json.loads(line)
                content["captures"] = content.get("captures", [])[-_SENT:]
                self._latest = content

    def _end_unwatched(self) -> None:
        while self._process.poll() is None:
            if self.unwatched:
                self.close()
            time.sleep(1.0)

    @property
    def unwatched(self) -> bool:
        return time.monotonic() - self._asked > UNWATCHED_S

    @property
    def lost_it(self) -> bool:
        """Whether it has ended as it does where nobody answers."""
        return self._process.poll() == 0

    def latest(self) -> LiveError:
        self._asked = time.monotonic()
        return self._latest

    def close(self) -> None:
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()
        try:
            self._process.wait(_ENDS_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
