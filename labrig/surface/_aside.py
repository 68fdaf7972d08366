"""Open3D in a process of its own: what it prints, hangs in or dies of stays there, and its threads too."""

import atexit
import contextlib
import os
import pickle
import queue
import subprocess
import sys
import threading
from typing import Any

from labrig._errors import LabrigError
from labrig._extras import lacking

_CALL_S = 300.0
_CLOSE_S = 5.0


class Aside:
    """A worker that is started when it is first needed, and again if it is gone; it ends with this process.

    It is a process and not an import, because a process that holds a rig's pressures must not stop for a second while
    Open3D is imported, must not die of it, and needs none of its threads.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._answers: queue.Queue[Any] = queue.Queue()
        self._lock = threading.Lock()

    def call(self, task: str, *given: Any) -> Any:
        """What the function `task` of `_aside_process.TASKS` returns.

        Raises `LabrigError` for what the function refuses, where Open3D is not installed, does not answer, or dies.
        """
        with self._lock:
            process = self._process
            if process is None or process.poll() is not None:
                process = self._start()
            try:
                assert process.stdin is not None
                pickle.dump((task, given), process.stdin, protocol=pickle.HIGHEST_PROTOCOL)
                process.stdin.flush()
                answer = self._answers.get(timeout=_CALL_S)
                if answer is None:
                    raise EOFError
            except (OSError, EOFError, queue.Empty) as error:
                self._end()
                how = f"did not answer for {_CALL_S:g} s" if isinstance(error, queue.Empty) else "died"
                raise LabrigError(
                    f"Open3D {how}: its process was ended; try again, or a smaller scan"
                ) from None
            except BaseException:
                self._end()  # Ctrl-C before the answer: it must not be taken for that of the next question
                raise
        worked, result = answer
        if not worked:
            raise LabrigError(result)
        return result

    def close(self) -> None:
        """End the worker, if there is one; a call that waits for it fails."""
        self._end()

    def _start(self) -> "subprocess.Popen[bytes]":
        self._end()
        if (error := lacking("open3d", "reading or placing a scan", "scan")) is not None:
            raise error
        self._process = process = subprocess.Popen(
            [sys.executable, "-m", "labrig.surface._aside_process"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
        )
        self._answers = queue.Queue()
        threading.Thread(target=_read, args=(process, self._answers), daemon=True).start()
        return process

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        process.kill()  # it holds nothing that could be lost
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(_CLOSE_S)
        if process.stdin is not None:
            with contextlib.suppress(OSError):
                process.stdin.close()


def _read(process: "subprocess.Popen[bytes]", answers: "queue.Queue[Any]") -> None:
    """Its answers as they come; None when it is gone."""
    assert process.stdout is not None
    with process.stdout as pipe:
        while True:
            try:
                answers.put(pickle.load(pipe))
            except (OSError, EOFError, pickle.UnpicklingError, ValueError):
                answers.put(None)
                return


_ASIDE = Aside()
atexit.register(_ASIDE.close)


def call(task: str, *given: Any) -> Any:
    """`Aside.call` of this process's one worker."""
    return _ASIDE.call(task, *given)
