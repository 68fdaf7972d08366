"""A run that was interrupted goes on where it stopped: completed steps are replayed from the log."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest

from labrig import LabrigError, open_run
from labrig.campaign import (
    Actuate,
    Note,
    Procedure,
    Record,
    RigInfo,
    Scan,
    Settle,
    Steps,
    Vent,
    read_completed,
    resume,
    run,
)
from labrig.campaign._replay import _during
from labrig.campaign._runfile import _same, check_resumable
from labrig.log import Series
from tests.campaign.stopping import stop_after


class Three(Procedure):
    """Three captures, each in two parts."""

    top_kpa: float = 40.0

    def steps(self, rig: RigInfo) -> Steps:
        """Up and up."""
        for share in (0.25, 0.5, 1.0):
            yield Actuate((share * self.top_kpa, 10.0))
            yield Settle(1.0)
            yield Record(0.5, repeat="r" if share < 1 else "")
            yield Record(1.0)


class Closed(Procedure):
    """Raises the pressure until a marker has moved far enough: the steps depend on what was measured."""

    closed_loop: ClassVar[bool] = True
    target_mm: float = 6.0

    def steps(self, rig: RigInfo) -> Steps:
        """A secant, with whatever noise the measurement has."""
        pressure_kpa, seen = 10.0, []
        for _ in range(6):
            yield Actuate((pressure_kpa, pressure_kpa))
            settled = yield Settle(1.0)
            recording = yield Record(0.5)
            lift_mm = float(recording.mean_mm[0, 2]) + 0.01 * float(np.tanh(settled.speed_mm_s))
            seen.append(lift_mm)
            pressure_kpa = min(60.0, pressure_kpa * (1 + 0.5 * (self.target_mm / lift_mm - 1)))
            yield Note(f"{lift_mm!r} {float(recording.time_s[0])!r} {len(recording.pressure_kpa)}")


def _interrupt_after(fake: Any, steps: int, procedure: Procedure, folder: Path) -> None:
    """Run and stop with Ctrl-C once so many steps are done."""
    stop_after(steps, lambda: run(procedure, fake.rig, folder, fake.clock))


@pytest.mark.parametrize("steps", [1, 2, 3, 4, 5, 7, 11])
def test_a_resumed_run_has_every_capture_once(
    make_rig: Callable[..., Any], tmp_path: Path, steps: int
) -> None:
    """Whatever was completed is kept, the rest is done, and nothing is done twice."""
    first, second = make_rig(), make_rig()
    folder = tmp_path / "run"
    _interrupt_after(first, steps, Three(), folder)
    kept = len(read_completed(folder))
    assert kept == steps
    second.clock.sleep(first.clock.now_s() + 100 - second.clock.now_s())
    resume(Three(), second.rig, folder, second.clock)
    assert [done.index for done in read_completed(folder)] == list(range(12))
    data = open_run(folder)
    assert data.sizes["capture"] == 6
    assert data["commanded"][:, 0].to_numpy().tolist() == [10.0, 10.0, 20.0, 20.0, 40.0, 40.0]
    assert sorted(set(data["session"].to_numpy().tolist())) == (["0", "1"] if steps > 2 else ["1"])
    assert np.abs(second.pressure_kpa).max() <= 0.5


def test_a_hold_that_was_broken_off_is_restored(make_rig: Callable[..., Any], tmp_path: Path) -> None:
    """Resumed in the middle of a hold: the set-point before and the present one are held again as long."""
    first, second = make_rig(), make_rig()
    folder = tmp_path / "run"
    _interrupt_after(first, 7, Three(), folder)  # the second hold's first recording is done
    resume(Three(), second.rig, folder, second.clock)
    data = open_run(folder)
    mine = data["event_session"].to_numpy() == "1"
    assert data["event_commanded"].to_numpy()[mine].tolist() == [
        [0.0, 0.0],
        [10.0, 10.0],
        [20.0, 10.0],
        [40.0, 10.0],
        [0.0, 0.0],
    ]
    times = data["event_time_s"].to_numpy()[mine]
    assert np.diff(times)[1] == pytest.approx(2.5 + 0.1, abs=0.15)
    resumed = data.isel(capture=3)
    settled = resumed["settled"].to_numpy()
    assert float(resumed["hold_s"].to_numpy()[settled].min()) == pytest.approx(1.0 + 0.5 + 0.1, abs=0.2)


def test_a_closed_loop_is_resumed_with_exactly_what_it_was_given(
    make_rig: Callable[..., Any], tmp_path: Path
) -> None:
    """The replayed results are those of the first session, to the last bit: the notes say so."""
    first, second, whole = make_rig(), make_rig(), make_rig()
    run(Closed(), whole.rig, tmp_path / "whole", whole.clock)
    _interrupt_after(first, 11, Closed(), tmp_path / "run")
    before = [done.step for done in read_completed(tmp_path / "run")]
    resume(Closed(), second.rig, tmp_path / "run", second.clock)
    after = [done.step for done in read_completed(tmp_path / "run")]
    assert after[:11] == before
    assert len(after) == 24
    reference = [done.step for done in read_completed(tmp_path / "whole")]
    assert after[:12] == reference[:12]


@pytest.mark.parametrize("step_s", [0.0, 0.0625])
def test_the_results_of_a_replay_are_those_of_the_run(
    fake: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step_s: float
) -> None:
    """Recordings, settles and the others come back from the log equal to what the procedure got, also where a clock in
    coarse steps gives many frames one time.
    """
    given: list[Any] = []
    for device, method in ((fake.mocap._device, "frames"), (fake.rig.pressure._device, "samples")):
        monkeypatch.setattr(device, method, _in_steps(getattr(device, method), step_s))

    class Everything(Procedure):
        closed_loop: ClassVar[bool] = True

        def steps(self, rig: RigInfo) -> Steps:
            for step in (
                Actuate((20.0, 5.0)),
                Settle(1.0),
                Record(0.5),
                Scan(),
                Note("x"),
                Vent(),
                Record(0.2),
            ):
                given.append((yield step))

    run(Everything(), fake.rig, tmp_path / "run", fake.clock)
    for done, result in zip(read_completed(tmp_path / "run"), given[7:], strict=True):
        assert type(done.result) is type(result)
        if isinstance(done.step, Record):
            for name, value in vars(result).items():
                np.testing.assert_array_equal(getattr(done.result, name), value)
            assert (np.diff(result.time_s) > 0).all()
            assert (np.diff(result.pressure_time_s) > 0).all()
        else:
            assert done.result == result


def _in_steps(measure: Any, step_s: float) -> Any:
    """The same measurements, dated by a clock that moves in steps."""

    def coarse() -> list[Any]:
        return [replace(each, time_s=each.time_s // step_s * step_s) for each in measure()]

    return coarse if step_s else measure


def test_of_an_older_log_the_recording_is_found_among_equal_times() -> None:
    """What came after a recording with its last time, or before it with its first, is none of it."""
    series = Series(np.array([10, 10, 20, 30, 30, 40]), np.arange(6.0))
    for span, count, found in (
        ([20, 30], 2, [2, 3]),
        ([10, 20], 2, [1, 2]),
        ([20, 40], 4, [2, 3, 4, 5]),
        ([20, 40], 9, [2, 3, 4, 5]),
        (None, 0, []),
    ):
        assert _during(series, span, count).values.tolist() == found


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (
            {"procedure": Three(top_kpa=41.0)},
            "the parameters changed (top_kpa was 40.0, now it is 41.0); start a new run",
        ),
        (
            {"rig": {"chambers": [{"name": "c1", "max_kpa": 60}, {"name": "c2", "max_kpa": 55}]}},
            "the limits of the chambers changed "
            "({'name': 'c2', 'min_kpa': 0.0, 'max_kpa': 60.0, 'slew_kpa_s': 100.0} became "
            "{'name': 'c2', 'min_kpa': 0.0, 'max_kpa': 55.0, 'slew_kpa_s': 100.0}); start a new run",
        ),
        (
            {"mocap": {"unit": "m", "timeout_s": 9.0}},
            "the mocap section of the rig changed (unit was not there, now it is 'm'); start a new run",
        ),
        ({"rig": {"name": "other"}}, "the rig changed ('fake' became 'other'); start a new run"),
        (
            {"rig": {"markers": ["m1", "m2"]}},
            "the markers changed (['m1', 'm2', 'm3'] became ['m1', 'm2']); start a new run",
        ),
    ],
)
def test_a_changed_plan_or_rig_is_refused(
    make_rig: Callable[..., Any], tmp_path: Path, changed: dict[str, Any], message: str
) -> None:
    """The reason is said, and nothing moves."""
    first, second = make_rig(), make_rig(**changed.get("rig", {}))
    folder = tmp_path / "run"
    _interrupt_after(first, 5, Three(), folder)
    if options := changed.get("mocap"):
        mocap = second.rig.config.mocap.model_copy(update=options)
        second.rig.config = second.rig.config.model_copy(update={"mocap": mocap})
    with pytest.raises(LabrigError) as caught:
        resume(changed.get("procedure", Three()), second.rig, folder, second.clock)
    assert str(caught.value) == f"cannot resume {folder}: {message}"
    assert second.pressure.world.commands == []


def test_a_simulated_rig_with_another_seed_is_another_rig(tmp_path: Path) -> None:
    """Its second session would be of another surface; what is simulated in no device may change."""

    def facts(kind: str, seed: int) -> dict[str, Any]:
        rig = {"name": "r", "pressure": {"kind": kind}, "simulated": {"surface": "membrane", "seed": seed}}
        return {"procedure": "p", "parameters": {}, "seed": 0, "steps_sha256": "", "identity": {}, "rig": rig}

    check_resumable(tmp_path, facts("openpneu", 1), facts("openpneu", 2))
    with pytest.raises(
        LabrigError, match=r"simulated section of the rig changed \(seed was 1, now it is 2\)"
    ):
        check_resumable(tmp_path, facts("simulated", 1), facts("simulated", 2))


def test_a_procedure_whose_steps_changed_is_refused(make_rig: Callable[..., Any], tmp_path: Path) -> None:
    """The same name and parameters, but other steps: an edited procedure file."""
    first, second = make_rig(), make_rig()
    folder = tmp_path / "run"
    _interrupt_after(first, 5, Three(), folder)
    edited = type("Three", (Three,), {"steps": lambda self, rig: (step for step in [Vent()])})
    with pytest.raises(LabrigError) as caught:
        resume(edited(), second.rig, folder, second.clock)
    assert str(caught.value) == (
        f"cannot resume {folder}: procedure three no longer makes the steps that it made when the run began; "
        "start a new run"
    )


def test_a_full_disk_is_said_before_a_resumed_run_fills_the_chambers(
    make_rig: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run that ended since the disk was full ends again only once there is room: nothing moves until then."""
    first, second = make_rig(), make_rig()
    folder = tmp_path / "run"
    _interrupt_after(first, 5, Three(), folder)
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=1_000_000))
    with pytest.raises(LabrigError, match="1 MB are free, and this run may need"):
        resume(Three(), second.rig, folder, second.clock)
    assert second.pressure.world.commands == []


def test_a_complete_run_is_not_resumed(make_rig: Callable[..., Any], tmp_path: Path) -> None:
    """There is nothing left to do."""
    first, second = make_rig(), make_rig()
    run(Three(), first.rig, tmp_path / "run", first.clock)
    with pytest.raises(LabrigError) as caught:
        resume(Three(), second.rig, tmp_path / "run", second.clock)
    assert str(caught.value) == f"{tmp_path / 'run'} is complete: all 12 steps are done"


def test_a_cut_log_is_resumed_from_what_is_whole(make_rig: Callable[..., Any], tmp_path: Path) -> None:
    """A power cut in the middle of a chunk costs the step that was not durable yet, no more."""
    first, second = make_rig(), make_rig()
    folder = tmp_path / "run"
    _interrupt_after(first, 8, Three(), folder)
    log = folder / "log.000.mcap"
    whole = log.read_bytes()
    cut = len(whole)
    while len(read_completed(folder)) > 5:
        cut -= 500
        log.write_bytes(whole[:cut])
    resume(Three(), second.rig, folder, second.clock)
    assert open_run(folder).sizes["capture"] == 6
    assert log.stat().st_size == cut


def test_another_device_is_refused_but_another_port_is_not(
    make_rig: Callable[..., Any], tmp_path: Path
) -> None:
    """A board that is found at another port after a power cut is the same board; another version is not."""
    folder = tmp_path / "run"
    _interrupt_after(make_rig(), 5, Three(), folder)
    other = make_rig()
    identity = other.rig.identity["pressure"]
    other.rig.identity["pressure"] = replace(identity, details={"version": "2", "port": "A"})
    with pytest.raises(LabrigError) as caught:
        resume(Three(), other.rig, folder, other.clock)
    assert str(caught.value) == (
        f"cannot resume {folder}: the devices changed (pressure was 'fake 1', now it is 'fake 2'); start a new run"
    )
    moved = make_rig()
    moved.rig.identity["pressure"] = replace(
        identity, description="elsewhere", details={"version": "1", "port": "B"}
    )
    resume(Three(), moved.rig, folder, moved.clock)
    assert open_run(folder).sizes["capture"] == 6


def test_a_setting_that_was_nothing_and_is_gone_is_named() -> None:
    """An entry that is null in run.yaml and that the rig does not have any more is a change like any other."""
    with pytest.raises(LabrigError) as caught:
        _same(Path("run"), "rig", {"hose": None, "b": 1}, {"b": 1})
    assert str(caught.value) == (
        "cannot resume run: the rig changed (hose was None, now it is not there); start a new run"
    )
