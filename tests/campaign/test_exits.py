"""However a run ends, in whatever step: the chambers are vented, and confirmed to be, before anything else."""

import signal
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig import LabrigError, open_run
from labrig.campaign import (
    Actuate,
    Interrupted,
    Note,
    Observer,
    Procedure,
    ProcedureError,
    Progress,
    Record,
    RigInfo,
    Scan,
    Settle,
    Steps,
    Vent,
    Watching,
    run,
)
from labrig.log import LogWriter, summarise
from labrig_drivers import DeviceError, VentNotConfirmedError

VENTED_KPA = 0.5
WITHIN_S = 5.0
NOTICED_S = {
    "stale telemetry": 4.0,
    "mocap lost": 4.0,
    "over-pressure": 4.0,
    "scanner never delivers": 120.0,
    "pressure link lost and back": 6.0,
}
"""A vent is confirmed `WITHIN_S` of the run's clock after a fault is noticed: some are when a limit has passed
(1 s for stale telemetry, 2 s here for mocap), or a scan that is under way has ended (2 s)."""

KINDS = ("actuate", "settle", "record", "scan", "note", "vent")


class Moment:
    """Where the run is, told by the procedure; acts once in the chosen step."""

    def __init__(self, kind: str, act: Callable[[], None], commands: list[Any]) -> None:
        self.kind, self.act, self.commands = kind, act, commands
        self.now = ""
        self.armed = True

    def enter(self, kind: str) -> None:
        """The procedure is about to yield a step of this kind, for the second time round."""
        if not self.commands:
            return  # the dry run that goes before
        self.now = kind
        if kind == "note":
            self.check()

    def check(self) -> None:
        """Act if this is the moment."""
        if self.armed and self.now == self.kind:
            self.armed = False
            self.act()


MOMENTS: list[Moment] = []


class Everything(Procedure):
    """Every kind of step, under pressure, twice."""

    def steps(self, rig: RigInfo) -> Steps:
        """The second round is the one in which things happen."""
        for pressure_kpa in (30.0, 50.0):
            steps = [
                Actuate((pressure_kpa,) * len(rig.channels)),
                Settle(1.0),
                Record(0.5),
                Note("a note"),
                Scan(),
                Vent(),
                Actuate((pressure_kpa / 2,) * len(rig.channels)),
                Settle(3.0),
            ]
            for step in steps:
                if MOMENTS and pressure_kpa == 50.0:
                    MOMENTS[0].enter(step.kind)
                yield step


@pytest.fixture
def fake(make_rig: Any) -> Any:
    """A fake rig that notices soon when mocap is lost."""
    return make_rig(safety={"lost_mocap_s": 2.0})


@pytest.fixture
def moment(fake: Any) -> Iterator[Callable[[str, Callable[[], None]], Moment]]:
    """Arm an action for a kind of step; on this clock, it happens at the first sleep within the step."""

    def arm(kind: str, act: Callable[[], None]) -> Moment:
        MOMENTS[:] = [Moment(kind, act, fake.pressure.world.commands)]
        fake.clock.on_sleep = MOMENTS[0].check
        return MOMENTS[0]

    yield arm
    MOMENTS.clear()


def _raise_in_procedure(_fake: Any, _patch: pytest.MonkeyPatch) -> None:
    """The exception is raised where the procedure's code runs."""
    raise ValueError("a fault of the procedure")


def _raise_in_log(_fake: Any, patch: pytest.MonkeyPatch) -> None:
    def broken(*_: Any, **__: Any) -> None:
        raise RuntimeError("the log is broken")

    patch.setattr(LogWriter, "write", broken)
    patch.setattr(LogWriter, "measured", broken)


def _full_disk(_fake: Any, patch: pytest.MonkeyPatch) -> None:
    def full(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    for method in ("write", "measured", "frame", "step_done", "event", "close"):
        patch.setattr(LogWriter, method, full)


def _lose_link_for_a_while(fake: Any, _patch: pytest.MonkeyPatch) -> None:
    fake.pressure.faults["lost_until_s"] = fake.clock.now_s() + 4.0


def _signal(name: str) -> Callable[[Any, Any], None]:
    return lambda _fake, _patch: signal.raise_signal(getattr(signal, name))


def _fault(device: str, **fault: Any) -> Callable[[Any, Any], None]:
    return lambda fake, _patch: getattr(fake, device).faults.update(fault)


def _scanner_fault(fake: Any, _patch: pytest.MonkeyPatch) -> None:
    fake.rig.scanner.faults["never"] = True


EXITS: dict[str, tuple[Callable[[Any, Any], None], type[BaseException], str]] = {
    "exception in the log": (_raise_in_log, RuntimeError, "the log is broken"),
    "full disk": (
        _full_disk,
        LabrigError,
        "cannot be written: No space left on device; the chambers are vented",
    ),
    "Ctrl-C": (_signal("SIGINT"), Interrupted, "stopped by Ctrl-C after "),
    "SIGTERM": (_signal("SIGTERM"), Interrupted, "stopped by SIGTERM after "),
    "mocap lost": (
        _fault("mocap", lost=True),
        DeviceError,
        r"mocap: no frame for 2 s \(the limit is 2 s\)",
    ),
    "scanner never delivers": (_scanner_fault, DeviceError, "scanner: no scan within 120 s"),
    "pressure link lost and back": (_lose_link_for_a_while, DeviceError, "pressure: the link is lost"),
    "stale telemetry": (
        _fault("pressure", stale=True),
        DeviceError,
        r"pressure: (no measurement for 1\.\d s|vent not confirmed: no pressure was measured after it)",
    ),
    "over-pressure": (
        _fault("pressure", over_kpa=60.0),
        DeviceError,
        r"pressure: c1 reads \d+\.\d kPa, more than",
    ),
}
if hasattr(signal, "SIGHUP"):  # POSIX only
    EXITS["SIGHUP"] = (_signal("SIGHUP"), Interrupted, "stopped by SIGHUP after ")

NEVER = {("scanner never delivers", kind) for kind in KINDS if kind in ("vent",)}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("exit_path", EXITS)
def test_every_exit_vents(
    fake: Any, moment: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, exit_path: str, kind: str
) -> None:
    """A matrix of what may end a run and the step it happens in: 0 kPa within the stated time, and one error."""
    action, error_kind, message = EXITS[exit_path]
    happened: list[float] = []

    def act() -> None:
        happened.append(fake.clock.now_s())
        action(fake, monkeypatch)

    moment(kind, act)
    if (exit_path, kind) in NEVER:  # after the last scan there is none left that could fail
        run(Everything(), fake.rig, tmp_path / "run", fake.clock)
    else:
        with pytest.raises(error_kind, match=message):
            run(Everything(), fake.rig, tmp_path / "run", fake.clock)
    assert happened
    assert np.abs(fake.pressure_kpa).max() <= VENTED_KPA
    assert fake.pressure.world.commands[-1][1] == (0.0, 0.0)
    took_s = fake.clock.now_s() - happened[0]
    assert took_s <= WITHIN_S + NOTICED_S.get(exit_path, 0.0)


@pytest.mark.parametrize("kind", KINDS)
def test_an_exception_in_the_procedure_vents(fake: Any, tmp_path: Path, kind: str) -> None:
    """The procedure's own code may fail after any step; the error says where."""

    class Faulty(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            for step in Everything().steps(rig):
                yield step
                if step.kind == kind:
                    raise ValueError("a fault of the procedure")

    with pytest.raises(ProcedureError) as caught:
        run(Faulty(), fake.rig, tmp_path / "run", fake.clock)
    assert str(caught.value).startswith("procedure faulty failed at step ")
    assert ": ValueError: a fault of the procedure (test_exits.py, line " in str(caught.value)
    assert np.abs(fake.pressure_kpa).max() <= VENTED_KPA


def test_a_run_that_ends_well_is_vented(fake: Any, tmp_path: Path) -> None:
    """Returning is an exit path like the others."""
    run(Everything(), fake.rig, tmp_path / "run", fake.clock)
    assert np.abs(fake.pressure_kpa).max() <= VENTED_KPA
    assert open_run(tmp_path / "run").sizes["capture"] == 2


class _Hanging(Observer):
    """A viewer that never answers, or is gone."""

    def __init__(self, gone: bool) -> None:
        self.gone, self.calls = gone, 0
        self.release = threading.Event()

    def frame(self, frame: Any) -> None:
        """Raise, or hang until the test is over."""
        self.calls += 1
        if self.gone:
            raise ConnectionError("the viewer is gone")
        self.release.wait(60)


@pytest.mark.parametrize("gone", [True, False])
def test_a_viewer_that_dies_or_hangs_does_not_matter(fake: Any, tmp_path: Path, gone: bool) -> None:
    """The run goes on to its end and leaves the same data; the observer is left behind."""
    viewer = _Hanging(gone)
    try:
        run(Everything(), fake.rig, tmp_path / "run", fake.clock, watching=Watching([viewer]))
    finally:
        viewer.release.set()
    assert viewer.calls == 1 if gone else viewer.calls >= 1
    assert np.abs(fake.pressure_kpa).max() <= VENTED_KPA
    assert open_run(tmp_path / "run").sizes["capture"] == 2


def test_a_vent_that_is_not_confirmed_is_the_error(fake: Any, moment: Any, tmp_path: Path) -> None:
    """When reading does not confirm the vent, that is said first, and what had ended the run after it."""
    moment("record", lambda: fake.pressure.faults.update(never_vents=True, over_kpa=40.0))
    with pytest.raises(VentNotConfirmedError) as caught:
        run(Everything(), fake.rig, tmp_path / "run", fake.clock)
    assert str(caught.value) == (
        "pressure: not vented after 10 s (pressures now: c1 0.0 kPa, c2 0.0 kPa); relieve the pressure by hand; "
        "the run had ended because: pressure: c1 reads 86.6 kPa, more than "
        "5 kPa above its limit of 60 kPa"
    )


def test_a_signal_during_the_last_vent_does_not_stop_it(fake: Any, tmp_path: Path) -> None:
    """A second Ctrl-C changes nothing: the vent is confirmed before the run returns."""

    before = signal.getsignal(signal.SIGINT)  # ignored, where the tests run in the background of a shell

    class Impatient(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            yield Actuate((50.0,) * len(rig.channels))
            yield Settle(2.0)
            if fake.pressure.world.commands:
                fake.clock.on_sleep = lambda: signal.raise_signal(signal.SIGINT)
            yield Settle(1.0)

    with pytest.raises(
        Interrupted, match="stopped by Ctrl-C after 2 steps and 0 captures; the chambers are vented"
    ):
        run(Impatient(), fake.rig, tmp_path / "run", fake.clock)
    assert np.abs(fake.pressure_kpa).max() <= VENTED_KPA
    assert signal.getsignal(signal.SIGINT) is before


def test_a_procedure_cannot_swallow_ctrl_c(fake: Any, tmp_path: Path) -> None:
    """Even one that catches everything is stopped at its next step."""

    class Stubborn(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            yield Actuate((50.0,) * len(rig.channels))
            try:
                if fake.pressure.world.commands:
                    signal.raise_signal(signal.SIGINT)
            except BaseException:
                yield Settle(100.0)
            yield Settle(1.0)

    with pytest.raises(
        Interrupted, match="stopped by Ctrl-C after 1 step and 0 captures; the chambers are vented"
    ):
        run(Stubborn(), fake.rig, tmp_path / "run", fake.clock)
    assert np.abs(fake.pressure_kpa).max() <= VENTED_KPA


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="POSIX only")
def test_a_run_under_nohup_outlives_its_terminal(fake: Any, tmp_path: Path) -> None:
    """Who starts a run with SIGHUP ignored goes home: closing the terminal does not end it."""

    class Night(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            yield Actuate((50.0,) * len(rig.channels))
            if fake.pressure.world.commands:
                signal.raise_signal(signal.SIGHUP)
            yield Settle(3.0)
            yield Record(1.0)

    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        run(Night(), fake.rig, tmp_path / "run", fake.clock)
    finally:
        signal.signal(signal.SIGHUP, before)


def test_ctrl_c_in_progress_is_said_once(fake: Any, tmp_path: Path) -> None:
    """A function that watches may end the run: one line says by what it was stopped, and after how much."""

    def enough(progress: Progress) -> None:
        raise KeyboardInterrupt

    with pytest.raises(
        Interrupted, match=r"^stopped by progress after \d+ steps? and \d captures?; the chambers"
    ):
        run(Everything(), fake.rig, tmp_path / "run", fake.clock, progress=enough)
    assert summarise(tmp_path / "run").state == "stopped by progress"
    assert np.abs(fake.pressure_kpa).max() <= 0.5
