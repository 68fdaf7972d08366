"""Keeps the process of the vent button (`_vent_page`) running, and knows where it is."""

import json
import os
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any, TypedDict

from labrig._errors import LabrigError
from labrig._outliving import outlives

_ENDS_S = 3.0


class VentPlace(TypedDict):
    """Where the button's page is, and the key that it asks for."""

    port: int
    key: str


class VentButton:
    """The button of one rig. Its process is started at once, and again if it should have ended."""

    def __init__(self, rig_file: Path, host: str) -> None:
        self._rig_file, self._host = rig_file, host
        self._lock = threading.Lock()
        self._place: VentPlace | None = None
        self._process = self._start()

    def _start(self) -> subprocess.Popen[str]:
        options: dict[str, Any] = {}
        if sys.platform == "win32":
            options["creationflags"] = subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW
        else:
            options["start_new_session"] = True  # Ctrl-C and a closed terminal are not for it
        return subprocess.Popen(
            [sys.executable, "-m", "labrig.workbench._vent_page", str(self._rig_file), self._host],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
            **options,
        )

    @property
    def place(self) -> VentPlace:
        """Its `port` and `key`; waits for the process to begin. Raises `LabrigError` where it cannot."""
        with self._lock:
            if self._process.poll() is not None:
                self._let_go()
                self._process, self._place = self._start(), None
            place = self._place
            if place is None:
                line = self._process.stdout.readline() if self._process.stdout is not None else ""
                if not line:
                    raise LabrigError(
                        f"the vent button does not start; vent with: labrig rig vent {self._rig_file}"
                    )
                self._place = place = json.loads(line)
            return place.copy()

    @property
    def pid(self) -> int:
        """The number of its process."""
        return self._process.pid

    def close(self) -> None:
        """Let it go: it ends by itself, after the runs on its rig have."""
        self._let_go()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_ENDS_S)
        outlives(self._process)

    def _let_go(self) -> None:
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()
