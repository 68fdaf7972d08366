"""When the guard vents, to the tenth of a second: its own loop, on a clock and a device of the test."""

import io
import json
import queue
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from labrig.rig import GuardedPressure, load_rig
from labrig.rig._guard_process import main
from labrig_drivers import DeviceError, VentNotConfirmedError, VentReport

HEARTBEAT_S = 2.0
NEVER_S = 1e6


class Clock:
    """Stands in for the module `time`; only the thread that made it moves it."""

    def __init__(self) -> None:
        self.now_s = 1000.0
        self._mine = threading.current_thread()

    def monotonic(self) -> float:
        """The time now."""
        return self.now_s

    def sleep(self, duration_s: float) -> None:
        """Move on."""
        if threading.current_thread() is self._mine:
            self.now_s += duration_s
        else:
            time.sleep(duration_s)


class Chambers:
    """A pressure controller whose set-points and vents may fail; keeps when it was vented, s from the start."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.set_fails = False
        self.vents_fail = 0
        self.failure: BaseException = VentNotConfirmedError("pressure: not vented")
        self.vented_s: list[float] = []

    def connect(self) -> None:
        """Nothing to open."""

    def close(self) -> None:
        """Nothing to release."""

    def samples(self) -> list[Any]:
        """None."""
        return []

    def set(self, _pressure_kpa: Any) -> None:
        """Reach the chambers, and then perhaps fail."""
        if self.set_fails:
            raise DeviceError("pressure: lost the board")

    def vent(self, _timeout_s: float) -> VentReport:
        """Vent, or fail as often as it was told to."""
        if self.vents_fail:
            self.vents_fail -= 1
            raise self.failure
        self.vented_s.append(self.clock.now_s - 1000.0)
        return VentReport(np.zeros(2), 0.1)


class Input:
    """What the runner sends: requests, stretches of silence in s, and at last the end of the input."""

    def __init__(self, clock: Clock, *moments: dict[str, Any] | float | str) -> None:
        self.clock, self.moments = clock, list(moments)
        self.silent_until_s = clock.now_s

    def get(self, timeout: float) -> str | None:
        """The next line, None at the end; raises `queue.Empty` as a queue does."""
        if self.clock.now_s < self.silent_until_s:
            self.clock.sleep(timeout)
            raise queue.Empty
        if not self.moments:
            self.moments = [NEVER_S]
            return None
        moment = self.moments.pop(0)
        if isinstance(moment, str):
            return moment
        if isinstance(moment, dict):
            return json.dumps({"id": 1, **moment})
        assert moment < NEVER_S, "the guard asked for more after the end of its input"
        self.silent_until_s = self.clock.now_s + moment
        return self.get(timeout)

    def put(self, _line: str | None) -> None:
        """The end of the standard input, which says nothing here."""


SET = {"do": "set", "pressure_kpa": [40.0, 30.0]}
CONNECT = {"do": "connect"}
SAMPLES = {"do": "samples"}
VENT = {"do": "vent", "timeout_s": 10.0}


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """The guard's clock."""
    clock = Clock()
    monkeypatch.setattr("labrig.rig._guard_process.time", clock)
    return clock


@pytest.fixture
def chambers(clock: Clock, monkeypatch: pytest.MonkeyPatch) -> Chambers:
    """The guard's device."""
    chambers = Chambers(clock)
    monkeypatch.setattr("labrig.rig._guard_process.device_maker", lambda *_: lambda: chambers)
    return chambers


@pytest.fixture
def guard(
    write_rig: Callable[..., Path],
    clock: Clock,
    chambers: Chambers,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> Callable[..., list[str]]:
    """Let a guard serve an input to its end, here and without signals; returns the lines of its log."""

    def serve_all(
        *moments: dict[str, Any] | float | str, armed: bool = False, output: io.StringIO | None = None
    ) -> list[str]:
        config = load_rig(write_rig(safety={"heartbeat_s": HEARTBEAT_S}))
        log = tmp_path / "guard.log"
        setup = {
            "id": 0,
            "rig": config.to_dict(),
            "folder": str(tmp_path),
            "log": str(log),
            "offset_s": 0.0,
            "armed": armed,
        }
        requests = Input(clock, *moments)
        fake = SimpleNamespace(SimpleQueue=lambda: requests, Empty=queue.Empty)
        monkeypatch.setattr("labrig.rig._guard_process.queue", fake)
        monkeypatch.setattr("labrig.rig._guard_process.signal", SimpleNamespace())
        assert main(io.StringIO(json.dumps(setup) + "\n"), output or io.StringIO()) == 0
        lines = log.read_text(encoding="utf-8").splitlines() if log.exists() else []
        return [line.split(" ", 1)[1] for line in lines]

    return serve_all


def test_a_computer_that_slept_vents_and_ends_the_run(
    guard: Any, clock: Clock, chambers: Chambers, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No process misses a sign of life in a sleep, which no clock of theirs counts: chambers were held meanwhile."""
    answers = io.StringIO()
    monkeypatch.setattr("labrig.rig._guard_process.asleep_s", lambda: 7.0 if clock.now_s < 1001.0 else 3607.0)
    log = guard(SET, 0.5, SAMPLES, 0.8, SAMPLES, 0.1, SAMPLES, output=answers)
    assert chambers.vented_s == [pytest.approx(1.0, abs=0.2)]
    assert log == ["the computer slept for 3600 s: venting", "vented: 0.00 kPa at most"]
    said = [json.loads(line) for line in answers.getvalue().splitlines()]
    refused = "pressure: the guard vented: the computer slept for 3600 s"
    assert [each.get("message") for each in said if each["id"] == 1] == [None, None, refused, refused]


def test_silence_is_a_heartbeat_long(guard: Any, chambers: Chambers) -> None:
    """The guard vents a tenth of a second after the heartbeat's time, counted from the last request."""
    log = guard(SET, 1.9, SAMPLES, 1.9, SAMPLES, 60.0, SAMPLES)
    assert chambers.vented_s == [pytest.approx(1.9 + 1.9 + HEARTBEAT_S, abs=0.4)]
    assert log[0].startswith("no sign of life from the runner for 2.")


def test_a_thinking_procedure_is_waited_for_as_long_as_it_said(guard: Any, chambers: Chambers) -> None:
    """`allow_s` counts for the next silence only."""
    guard(SET, {"do": "allow", "allow_s": 50.0}, 49.0, SAMPLES, 60.0)
    assert chambers.vented_s == [pytest.approx(49.0 + HEARTBEAT_S, abs=0.4)]


def test_vented_chambers_need_no_sign_of_life(guard: Any, chambers: Chambers) -> None:
    """After a vent that was asked for, silence and the end of the runner are no reason to vent again."""
    assert guard(SET, VENT, 3600.0) == []
    assert len(chambers.vented_s) == 1


def test_the_end_of_the_input_vents_and_ends_the_guard(guard: Any, chambers: Chambers) -> None:
    """A runner that is gone need not be missed for a heartbeat."""
    log = guard(SET, 1.0)
    assert chambers.vented_s == [pytest.approx(1.0, abs=0.2)]
    assert log[0] == "the runner is gone: venting"


def test_a_set_point_that_failed_half_way_is_vented(guard: Any, chambers: Chambers) -> None:
    """The device may have taken it before it was lost: the chambers count as under pressure."""
    chambers.set_fails = True
    guard(SET)
    assert len(chambers.vented_s) == 1


def test_after_a_vent_that_failed_the_guard_goes_on_trying(guard: Any, chambers: Chambers) -> None:
    """The runner asked for a vent that was not confirmed, and is gone: the guard vents until it is."""
    chambers.vents_fail = 3
    log = guard(SET, VENT)
    assert len(chambers.vented_s) == 1
    assert log == [
        "the runner is gone: venting",
        "vent failed: pressure: not vented",
        "vent failed: pressure: not vented",
        "vented: 0.00 kPa at most",
    ]


def test_a_driver_that_ends_the_program_does_not_end_the_guard(guard: Any, chambers: Chambers) -> None:
    """A vendor's library that calls `sys.exit` in a vent is a vent that failed: the guard goes on trying."""
    chambers.vents_fail, chambers.failure = 3, SystemExit(0)
    log = guard(SET, VENT)
    assert len(chambers.vented_s) == 1
    assert log == [
        "the runner is gone: venting",
        "vent failed: 0",
        "vent failed: 0",
        "vented: 0.00 kPa at most",
    ]


def test_a_first_vent_that_failed_is_tried_again(guard: Any, chambers: Chambers) -> None:
    """A run before this one may have left pressure behind: a vent that was asked for and not confirmed is still due."""
    chambers.vents_fail = 3
    log = guard(CONNECT, VENT)
    assert len(chambers.vented_s) == 1
    assert log[0] == "the runner is gone: venting"


def test_a_controller_that_was_never_reached_is_not_waited_for(guard: Any, chambers: Chambers) -> None:
    """Where no link was ever open, nothing was filled over it: the guard ends with its runner."""
    chambers.vents_fail = 1
    assert guard(VENT) == []
    assert chambers.vented_s == []


def test_a_guard_in_anothers_place_vents_what_that_one_filled(guard: Any, chambers: Chambers) -> None:
    """It is told that the chambers may be under pressure, and need not have filled them itself."""
    assert guard(CONNECT, armed=True)[0] == "the runner is gone: venting"
    assert len(chambers.vented_s) == 1


def test_a_request_that_makes_no_sense_vents(guard: Any, chambers: Chambers) -> None:
    """A fault in the guard itself is no reason to leave pressure behind."""
    log = guard(SET, "no request")
    assert len(chambers.vented_s) == 1
    assert log[0].startswith("the guard failed (JSONDecodeError: ")


class Pipes:
    """A guard process that takes requests and never answers."""

    pid = 0

    def __init__(self) -> None:
        self.stdin = io.StringIO()
        self.stdout = None

    def poll(self) -> int | None:
        """Still there."""
        return None

    def wait(self, _timeout_s: float) -> int:
        """Gone at once."""
        return 0


@pytest.fixture
def pressure(write_rig: Callable[..., Path]) -> Iterator[Any]:
    """The runner's side, with answers that the test puts into it."""
    pressure = GuardedPressure(load_rig(write_rig()))
    pressure._process = Pipes()  # type: ignore[assignment]
    yield pressure
    pressure.close()


def test_a_late_answer_is_not_taken_for_another_calls(pressure: Any) -> None:
    """The confirmation of an earlier vent, whose caller had given up, does not confirm the present one."""
    late = {"id": 0, "value": {"pressure_kpa": [0.0, 0.0], "took_s": 0.1}}
    mine = {"id": 1, "error": "VentNotConfirmedError", "message": "pressure: not vented"}
    for answer in (late, mine):
        pressure._answers.put(json.dumps(answer))
    with pytest.raises(VentNotConfirmedError, match=r"^pressure: not vented$"):
        pressure.vent(1.0)


def test_a_vent_that_somebody_else_asked_for_is_waited_for(
    pressure: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A guard that vents for another process is not ended by a call that is to be quick: that would end the vent."""
    monkeypatch.setattr("labrig.rig._guard._USE_S", 0.2)
    answer = {"id": 1, "error": "DeviceError", "message": "pressure: stopped by the vent page"}

    def vents(venting: bool) -> None:
        pressure._answers.put(json.dumps({"id": None, "venting": venting}))
        time.sleep(0.6)
        pressure._answers.put(json.dumps(answer))

    killed: list[bool] = []
    pressure._process.kill = lambda: killed.append(True)
    for venting, said in (
        (False, "did not come back from `samples` within 0.2 s"),
        (True, "stopped by the vent page"),
    ):
        pressure._number, pressure._answers = 0, queue.Queue()
        other = threading.Thread(target=vents, args=(venting,))
        other.start()
        with pytest.raises(DeviceError, match=said):
            pressure.samples()
        other.join()
    assert killed == [True]


def test_one_call_at_a_time_speaks_to_the_guard(pressure: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A second thread waits until the first has its answer: nobody takes what belongs to another."""
    inside = threading.Event()
    overlaps: list[bool] = []

    def receive(number: int, _timeout_s: float) -> Any:
        overlaps.append(inside.is_set())
        inside.set()
        if number == 1:
            other.start()
            other.join(0.3)  # long enough for a call that does not wait; one that does is still there
        inside.clear()
        return []

    other = threading.Thread(target=pressure.samples)
    monkeypatch.setattr(pressure, "_receive", receive)
    pressure.samples()
    other.join()
    assert overlaps == [False, False]


def test_the_exit_code_of_a_guard_that_ends_is_waited_for(write_rig: Callable[..., Path]) -> None:
    """Its output closes a moment before it has ended: the code is what it ends with, not that it has none yet."""
    pressure = GuardedPressure(load_rig(write_rig()))
    pressure._process = SimpleNamespace(poll=lambda: None, wait=lambda _timeout_s: 3)  # type: ignore[assignment]
    assert str(pressure._gone()) == "pressure: the guard process ended (exit code 3); look at the chambers"
