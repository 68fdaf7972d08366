"""The runner's side of the guard: a pressure controller whose link lives in another process."""

import contextlib
import json
import os
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig._outliving import outlives
from labrig.rig._config import RigConfig
from labrig.rig._guard_words import GuardRequest, Setup, apart
from labrig_drivers import (
    Channel,
    DeviceError,
    Identity,
    PressureSample,
    RealClock,
    VentNotConfirmedError,
    VentReport,
)

_START_S = 30.0
_CALL_S = 15.0
_USE_S = 3.0
"""How long a device may take for a set-point, or to say what it measured: longer, and nobody could vent meanwhile."""

_CLOSE_S = 5.0
_ENDS_S = 0.5
"""How long the exit code of a guard that has closed its output is waited for: nobody vents meanwhile."""
_SILENT_S = 3.0
"""A guard that is at work says so twice a second; one that says nothing for so long does not run any more."""

_ERRORS = {kind.__name__: kind for kind in (DeviceError, VentNotConfirmedError, LabrigError)}


class GuardedPressure:
    """A `PressureController` in a process of its own, which vents when this one is gone or hangs.

    A guard that does not answer is ended, so that the link is free, and the next `vent` is another guard's, or made
    from here where none can be started. `log` is a file that the guard appends to when it acts on its own.
    """

    def __init__(
        self,
        config: RigConfig,
        name: str = "pressure",
        log: Path | None = None,
        clock: RealClock | None = None,
    ) -> None:
        self.name = name
        self._clock = clock or RealClock()
        self._guards_offset_s = self._clock.offset_s
        self.channels: Sequence[Channel] = config.channels
        self._config, self._log = config, log
        self._process: subprocess.Popen[str] | None = None
        self._answers: queue.Queue[str | None] = queue.Queue()
        self._lock = threading.Lock()
        self._number = 0
        self._doing = "start"
        self._vented = True
        """Whether no guard can have left pressure behind: none was asked to fill or to vent since a confirmed vent."""

    def connect(self) -> None:
        """Start the guard and have it open the link; raises `DeviceError` if it or the device does not answer."""
        if self._process is None or self._process.poll() is not None:
            self._start()
        self._call({"do": "connect"})

    def _start(self) -> None:
        if self._process is not None:
            _close_pipes(self._process)
        self._process = subprocess.Popen(
            [sys.executable, "-m", "labrig.rig._guard_process"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            encoding="utf-8",
            env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
            **apart(),
        )
        self._answers = queue.Queue()
        self._guards_offset_s = self._clock.offset_s
        threading.Thread(target=_read, args=(self._process, self._answers), daemon=True).start()
        setup: Setup = {
            "id": 0,
            "rig": self._config.to_dict(),
            "folder": str(self._config.folder.resolve()),
            "log": str(self._log.resolve()) if self._log is not None else None,
            "offset_s": self._guards_offset_s,
            "armed": not self._vented,
        }
        self._send(setup)
        self._receive(0, _START_S, silent_s=_START_S)

    def identify(self) -> Identity:
        """Who the device behind the guard is."""
        return Identity(**self._call({"do": "identify"}))

    def set(self, pressure_kpa: NDArray[np.float64]) -> None:
        """Command set-points; refused once the guard has vented on its own, until a vent is asked for."""
        self._vented = False
        self._call({"do": "set", "pressure_kpa": np.asarray(pressure_kpa, float).tolist()}, _USE_S)

    def samples(self) -> list[PressureSample]:
        """Every measurement since the last call; each call is a sign of life."""
        ahead_s = self._clock.offset_s - self._guards_offset_s
        return [
            PressureSample(time_s + ahead_s, np.array(values, float))
            for time_s, values in self._call({"do": "samples"}, _USE_S)
        ]

    def vent(self, timeout_s: float = 10.0) -> VentReport:
        """Vent and confirm; if the guard is gone, a new one is started for it, or the vent is made from here."""
        if self._process is None or self._process.poll() is not None:
            try:
                self._start()
            except (OSError, DeviceError):
                return self._vent_from_here(timeout_s)
            self._call({"do": "connect"})
        self._vented = False
        answer = self._call({"do": "vent", "timeout_s": timeout_s}, timeout_s + _CALL_S)
        self._vented = True
        return VentReport(np.array(answer["pressure_kpa"], float), answer["took_s"])

    def _vent_from_here(self, timeout_s: float) -> VentReport:
        """Vent over a link of this process's own, because there is no guard."""
        from labrig.rig._factory import device_maker

        device = device_maker(self._config, "pressure", self._config.pressure, self._clock)()
        try:
            device.connect()
            report = device.vent(timeout_s)
        finally:
            device.close()
        self._vented = True
        return report

    def allow_silence(self, duration_s: float) -> None:
        """Say that the next sign of life may take this long."""
        self._call({"do": "allow", "allow_s": duration_s}, _USE_S)

    def close(self) -> None:
        """End the guard; one that still vents is left to it."""
        process = self._process
        if process is None:
            return
        with contextlib.suppress(OSError):
            if process.stdin is not None:
                process.stdin.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(_CLOSE_S)
            _close_pipes(process)
            self._process = None
        outlives(process)

    def _call(self, request: GuardRequest, timeout_s: float = _CALL_S) -> Any:
        with self._lock:
            self._number += 1
            self._send({**request, "id": self._number})
            self._doing = request["do"]
            return self._receive(self._number, timeout_s)

    def _send(self, message: GuardRequest | Setup) -> None:
        process = self._process
        if process is None or process.stdin is None:
            raise DeviceError(f"{self.name}: not connected")
        try:
            process.stdin.write(json.dumps(message) + "\n")
            process.stdin.flush()
        except (OSError, ValueError):
            raise self._gone() from None

    def _receive(self, number: int, timeout_s: float, silent_s: float = _SILENT_S) -> Any:
        """The answer to a request; those to earlier ones, whose callers gave up, are passed over.

        A vent that the guard makes meanwhile, because somebody else asked for it, is waited for.
        """
        end = time.monotonic() + timeout_s
        vent_s = time.monotonic() + self._config.safety.vent_timeout_s + _CALL_S
        at_work = False
        while True:
            left_s = end - time.monotonic()
            try:
                line = self._answers.get(timeout=max(0.0, min(left_s, silent_s)))
            except queue.Empty:
                silent = not at_work or left_s > silent_s
                waited_s = min(timeout_s, silent_s) if silent else timeout_s
                raise self._stuck("" if silent else self._doing, waited_s) from None
            if line is None:
                raise self._gone()
            answer = json.loads(line)
            if answer["id"] == number:
                break
            at_work = answer["id"] is None
            if answer.get("venting") and vent_s > end:
                end, timeout_s = vent_s, timeout_s + vent_s - end
        if "error" in answer:
            raise _ERRORS.get(answer["error"], DeviceError)(answer["message"])
        return answer["value"]

    def _stuck(self, busy_with: str, waited_s: float) -> DeviceError:
        """End a guard that is stopped or hangs, or whose device does: it holds the link, and nobody else can vent."""
        if self._process is not None:
            self._process.kill()
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(_CLOSE_S)
        if busy_with:
            return DeviceError(
                f"{self.name}: the device did not come back from `{busy_with}` within {waited_s:g} s, and its guard "
                "was ended; check the driver and its link"
            )
        return DeviceError(f"{self.name}: the guard did not answer for {waited_s:g} s and was ended")

    def _gone(self) -> DeviceError:
        code = None
        if self._process is not None:
            with contextlib.suppress(
                subprocess.TimeoutExpired
            ):  # its output closes a moment before it has ended
                code = self._process.wait(_ENDS_S)
        return DeviceError(f"{self.name}: the guard process ended (exit code {code}); look at the chambers")


def _close_pipes(process: "subprocess.Popen[str]") -> None:
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with contextlib.suppress(OSError):
                pipe.close()


def _read(process: "subprocess.Popen[str]", answers: "queue.Queue[str | None]") -> None:
    if process.stdout is not None:
        try:
            for line in process.stdout:
                answers.put(line)
        except ValueError:  # closed by `close`
            pass
    answers.put(None)
