"""The last message of a run says whether the chambers are vented, whatever ended it; and so does the run's state."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from labrig import LabrigError
from labrig.campaign import Actuate, Observer, Procedure, Record, RigInfo, Settle, Steps, Watching, run
from labrig.log import summarise
from labrig.rig import not_vented
from labrig_drivers import DeviceError, VentNotConfirmedError


class Up(Procedure):
    """Under pressure for a while, one capture."""

    def steps(self, rig: RigInfo) -> Steps:
        """Up, and record."""
        yield Actuate((40.0, 30.0))
        yield Settle(5.0)
        yield Record(0.5)


class Fails(Procedure):
    """Computes its next set-point from what it measured, and gets it wrong on a real rig only."""

    closed_loop: ClassVar[bool] = True
    how: str = ""

    def steps(self, rig: RigInfo) -> Steps:
        """Up, and then the fault."""
        yield Actuate((40.0, 30.0))
        settled = yield Settle(2.0)
        if settled.fastest_mm_s == 0.0:
            return  # the markers of a dry run stand still
        if self.how == "crash":
            raise ZeroDivisionError("a slip")
        if self.how == "no step":
            yield 7  # type: ignore[misc]
        if self.how == "name":
            rig.setpoint(c9=10.0)
        yield Actuate(
            {"high": (99.0, 0.0), "nan": (np.nan, 0.0), "low": (-5.0, 0.0), "count": (1.0,)}.get(self.how, ())
        )


class Ears(Observer):
    """Hears what is said, and when on the run's clock."""

    def __init__(self, clock: Any) -> None:
        self.clock, self.heard, self.reason = clock, [], ""

    def event(self, time_s: float, text: str, level: str) -> None:
        """Keep what a person has to hear."""
        if level == "FATAL":
            self.heard.append((time_s, text))

    def finished(self, reason: str) -> None:
        """Keep how it ended."""
        self.reason = reason


@pytest.mark.parametrize("how", ["crash", "no step", "name", "high", "nan", "low", "count"])
def test_after_any_error_of_a_procedure(fake: Any, tmp_path: Path, how: str) -> None:
    """It says that the chambers are vented, and never that nothing was moved: they were filled before."""
    with pytest.raises(LabrigError) as caught:
        run(Fails(how=how), fake.rig, tmp_path / "run", fake.clock)
    assert str(caught.value).endswith("; the chambers are vented")
    assert "nothing was moved" not in str(caught.value)
    assert fake.pressure_kpa.max() <= 0.5
    assert max(command for _, command in fake.pressure.world.commands) == (40.0, 30.0)


def test_after_a_fault_that_nobody_foresaw(
    fake: Any, labrig: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The exception keeps its kind; what is printed of it says that the chambers are vented."""
    from labrig.cli._complaints import complaint

    def broken(*_: Any, **__: Any) -> None:
        raise RuntimeError("a slip of labrig's own")

    monkeypatch.setattr("labrig.campaign._runner.attempt", broken)
    with pytest.raises(RuntimeError) as caught:
        run(Up(), fake.rig, tmp_path / "run", fake.clock)
    assert complaint(caught.value).startswith(
        "unexpected RuntimeError: a slip of labrig's own; the chambers are vented ("
    )


@pytest.mark.parametrize("fault", ["slow", "never"])
def test_a_vent_that_fails_is_spoken_of_at_once_and_in_the_runs_state(
    fake: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: str
) -> None:
    """A person hears of the first failure while the vent is tried on; a run whose vent fails has not completed."""
    monkeypatch.setattr("labrig.rig._last_words.SLOW_S", 60.0)
    ears = Ears(fake.clock)
    moment: list[float] = []

    class Then(Up):
        def steps(self, rig: RigInfo) -> Steps:
            yield from super().steps(rig)
            if fake.pressure.world.commands:
                moment.append(fake.clock.now_s())
                fake.pressure.faults["never_vents"] = True
                if fault == "slow":
                    fake.clock.on_sleep = heal

    def heal() -> None:
        if fake.clock.now_s() > moment[0] + 20.0:
            fake.pressure.faults.clear()

    watching = Watching([ears])
    if fault == "slow":
        run(Then(), fake.rig, tmp_path / "run", fake.clock, watching=watching)
    else:
        with pytest.raises(
            VentNotConfirmedError, match=r"not vented after 10 s .*; relieve the pressure by hand$"
        ):
            run(Then(), fake.rig, tmp_path / "run", fake.clock, watching=watching)
    told_s, text = ears.heard[0]
    assert text == (
        "pressure: not vented after 10 s (pressures now: c1 0.0 kPa, c2 0.0 kPa); relieve the pressure by hand; "
        "trying again for 60 s"
    )
    assert told_s - moment[0] < 11.0
    summary = summarise(tmp_path / "run")
    assert text in [said for _, said in summary.events]
    assert summary.steps_done == 3
    if fault == "slow":
        assert summary.state == ears.reason == "completed"
    else:
        assert summary.state == ears.reason
        assert summary.state.startswith("NOT VENTED: pressure: not vented after 10 s (pressures now: c1")
        assert summary.state.endswith("; relieve the pressure by hand; everything was measured")


def test_a_vent_that_hangs_is_spoken_of(fake: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before it has failed, too: a person need not wait for the end of its time limit."""
    import threading

    heard = threading.Event()
    monkeypatch.setattr("labrig.rig._last_words.SLOW_S", 0.02)
    original = fake.pressure.vent

    class Hears(Observer):
        def event(self, time_s: float, text: str, level: str) -> None:
            if "is not confirmed after" in text and "relieve the pressure by hand if you can" in text:
                assert text.endswith(" (pressures before it: c1 40.0 kPa, c2 30.0 kPa)")
                heard.set()

    def slow(timeout_s: float) -> Any:
        if fake.pressure_kpa.max() > 20.0:
            assert heard.wait(30.0)
        return original(timeout_s)

    monkeypatch.setattr(fake.pressure, "vent", slow)
    run(Up(), fake.rig, tmp_path / "run", fake.clock, watching=Watching([Hears()]))
    assert heard.is_set()


def _raise(error: BaseException) -> Callable[[], None]:
    def act() -> None:
        raise error

    return act


class _TwoPartError(LabrigError):
    """An error that is made of more than its text, as that of an effect is."""

    def __init__(self, text: str, effect: str) -> None:
        super().__init__(text)
        self.effect = effect


@pytest.mark.parametrize(
    ("fails", "error", "kind", "text"),
    [
        (False, _TwoPartError("a slip", "mine"), _TwoPartError, "a slip; the chambers are vented"),
        (False, LabrigError("a slip"), LabrigError, "a slip; the chambers are vented"),
        (False, DeviceError("x; the chambers are vented"), DeviceError, "x; the chambers are vented"),
        (
            False,
            VentNotConfirmedError("stuck; relieve the pressure by hand"),
            DeviceError,
            "stuck; a later vent was confirmed: the chambers are vented",
        ),
        (
            True,
            LabrigError("a slip"),
            VentNotConfirmedError,
            "pressure: the link is lost (pressures 0 s ago: c1 0.0 kPa, c2 0.0 kPa); relieve the pressure by hand; "
            "the run had ended because: a slip",
        ),
        (True, VentNotConfirmedError("stuck"), VentNotConfirmedError, "stuck"),
    ],
)
def test_leaving_a_rig_says_it_too(
    fake: Any, fails: bool, error: Exception, kind: type[Exception], text: str
) -> None:
    """What goes wrong before a run has begun or after it has ended is told with the vent that follows it."""
    fake.clock.sleep(0.1)
    fake.pressure.samples()
    if fails:
        fake.pressure.faults["lost_until_s"] = np.inf
    with pytest.raises(kind) as caught, fake.rig:
        _raise(error)()
    assert str(caught.value) == text
    assert type(caught.value) is kind
    assert fake.pressure.closed


def test_what_ended_the_run_is_not_said_twice() -> None:
    """Where the vent fails for the same reason that the run did."""
    assert str(not_vented(VentNotConfirmedError("stuck"), DeviceError("stuck"))) == (
        "stuck; relieve the pressure by hand"
    )
    assert str(not_vented(DeviceError("lost"), DeviceError("over"))) == (
        "lost; the vent is not confirmed; relieve the pressure by hand; the run had ended because: over"
    )
