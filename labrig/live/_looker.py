"""The process that diagnoses a campaign while it goes on: of the lowest priority, and never waited for."""

import contextlib
import json
import os
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Sequence

from labrig.run_contents import LiveAnswer, LiveQuestion

LONGEST_S = 300.0
"""A look that takes longer hangs."""
_ATTEMPTS = 3
ENDS_S = 20.0
_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class Looker:
    """A process that answers one question at a time, a line of JSON each way; `words` is its command.

    Nothing here waits but `wait` and `close`. A process that dies or hangs is started again, three times at most;
    after that nothing is asked any more.
    """

    def __init__(self, words: Sequence[str], longest_s: float = LONGEST_S) -> None:
        self._words, self._longest_s = list(words), longest_s
        self._answers: queue.Queue[tuple[int, LiveAnswer | None]] = queue.Queue()
        self._left = _ATTEMPTS
        self._number = 0
        self._process: subprocess.Popen[str] | None = None
        self._since: float | None = None
        self._start()

    @property
    def idle(self) -> bool:
        """Whether it can be asked."""
        return self._process is not None and self._since is None

    def _start(self) -> None:
        self._number += 1
        flags = 0
        if sys.platform == "win32":
            flags = subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.IDLE_PRIORITY_CLASS
        try:
            self._process = subprocess.Popen(
                self._words,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
                encoding="utf-8",
                env={**os.environ, **dict.fromkeys(_ONE_THREAD, "1")},
                creationflags=flags,  # elsewhere it lowers its priority itself
                start_new_session=sys.platform != "win32",  # Ctrl-C is for the run
            )
        except OSError:
            self._process = None
            return
        reading = (self._process, self._number)
        threading.Thread(target=self._read, args=reading, name="labrig looker", daemon=True).start()

    def _read(self, process: "subprocess.Popen[str]", number: int) -> None:
        with contextlib.suppress(ValueError, OSError):  # closed, or no JSON
            for line in process.stdout or ():
                self._answers.put((number, json.loads(line)))
        self._answers.put((number, None))

    def ask(self, question: LiveQuestion) -> None:
        """Ask for a look; the answer comes with `found` or `wait`."""
        if self._process is None or self._process.stdin is None:
            return
        self._since = time.monotonic()
        with contextlib.suppress(OSError, ValueError):  # it has died: its reader says so
            self._process.stdin.write(json.dumps(question) + "\n")
            self._process.stdin.flush()

    def found(self) -> LiveAnswer | None:
        """The answer, if there is one: a `look`, or the `trouble` that there was. It does not wait."""
        return self._next(0.0)

    def wait(self) -> LiveAnswer | None:
        """The answer, waited for; None where nothing was asked."""
        return self._next(None) if self._since is not None else None

    def _next(self, wait_s: float | None) -> LiveAnswer | None:
        while True:
            asked_s = 0.0 if self._since is None else time.monotonic() - self._since
            left_s = max(self._longest_s - asked_s, 0.0)
            try:
                number, answer = self._answers.get(timeout=left_s if wait_s is None else wait_s)
            except queue.Empty:
                hangs = self._since is not None and asked_s >= self._longest_s
                if hangs or wait_s is None:
                    return self._again(f"a diagnosis took longer than {self._longest_s:g} s")
                return None
            if number != self._number:  # of a process before this one
                continue
            if answer is None:
                return self._again("the process of the diagnosis has ended (out of memory?)")
            self._since = None
            return answer

    def _again(self, what: str) -> LiveAnswer:
        """Start anew, unless that was done too often."""
        self._kill()
        self._since, self._left = None, self._left - 1
        if self._left > 0:
            self._start()
            return {"trouble": f"{what}; it is tried again"}
        self._process = None
        return {"trouble": f"{what}, {_ATTEMPTS} times; the campaign goes on without"}

    def close(self, why: str | None, wait_s: float = ENDS_S) -> None:
        """Let it draw its last picture, which says `why` the campaign ended, and end it after `wait_s` at most."""
        process, self._process = self._process, None
        if process is None:
            return
        with contextlib.suppress(OSError, ValueError):
            if process.stdin is not None:
                process.stdin.write(json.dumps({"end": why}) + "\n")
                process.stdin.close()
        self._number += 1
        try:
            process.wait(wait_s)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if process.stdout is not None:
            process.stdout.close()

    def _kill(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            for pipe in (self._process.stdin, self._process.stdout):
                with contextlib.suppress(OSError, ValueError):
                    if pipe is not None:
                        pipe.close()
