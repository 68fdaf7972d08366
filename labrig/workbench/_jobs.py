"""Long work: labrig commands in processes of their own, whose state lies in files.

A job is a folder `.workbench/jobs/ID`: `job.json` (what was asked for), `output.txt`, `pid`, `alive` (locked while it
runs), `cancelled` (somebody asked), `ended.json` (how it ended). So a page that is closed, a second page and a server
that was started again all see the same.
"""

import json
import os
import secrets
import shlex
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any, TypedDict

from pydantic import BaseModel

from labrig._errors import LabrigError, NothingToDoError
from labrig._outliving import outlives
from labrig.workbench._child import ALIVE, CANCELLED, ENDED, INTERRUPTED, PID, write_ended
from labrig.workbench._locked import is_held

ABOUT, OUTPUT = "job.json", "output.txt"
KEPT = 60
_NAMES = {"--out", "-o", "--seed"}
"""Options that do not change how long a command takes."""
_STARTS_S = 120.0
"""A process that has not begun by then never will; one that this server started is known to have ended before."""
_TAIL_BYTES = 20_000


class Ended(BaseModel):
    """How a job ended: the code of its process, and when."""

    code: int
    ended_s: float


class _About(BaseModel):
    """What a job's file says of it."""

    words: tuple[str, ...]
    title: str
    run: str
    started_s: float


class JobFacts(TypedDict):
    """What pages are told of a job."""

    id: str
    title: str
    run: str
    words: list[str]
    command: str
    state: str
    started_s: float
    ended_s: float | None
    last: str
    lines: list[str]


@dataclass(frozen=True)
class Job:
    """A command that runs or ran; `run` is the run that it is about (its name below the folder), or empty."""

    folder: Path
    words: tuple[str, ...]
    title: str
    run: str
    started_s: float

    @property
    def id(self) -> str:
        """Its name, in the order of time."""
        return self.folder.name

    @property
    def command(self) -> str:
        """The command, to be typed in the workbench's folder."""
        return command_line(self.words)

    @property
    def ended(self) -> Ended | None:
        """How it ended, or None."""
        try:
            return Ended.model_validate_json((self.folder / ENDED).read_bytes())
        except (OSError, ValueError):
            return None

    @property
    def state(self) -> str:
        """running, done, failed or cancelled."""
        ended = self.ended
        if ended is None and self._lives():
            return "running"
        ended = ended or self.ended  # it may have ended between the two looks
        if ended is not None and ended.code == 0:
            return "done"
        if self.had_nothing_to_do:
            return "done"
        asked = (self.folder / CANCELLED).exists() or (ended is not None and ended.code == INTERRUPTED)
        return "cancelled" if asked else "failed"

    @property
    def had_nothing_to_do(self) -> bool:
        """Whether it ended with the good news that nothing was needed."""
        ended = self.ended
        return ended is not None and ended.code == NothingToDoError.exit_code

    def _lives(self) -> bool:
        alive = self.folder / ALIVE
        begun = alive.exists() and alive.stat().st_size > 0
        return is_held(alive) if begun else time.time() - self.started_s < _STARTS_S

    def output(self) -> str:
        """What it printed, the end of it."""
        try:
            with (self.folder / OUTPUT).open("rb") as file:
                size = file.seek(0, os.SEEK_END)
                file.seek(max(0, size - _TAIL_BYTES))
                return file.read().decode("utf-8", "replace").replace("\r\n", "\n")
        except OSError:
            return ""

    def facts(self) -> JobFacts:
        """What pages are told of it."""
        ended, lines = self.ended, self.output().rstrip().splitlines()
        return {
            "id": self.id,
            "title": self.title,
            "run": self.run,
            "words": list(self.words),
            "command": self.command,
            "state": self.state,
            "started_s": self.started_s,
            "ended_s": ended and ended.ended_s,
            "last": lines[-1] if lines else "",
            "lines": lines[-12:],
        }


class Jobs:
    """The jobs of a folder; several servers may look after the same."""

    def __init__(self, cwd: Path, folder: Path) -> None:
        self.cwd = cwd
        self.folder = folder
        self._lock = threading.Lock()
        self._children: dict[Path, subprocess.Popen[Any]] = {}

    def start(self, words: Sequence[object], title: str, run: str = "") -> Job:
        """Start `labrig WORDS...` in the workbench's folder.

        Raises `LabrigError` where the same command runs already, or nothing can be written.
        """
        asked = tuple(str(word) for word in words)
        with self._lock:
            if any(job.words == asked and job.state == "running" for job in self.all()):
                raise LabrigError(f"{command_line(asked)}: runs already; wait for it, or cancel it")
            job = self._written(Job(self._new_folder(), asked, title, run, time.time()))
            with (job.folder / OUTPUT).open("wb") as output:
                child = subprocess.Popen(
                    [sys.executable, "-m", "labrig.workbench._child", str(job.folder), *asked],
                    cwd=self.cwd,
                    env={
                        **os.environ,
                        "PYTHONUNBUFFERED": "1",
                        "COLUMNS": "110",
                        "PYTHONIOENCODING": "utf-8",
                    },
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                    **_own_group(),
                )
            (job.folder / PID).write_text(str(child.pid), encoding="ascii")
            self._children[job.folder] = child
            outlives(child)
        return job

    def join(self, words: Sequence[object], title: str, run: str = "") -> Job:
        """The same command where it runs already, else a new job of it."""
        asked = tuple(str(word) for word in words)
        with suppress(LabrigError):
            return self.start(asked, title, run)
        going = next((job for job in self.all() if job.words == asked and job.state == "running"), None)
        return going or self.start(asked, title, run)

    def all(self) -> list[Job]:
        """The jobs, the newest first."""
        self._look_after()
        try:
            folders = sorted((p for p in self.folder.iterdir() if (p / ABOUT).is_file()), reverse=True)
        except OSError:
            return []
        return [job for folder in folders if (job := _job(folder)) is not None]

    def get(self, job: str) -> Job:
        """A job by its id; raises `LabrigError` where there is none."""
        for known in self.all():
            if known.id == job:
                return known
        raise LabrigError(f"there is no job {job!r}")

    def cancel(self, job: Job, harder: bool = False) -> None:
        """Ask a job to end as Ctrl-C would (a run on a rig vents first), or, where that did not help, make it end."""
        if job.state != "running":
            return
        (job.folder / CANCELLED).touch()
        pid = _pid(job)
        if pid is None:
            raise LabrigError("the job has only just begun; try again")
        _signal(pid, harder)

    def usual_s(self, words: Sequence[str]) -> float | None:
        """How long the same command took here, the median; None where none like it has ended well yet.

        Another run, another model or other options may take ten times as long, so that they say nothing.
        """
        same = _but_for_names(words)
        took = [
            ended.ended_s - job.started_s
            for job in self.all()
            if _but_for_names(job.words) == same and (ended := job.ended) and ended.code == 0
        ]
        return median(took) if took else None

    def wait(self, timeout_s: float) -> bool:
        """Whether the children of this server have ended within a time."""
        end = time.monotonic() + timeout_s
        while any(child.poll() is None for child in list(self._children.values())):
            if time.monotonic() > end:
                return False
            time.sleep(0.05)
        return True

    def _look_after(self) -> None:
        """Write down how a child ended that could not do so itself."""
        for folder, child in list(self._children.items()):
            if child.poll() is None:
                continue
            self._children.pop(folder, None)
            if folder.is_dir() and not (folder / ENDED).exists():
                write_ended(folder, child.returncode)

    def _new_folder(self) -> Path:
        folder = (
            self.folder
            / f"{time.strftime('%Y%m%d-%H%M%S')}-{time.time_ns() % 10**9:09d}-{secrets.token_hex(2)}"
        )
        try:
            folder.mkdir(parents=True)
        except OSError as error:
            raise LabrigError(f"{folder}: cannot be made: {error.strerror or error}") from None
        self._tidy()
        return folder

    def _written(self, job: Job) -> Job:
        about = {"words": job.words, "title": job.title, "run": job.run, "started_s": job.started_s}
        (job.folder / ABOUT).write_text(json.dumps(about), encoding="utf-8")
        return job

    def _tidy(self) -> None:
        """Remove the oldest that have ended."""
        for folder in sorted(self.folder.iterdir())[:-KEPT]:
            if not is_held(folder / ALIVE):
                shutil.rmtree(folder, ignore_errors=True)


def command_line(words: Sequence[object]) -> str:
    """A labrig command as it is typed."""
    parts = ["labrig", *map(str, words)]
    return subprocess.list2cmdline(parts) if sys.platform == "win32" else shlex.join(parts)


def _but_for_names(words: Sequence[str]) -> tuple[str, ...]:
    """A command without what its results are called, and without its seed."""
    given = (None, *words)
    return tuple(
        word for before, word in zip(given, words, strict=False) if {before, word}.isdisjoint(_NAMES)
    )


def _job(folder: Path) -> Job | None:
    """The job of a folder; None where its file is half written, or of another form."""
    try:
        about = _About.model_validate_json((folder / ABOUT).read_bytes())
    except (OSError, ValueError):
        return None
    return Job(folder, about.words, about.title, about.run, about.started_s)


def _pid(job: Job) -> int | None:
    try:
        return int((job.folder / PID).read_text(encoding="ascii"))
    except (OSError, ValueError):
        return None


def _own_group() -> dict[str, Any]:
    """A group of its own: Ctrl-C in the server's terminal is not for it, and it can be asked to end as a whole."""
    if sys.platform == "win32":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    return {"start_new_session": True}


def _signal(pid: int, harder: bool) -> None:
    try:
        if sys.platform == "win32":
            if harder:
                subprocess.run(["taskkill", "/T", "/F", "/PID", str(pid)], capture_output=True, check=False)
            else:
                os.kill(pid, signal.CTRL_BREAK_EVENT)
        else:
            os.killpg(pid, signal.SIGKILL if harder else signal.SIGINT)
    except ProcessLookupError:
        return
