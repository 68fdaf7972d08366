"""Runs and guards that other processes of the same user on this computer can ask: how it stands, pause, end, vent.

Whoever can be asked listens on a free port of this computer alone, in a thread, and leaves a note in the user's
folder that only this user may read: the port, and a key that every request must carry. A connection carries one
request and its answer, a JSON line each; while the answer is being made, an empty line comes twice a second, which
tells somebody slow from somebody who no longer runs. The same on every system, which signals are not.
"""

import contextlib
import hmac
import json
import os
import secrets
import socket
import socketserver
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, TypedDict

from labrig._durable import put_at
from labrig._errors import LabrigError
from labrig._locks import SOMEBODYS, taken
from labrig._user_folder import cache_folder
from labrig.run_contents import Asking, Facts

LOOPBACK = "127.0.0.1"
SILENT_S = 3.0
"""A process that says nothing for so long, while it is asked, does not run."""

_BEAT_S = 0.5
_SLOW_S = 5.0
_LONGEST = 65536

Answer = Callable[[Asking], Any]


class _Said(TypedDict, total=False):
    """An answer: its value, or why there is none."""

    value: Any
    error: str


class GoneError(LabrigError):
    """Nobody answers: the process has ended, or is stopped."""


class SilentError(GoneError):
    """The process is there and says nothing: it is stopped, or hangs altogether."""


class BusyError(LabrigError):
    """The process is at it, and took longer than it was given: asked later it may answer."""


@dataclass(frozen=True)
class Note:
    """How to reach a process: `what` it is (run, guard), and what it said of itself."""

    what: str
    pid: int
    port: int
    key: str = field(repr=False)
    facts: Facts
    path: Path
    locked: bool = False

    @property
    def is_stale(self) -> bool:
        """Whether its process has ended, whoever has its number or its port now; False where that cannot be known.

        Not for that process itself: to open and close the file of a lock that it holds would let it go (POSIX lockf).
        """
        if not self.locked or self.pid == os.getpid():
            return False
        try:
            with taken(_lock_of(self.path)):
                return True
        except OSError as error:
            return error.errno not in SOMEBODYS

    def remove(self) -> None:
        """Remove the note of a process that has ended, and its lock."""
        for each in (self.path, _lock_of(self.path)):
            with contextlib.suppress(OSError):
                each.unlink(missing_ok=True)

    def ask(self, do: str, timeout_s: float = 5.0, **request: Any) -> Any:
        """What it answers; raises `GoneError` where nobody does, `BusyError` where it takes longer than `timeout_s`,
        and `LabrigError` with its own words where it refuses.

        The note of a process that has ended is removed.
        """
        try:
            link = socket.create_connection((LOOPBACK, self.port), SILENT_S)
        except ConnectionRefusedError:
            self.remove()
            raise GoneError(f"the {self.what} has ended") from None
        except OSError as error:
            raise GoneError(f"the {self.what} cannot be reached: {error}") from None
        with link:
            return self._talk(link, {**request, "do": do, "key": self.key}, time.monotonic() + timeout_s)

    def _talk(self, link: socket.socket, request: dict[str, Any], end: float) -> Any:
        try:
            link.sendall(json.dumps(request).encode() + b"\n")
            file = link.makefile("rb")
            while time.monotonic() < end:
                line = file.readline()
                if not line:
                    raise GoneError(f"the {self.what} has ended")
                if line != b"\n":
                    answer = json.loads(line)
                    break
            else:
                raise BusyError(f"the {self.what} is at it, but not done yet")
        except TimeoutError:
            raise SilentError(f"the {self.what} says nothing for {SILENT_S:g} s") from None
        except (OSError, ValueError) as error:
            raise GoneError(f"the {self.what} broke off: {error}") from None
        if "error" in answer:
            raise LabrigError(str(answer["error"]))
        return answer["value"]


def notes(what: str) -> list[Note]:
    """Those that can be asked, the latest first; some of them may have ended without taking their note along."""
    found: list[tuple[float, Note]] = []
    folder = _folder()
    for path in folder.glob(f"{what}-*.json") if folder.is_dir() else ():
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            facts, locked = content["facts"], content.get("locked", False)
            note = Note(what, content["pid"], content["port"], content["key"], facts, path, locked)
            found.append((path.stat().st_mtime, note))
        except (OSError, ValueError, KeyError):  # it was just removed, or is nobody's
            continue
    return [note for _, note in sorted(found, key=lambda item: item[0], reverse=True)]


class Reception:
    """Lets others ask this process, until closed; `answer` is called on a thread of its own for each request.

    A `LabrigError` that it raises becomes the answer; any other error, too, with its name.
    """

    def __init__(self, what: str, facts: Facts, answer: Answer) -> None:
        self._key = secrets.token_hex(16)
        handler = type("Handler", (_Handler,), {"key": self._key, "answer": staticmethod(answer)})
        self._server = _Server((LOOPBACK, 0), handler)
        self.port = int(self._server.server_address[1])
        self._thread = threading.Thread(
            target=self._server.serve_forever, args=(0.2,), name=f"labrig {what} reception", daemon=True
        )
        self._thread.start()
        self.path = _folder() / f"{what}-{os.getpid()}-{secrets.token_hex(4)}.json"
        self._lock: IO[bytes] | None = None
        with contextlib.suppress(OSError):  # a disk that knows no locks is no reason not to be reached
            self._lock = taken(_lock_of(self.path))
        content = {"pid": os.getpid(), "port": self.port, "key": self._key, "facts": facts}
        try:
            _write_private(self.path, json.dumps(content | {"locked": self._lock is not None}))
        except OSError:
            self.close()
            raise

    def close(self) -> None:
        """Remove the note and stop listening; never raises."""
        for each in (self.path, _lock_of(self.path)):  # the lock while it is held
            with contextlib.suppress(OSError):
                each.unlink(missing_ok=True)
        if self._lock is not None:
            self._lock.close()
            with contextlib.suppress(OSError):  # Windows keeps a file that is open
                _lock_of(self.path).unlink(missing_ok=True)
        self._server.shutdown()
        self._server.server_close()
        self._thread.join(_SLOW_S)


class _Server(socketserver.ThreadingTCPServer):
    daemon_threads = True
    block_on_close = False

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Whoever hangs up in the middle is not worth a traceback."""


class _Handler(socketserver.BaseRequestHandler):
    key = ""
    answer: Answer

    def handle(self) -> None:
        """Read one request; answer it if it has the key."""
        self.request.settimeout(_SLOW_S)
        with self.request.makefile("rb") as file:
            line = file.readline(_LONGEST)
        try:
            request = json.loads(line)
            known = hmac.compare_digest(str(request.pop("key")), self.key)
        except (ValueError, KeyError, AttributeError, TypeError):
            return
        if not known:
            return
        said: list[_Said] = []
        work = threading.Thread(target=self._work, args=(request, said), name="labrig answer", daemon=True)
        work.start()
        while True:
            work.join(_BEAT_S)
            if not work.is_alive():
                break
            self.request.sendall(b"\n")
        self.request.sendall(json.dumps(said[0]).encode() + b"\n")

    def _work(self, request: Asking, said: list[_Said]) -> None:
        try:
            said.append({"value": self.answer(request)})
        except LabrigError as error:
            said.append({"error": str(error)})
        except Exception as error:
            said.append({"error": f"{type(error).__name__}: {error}"})


def _lock_of(note: Path) -> Path:
    return note.with_suffix(".lock")


def _folder() -> Path:
    return cache_folder() / "running"


def _write_private(path: Path, text: str) -> None:
    """Write a file that only this user may read; on Windows the user's own folder sees to that."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(".part")
    number = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(number, "w", encoding="utf-8") as file:
        file.write(text)
    put_at(temporary, path)
