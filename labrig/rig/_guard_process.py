"""The guard: a process of its own that holds the pressure link, and vents when nobody is left to ask for it.

It reads one JSON request per line on its standard input and answers each with one line. It vents on its own when
the input ends (the runner is gone, however that happened), when no request came for the heartbeat's time while the
chambers may be under pressure (the runner hangs), when the computer slept meanwhile, and on SIGTERM. It retries until
reading confirms the vent. Other processes of the same user may ask it for a vent, too: the run is over then.

What it cannot cover: being killed itself with SIGKILL at the same moment as the runner, and a PC without power.
For that the rig needs normally-open valves.
"""

import contextlib
import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from labrig._errors import LabrigError
from labrig._own_code import FAULTS
from labrig.rig._asked import Asked, receive
from labrig.rig._asleep import asleep_s
from labrig.rig._config import RigConfig
from labrig.rig._factory import device_maker
from labrig.rig._guard_words import GuardAnswer, GuardRequest, Identified, Setup, apart
from labrig.run_contents import VentContent
from labrig_drivers import DeviceError, RealClock, VentReport

_RETRY_S = 0.5
_IDLE_S = 0.1
_BEAT_S = 0.5
_QUICK = ("set", "samples")
_HANGS_S = 3.0
_VENT_MORE_S = 30.0
"""How much longer than its own limit a vent may take: a link that is dead is opened anew meanwhile."""
_SLEEP_S = 1.0
"""A shorter sleep is none: two clocks are not read in the same moment."""
_SIGNALS = ("SIGTERM", "SIGINT", "SIGHUP", "SIGBREAK")  # SIGHUP is POSIX only, SIGBREAK Windows only


class Guard:
    """Holds one pressure controller and carries out what the runner asks of it."""

    def __init__(self, config: RigConfig, log: Path | None, clock: RealClock, armed: bool = False) -> None:
        self.config, self._log_path = config, log
        self.device: Any = device_maker(config, "pressure", config.pressure, clock)()
        self.armed = armed
        self.reached = False
        self.vented_alone: str | None = None
        self.stopped: str | None = None
        self.asked: list[Asked] = []
        self.deadline = float("inf")
        self.waits: tuple[float, float] | None = None
        """Since when the device has been asked for something, and how long that may take, s."""
        self.stopping = False

    def answer(self, request: GuardRequest) -> GuardAnswer:
        """Carry out one request; an error becomes an answer, too."""
        self.waits = (time.monotonic(), _HANGS_S) if request["do"] in _QUICK else None
        try:
            return {"value": getattr(self, f"do_{request['do']}")(request)}
        except (DeviceError, LabrigError) as error:
            return {"error": type(error).__name__, "message": str(error)}
        except FAULTS as error:
            return {"error": "DeviceError", "message": f"pressure: {type(error).__name__}: {error}"}
        finally:
            self.waits = None

    def vent(self, timeout_s: float) -> VentReport:
        """Vent once: it counts as confirmed, and the chambers as empty, where this does not raise."""
        self.waits = time.monotonic(), timeout_s + _VENT_MORE_S
        try:
            report = self.device.vent(timeout_s)
        finally:
            self.waits = None
        self.armed = False
        return report

    def do_connect(self, _request: GuardRequest) -> None:
        """Open the link."""
        self.device.connect()
        self.reached = True

    def do_identify(self, _request: GuardRequest) -> Identified:
        """Who the device is."""
        who = self.device.identify()
        return {"name": who.name, "kind": who.kind, "description": who.description, "details": who.details}

    def do_set(self, request: GuardRequest) -> None:
        """Command set-points, unless the guard has vented on its own since the last vent that was asked for."""
        if self.vented_alone is not None:
            raise DeviceError(f"pressure: {self.vented_alone}")
        self.armed = True
        self.device.set(np.array(request["pressure_kpa"], float))

    def do_samples(self, _request: GuardRequest) -> list[Any]:
        """Every measurement since the last call; refused after a vent that somebody else asked for."""
        if self.stopped is not None:
            raise DeviceError(f"pressure: {self.stopped}")
        return [[sample.time_s, sample.pressure_kpa.tolist()] for sample in self.device.samples()]

    def do_vent(self, request: GuardRequest) -> VentContent:
        """Vent and confirm: until then the chambers may hold what a run before this one left in them."""
        self.armed |= self.reached
        report = self.vent(request["timeout_s"])
        self.vented_alone = self.stopped = None
        return {"pressure_kpa": report.pressure_kpa.tolist(), "took_s": report.took_s}

    def vent_for(self, asked: Asked) -> None:
        """Vent because somebody else asks for it, and let the runner know that its run is over."""
        self.vented_alone = self.stopped = f"stopped by {asked.why}"
        self.armed |= self.reached
        self.log(f"{asked.why}: venting")
        try:
            report = self.vent(self.config.safety.vent_timeout_s)
        except FAULTS as error:  # whoever asks must hear of it, and asks again
            self.log(f"vent failed: {error}")
            asked.answer.set_exception(LabrigError(str(error)))
            return
        self.log(f"vented: {float(np.nanmax(np.abs(report.pressure_kpa))):.2f} kPa at most")
        asked.answer.set_result({"pressure_kpa": report.pressure_kpa.tolist(), "took_s": report.took_s})

    def do_allow(self, request: GuardRequest) -> None:
        """Nothing to do: the time allowed is taken from the request itself."""

    def do_close(self, _request: GuardRequest) -> None:
        """End; the vent, if one is still due, comes on the way out."""
        self.stopping = True

    def vent_alone(self, why: str, patience_s: float) -> None:
        """Vent until it is confirmed or the patience is over."""
        end = time.monotonic() + patience_s
        self.vented_alone = f"the guard vented: {why}"
        self.log(f"{why}: venting")
        while True:
            try:
                report = self.vent(self.config.safety.vent_timeout_s)
            except FAULTS as error:  # whatever it is, the next attempt must be made
                self.log(f"vent failed: {error}")
                if time.monotonic() >= end:
                    return
                time.sleep(_RETRY_S)
                continue
            self.log(f"vented: {float(np.nanmax(np.abs(report.pressure_kpa))):.2f} kPa at most")
            return

    def log(self, text: str) -> None:
        """Append a line to the guard's own log; never fails."""
        if self._log_path is None:
            return
        try:
            with self._log_path.open("a", encoding="utf-8") as file:
                file.write(f"{datetime.now().astimezone().isoformat(timespec='milliseconds')} {text}\n")
        except OSError:
            self._log_path = None


class Answers:
    """The guard's output: one line for each answer, and one twice a second while the guard is at work.

    That is how the runner tells a device that takes long, or a vent that it did not ask for, from a guard that is gone.
    """

    def __init__(self, output: TextIO) -> None:
        self._output = output
        self._lock = threading.Lock()
        self._busy = threading.Event()
        self._venting = False
        threading.Thread(target=self._beat, daemon=True).start()

    @contextlib.contextmanager
    def meanwhile(self, venting: bool = False) -> Iterator[None]:
        """Say that the guard is at work; or `venting`, which no call of the runner may cut short."""
        self._venting = venting
        self._busy.set()
        try:
            yield
        finally:
            self._busy.clear()

    def say(self, answer: GuardAnswer) -> None:
        """Write a line; raises `OSError` when nobody reads."""
        with self._lock:
            print(json.dumps(answer), file=self._output, flush=True)

    def _beat(self) -> None:
        while True:
            self._busy.wait()
            time.sleep(_BEAT_S)
            if self._busy.is_set():
                try:
                    self.say({"id": None, "venting": self._venting})
                except (OSError, ValueError):  # the runner is gone: the end of the input tells the guard
                    return


def serve(guard: Guard, requests: "queue.SimpleQueue[str | Asked | None]", answers: Answers) -> None:
    """Answer requests until they end, and see to it that the chambers are vented then."""
    safety = guard.config.safety
    why = "the runner is gone"
    asleep = asleep_s()
    try:
        while not guard.stopping:
            slept_s = asleep_s() - asleep
            asleep += max(0.0, slept_s)
            if guard.armed and slept_s > _SLEEP_S:
                with answers.meanwhile(venting=True):
                    guard.vent_alone(f"the computer slept for {slept_s:.0f} s", safety.vent_patience_s)
                guard.stopped = guard.vented_alone
            try:
                line = requests.get(timeout=_IDLE_S)
            except queue.Empty:
                if guard.armed and time.monotonic() > guard.deadline:
                    silent_s = time.monotonic() - guard.deadline + safety.heartbeat_s
                    with answers.meanwhile(venting=True):  # a runner that comes back finds the guard at work
                        guard.vent_alone(
                            f"no sign of life from the runner for {silent_s:.1f} s", safety.vent_patience_s
                        )
                continue
            if line is None:
                break
            if isinstance(line, Asked):
                with answers.meanwhile(venting=True):
                    guard.vent_for(line)
                guard.asked.remove(line)
                continue
            request: GuardRequest = json.loads(line)
            guard.deadline = time.monotonic() + max(safety.heartbeat_s, request.get("allow_s", 0.0))
            with answers.meanwhile():
                answer = guard.answer(request)
            guard.deadline = max(guard.deadline, time.monotonic() + safety.heartbeat_s)
            try:
                answers.say({**answer, "id": request["id"]})
            except OSError:
                break
    except BaseException as error:
        why = f"the guard failed ({type(error).__name__}: {error})"
    finally:
        if guard.armed:
            guard.vent_alone(why, safety.guard_patience_s)
        _answer_last(guard)
        guard.device.close()


def _answer_last(guard: Guard) -> None:
    """Those who asked while the guard was on its way out hear the pressure, too."""
    for asked in guard.asked:
        if not asked.answer.done():
            guard.vent_for(asked)


def main(lines: TextIO, output: TextIO) -> int:
    """Run the guard: the first of the lines is the rig, the others are requests; the answers go to the output."""
    requests: queue.SimpleQueue[str | Asked | None] = queue.SimpleQueue()  # a signal may put into it
    for name in _SIGNALS:
        number = getattr(signal, name, None)
        if number is not None:
            signal.signal(number, signal.SIG_IGN if name == "SIGINT" else lambda *_: requests.put(None))
    line = lines.readline()
    setup: Setup = json.loads(line)
    config = RigConfig.model_validate({**setup["rig"], "folder": setup["folder"]})
    log = Path(setup["log"]) if setup["log"] else None
    try:
        guard = Guard(config, log, RealClock(setup["offset_s"]), setup["armed"])
    except (DeviceError, LabrigError) as error:
        refusal = {"id": 0, "error": type(error).__name__, "message": str(error)}
        print(json.dumps(refusal), file=output, flush=True)
        return 1
    print(json.dumps({"id": 0, "value": None}), file=output, flush=True)
    ended = threading.Event()
    threading.Thread(target=_read, args=(lines, requests, ended), daemon=True).start()
    threading.Thread(target=_watch, args=(guard, ended, line), daemon=True).start()

    def ask(asked: Asked) -> None:
        guard.asked.append(asked)
        requests.put(asked)

    reception = receive(config, log, ask)
    try:
        serve(guard, requests, Answers(output))
    finally:
        guard.stopping = True
        if reception is not None:
            reception.close()
    return 0


def _to_itself() -> tuple[TextIO, TextIO]:
    """The runner's requests and the answers to it, where a driver that prints, or asks somebody, reaches neither."""
    lines = os.fdopen(os.dup(sys.stdin.fileno()), encoding="utf-8")
    output = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, sys.stdin.fileno())
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
    return lines, output


def _read(lines: TextIO, requests: "queue.SimpleQueue[str | Asked | None]", ended: threading.Event) -> None:
    for line in lines:
        requests.put(line)
    ended.set()
    requests.put(None)


def _watch(guard: Guard, ended: threading.Event, setup: str) -> None:
    """A driver that never comes back holds this process: where no runner is left to end it, another takes its place.

    A runner that is well does so itself, and sooner.
    """
    while not guard.stopping:
        more_s = _BEAT_S if ended.is_set() else _BEAT_S + guard.config.safety.heartbeat_s
        waits = guard.waits
        if waits is not None and time.monotonic() - waits[0] > waits[1] + more_s:
            guard.log("the device does not come back: another process vents")
            with contextlib.suppress(OSError):  # tried again, should there be no more processes now
                _hand_over(setup)
        time.sleep(_BEAT_S / 2)


def _hand_over(setup: str) -> None:
    """Start the process that vents in this one's place, and let go of the link by ending at once."""
    process = subprocess.Popen(
        [sys.executable, "-m", "labrig.rig._guard_last"],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        text=True,
        encoding="utf-8",
        **apart(),
    )
    if process.stdin is not None:
        process.stdin.write(setup)
        process.stdin.close()
    os._exit(1)


if __name__ == "__main__":
    sys.exit(main(*_to_itself()))
