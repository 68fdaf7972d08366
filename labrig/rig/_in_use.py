"""Who uses a rig now: one process at a time, and a run's folder has one, too.

The system itself holds the lock of a file in the user's own folder for as long as the process lives that took it: one
that was killed leaves none behind. A second file says who it is. A vent asks nobody: it must always be possible.
"""

import contextlib
import hashlib
import json
import os
import threading
import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

from labrig._errors import LabrigError
from labrig._locks import SOMEBODYS, taken
from labrig._running import notes
from labrig._user_folder import cache_folder
from labrig.rig._asked import link_of
from labrig.rig._config import RigConfig
from labrig.rig._vent_now import is_there

_ENDS_S, _LOOKS_S = 5.0, 0.1
"""How long a guard may take to end that is on its way out, and how often one looks."""
_TAKING = threading.Lock()
_HELD: dict[Path, str] = {}
"""The locks of this process: the system would give them to it a second time."""


@contextlib.contextmanager
def in_use(config: RigConfig, what: str, folder: Path | None = None) -> Iterator[None]:
    """Have the rig, and the `folder` of a run, to oneself; `what` says to others who has it.

    Raises `LabrigError`, before anything of either is touched, where another process has one of them, or the guard of
    an earlier run still vents the rig. A rig is known by the address of its pressure controller, so two rig files that
    reach the same one are one rig. One that is simulated in this process is nobody else's.
    """
    with contextlib.ExitStack() as stack:
        if folder is not None:
            stack.enter_context(_lock(f"folder {folder.resolve()}", what, "is still going on"))
        if link := link_of(config):
            stack.enter_context(_lock(f"link {link}", what, "is using this rig"))
            _let_guards_end(link)
        yield


def _let_guards_end(link: str) -> None:
    """Wait for the guard of a run before this one, which vents until a reading confirms it: two on one link would work
    against each other. Raises `LabrigError` where it stays.
    """
    end = time.monotonic() + _ENDS_S
    while left := [note for note in notes("guard") if note.facts.get("link") == link and is_there(note)]:
        if time.monotonic() > end:
            of = f"the guard of {left[0].facts.get('run') or 'a run'} (process {left[0].pid})"
            raise LabrigError(
                f"{of} still has this rig: no reading confirms its vent, or a program keeps the rig connected; look at "
                "the chambers and their sensors, then wait, close that connection, or end that process by force"
            )
        time.sleep(_LOOKS_S)


@contextlib.contextmanager
def _lock(name: str, what: str, does: str) -> Iterator[None]:
    path = cache_folder() / "running" / f"use-{hashlib.sha256(name.encode()).hexdigest()[:20]}.lock"
    said = path.with_suffix(".who")
    since = f"{datetime.now():%Y-%m-%d %H:%M:%S}"
    with _TAKING:
        if path in _HELD:
            raise LabrigError(f"{_HELD[path]} {does}; wait, or stop it")
        try:
            file = taken(path)
        except OSError as error:
            if error.errno in SOMEBODYS:
                raise LabrigError(f"{_who(said)} {does}; wait, or stop it") from None
            file = None  # a disk that is full, or knows no locks, is no reason not to measure
        _HELD[path] = f"{what} (process {os.getpid()}, since {since})"
    with file or contextlib.nullcontext():
        try:
            with contextlib.suppress(OSError):
                _write(said, {"what": what, "pid": os.getpid(), "since": since})
            yield
        finally:
            del _HELD[path]
            for each in (said, path):  # while it is still locked; Windows keeps a file that is open
                with contextlib.suppress(OSError):
                    each.unlink(missing_ok=True)


def _write(path: Path, content: dict[str, Any]) -> None:
    part = path.with_suffix(".part")
    part.write_text(json.dumps(content), encoding="utf-8")
    part.replace(path)


def _who(said: Path) -> str:
    try:
        content = json.loads(said.read_text(encoding="utf-8"))
        return f"{content['what']} (process {content['pid']}, since {content['since']})"
    except (OSError, ValueError, KeyError, TypeError):  # it has only just begun
        return "another process"
