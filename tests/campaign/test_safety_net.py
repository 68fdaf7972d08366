"""Signals wait for what must not be broken off, and what the rig says is believed only as far as it should be."""

import signal
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig import open_run
from labrig.campaign import Actuate, Interrupted, Procedure, Record, RigInfo, Scan, Settle, Steps, Vent, run
from labrig.log import LogWriter, summarise
from labrig_drivers import DeviceError, PressureSample


class Twice(Procedure):
    """Every kind of step that moves or writes something, twice."""

    def steps(self, rig: RigInfo) -> Steps:
        """Up, and a vent between."""
        for _ in range(2):
            yield Actuate((40.0, 30.0))
            yield Settle(1.0)
            yield Record(0.5)
            yield Scan()
            yield Vent()


class Bracket:
    """Stands in for a method: sends a signal in its middle, once, and knows whether its end was reached."""

    def __init__(self, original: Callable[..., Any], now: Callable[[], bool]) -> None:
        self.original, self.now = original, now
        self.began = self.ended = self.sent = 0

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """The method, with a signal after its first half."""
        self.began += 1
        if not self.sent and self.now():
            self.sent += 1
            signal.raise_signal(signal.SIGINT)
        result = self.original(*arguments, **named)
        self.ended += 1
        return result


def _under_pressure(fake: Any) -> bool:
    return bool(np.abs(fake.pressure_kpa).max() > 2.0)


@pytest.mark.parametrize("method", ["write", "measured", "frame", "command", "step_done"])
def test_a_signal_waits_for_a_write(
    fake: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, method: str
) -> None:
    """Ctrl-C in the middle of a record: the record is written to its end, then the run stops and is vented."""
    bracket = Bracket(getattr(LogWriter, method), lambda: _under_pressure(fake))
    monkeypatch.setattr(LogWriter, method, lambda writer, *a, **k: bracket(writer, *a, **k))
    with pytest.raises(Interrupted):
        run(Twice(), fake.rig, tmp_path / "run", fake.clock)
    assert bracket.sent == 1
    assert bracket.ended == bracket.began
    assert np.abs(fake.pressure_kpa).max() <= 0.5
    (ended,) = open_run(tmp_path / "run").attrs["warnings"]  # and nothing of a log that is damaged
    assert "stopped by Ctrl-C" in ended


@pytest.mark.parametrize(
    ("device", "method"),
    [("pressure", "vent"), ("pressure", "set"), ("pressure", "samples"), ("mocap", "frames")],
)
def test_a_signal_waits_for_a_device(
    fake: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, device: str, method: str
) -> None:
    """Ctrl-C in the middle of a vent or of a command: it is carried out to its end, and only then the run stops."""
    bracket = Bracket(getattr(getattr(fake, device), method), lambda: _under_pressure(fake))
    monkeypatch.setattr(getattr(fake, device), method, bracket)
    with pytest.raises(Interrupted):
        run(Twice(), fake.rig, tmp_path / "run", fake.clock)
    assert bracket.sent == 1
    assert bracket.ended == bracket.began
    assert np.abs(fake.pressure_kpa).max() <= 0.5


def test_a_signal_waits_for_the_last_vent_of_a_run_that_ends_well(
    fake: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C when everything is done stops nothing: the vent is confirmed, the log is closed, and then it is heard."""
    steps_left = [True]

    class Ends(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            yield Actuate((40.0, 30.0))
            yield Settle(2.0)
            steps_left[0] = not fake.pressure.world.commands

    bracket = Bracket(fake.pressure.vent, lambda: not steps_left[0])
    monkeypatch.setattr(fake.pressure, "vent", bracket)
    with pytest.raises(Interrupted, match="stopped by Ctrl-C after 2 steps"):
        run(Ends(), fake.rig, tmp_path / "run", fake.clock)
    assert (bracket.sent, bracket.ended) == (1, bracket.began)
    assert np.abs(fake.pressure_kpa).max() <= 0.5
    assert open_run(tmp_path / "run").attrs["warnings"] == []
    assert summarise(tmp_path / "run").state == "completed"


def test_a_drivers_own_fault_does_not_end_the_last_vent(
    fake: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An exception that no driver should raise, in the middle of the vent: it is tried again until confirmed."""
    original, faults = fake.pressure.vent, [ValueError("a fault of the driver"), TypeError("another")]

    def vent(timeout_s: float = 10.0) -> Any:
        if _under_pressure(fake) and faults:
            raise faults.pop()
        return original(timeout_s)

    class Up(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            yield Actuate((40.0, 30.0))
            yield Settle(2.0)

    monkeypatch.setattr(fake.pressure, "vent", vent)
    run(Up(), fake.rig, tmp_path / "run", fake.clock)
    assert faults == []
    assert np.abs(fake.pressure_kpa).max() <= 0.5


@pytest.mark.parametrize(
    ("reading_kpa", "text"),
    [
        (66.0, "c1 reads 66.0 kPa, more than 5 kPa above its limit of 60 kPa"),
        (-26.0, "c1 reads -26.0 kPa, more than 5 kPa below its limit of -20 kPa"),
    ],
)
def test_one_sample_outside_the_limits_is_seen_among_others(
    make_rig: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reading_kpa: float, text: str
) -> None:
    """Above or below: each sample counts, not only the newest of those that come together."""
    rig = make_rig(chambers=[{"name": name, "min_kpa": -20, "max_kpa": 60} for name in ("c1", "c2")])
    original = rig.pressure.samples

    def samples() -> list[PressureSample]:
        calm = original()
        if not calm or not _under_pressure(rig):
            return calm
        return [PressureSample(calm[0].time_s, np.array([reading_kpa, 0.0])), *calm]

    monkeypatch.setattr(rig.pressure, "samples", samples)
    with pytest.raises(DeviceError) as caught:
        run(Twice(), rig.rig, tmp_path / "run", rig.clock)
    assert str(caught.value).startswith(f"pressure: {text}")
    assert np.abs(rig.pressure_kpa).max() <= 0.5


@pytest.mark.parametrize("left_kpa", [8.0, -8.0])
def test_no_run_begins_on_a_chamber_that_is_not_at_ambient(
    make_rig: Any, tmp_path: Path, left_kpa: float
) -> None:
    """The preflight refuses pressure and vacuum alike, where it comes back after a confirmed vent."""
    rig = make_rig(chambers=[{"name": name, "min_kpa": -40, "max_kpa": 60} for name in ("c1", "c2")])
    rig.pressure.faults["creep_kpa"] = left_kpa
    with pytest.raises(DeviceError) as caught:
        run(Twice(), rig.rig, tmp_path / "run", rig.clock)
    assert str(caught.value).startswith(
        f"pressure: c1 reads {left_kpa:.1f} kPa although it is vented (more than 3 kPa); check its sensor and valve"
    )
    assert {command for _, command in rig.pressure.world.commands} == {(0.0, 0.0)}


def test_after_a_vent_a_ramp_begins_at_ambient(make_rig: Any, tmp_path: Path) -> None:
    """The slew limit is kept on the way up from a vent, too: the set-points from before it are forgotten."""
    rig = make_rig(chambers=[{"name": name, "max_kpa": 60, "slew_kpa_s": 20} for name in ("c1", "c2")])
    run(Twice(), rig.rig, tmp_path / "run", rig.clock)
    commands = rig.pressure.world.commands
    assert sum(after == (40.0, 30.0) != before for (_, before), (_, after) in pairwise(commands)) == 2
    for (before_s, before), (after_s, after) in pairwise(commands):
        reach_kpa = 20 * max(after_s - before_s, 0.05) if any(before) else 20 * 0.05
        assert max(np.subtract(after, before)) <= reach_kpa + 1e-9
