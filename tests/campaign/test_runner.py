"""The runner: limits before anything moves, the whole hold in the log, pauses and observers."""

import signal
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
import yaml

from labrig import LabrigError, open_run
from labrig.campaign import (
    Actuate,
    Completed,
    Control,
    Note,
    Observer,
    Procedure,
    Progress,
    Record,
    RigInfo,
    Scan,
    Settle,
    Steps,
    Vent,
    Watching,
    dry_run,
    read_completed,
    run,
)
from labrig.log import summarise


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


class Wrong(Procedure):
    """Asks for more than the chambers bear."""

    def steps(self, rig: RigInfo) -> Steps:
        """The second step is the bad one."""
        yield Actuate((60.0, 0.0))
        yield Actuate((0.0, 60.5))
        yield Actuate((-1.0, float("nan")))
        yield Actuate((1.0,))


def test_broken_limits_are_all_found_before_anything_moves(fake: Any, tmp_path: Path, config: Any) -> None:
    """The plan names each step and limit; the run refuses it, and the chambers never heard of it."""
    plan = dry_run(Wrong(), config)
    assert plan.broken == [
        "step 1 (actuate): c2 60.5 kPa is above its limit of 60 kPa",
        "step 2 (actuate): c1 -1 kPa is below its limit of 0 kPa",
        "step 2 (actuate): c2 nan kPa is not a number",
        "step 3 (actuate): 1 pressures for 2 chambers",
    ]
    with pytest.raises(LabrigError) as caught:
        run(Wrong(), fake.rig, tmp_path / "run", fake.clock)
    assert str(caught.value) == (
        "nothing was moved: step 1 (actuate): c2 60.5 kPa is above its limit of 60 kPa (and 3 more)"
    )
    assert fake.pressure.world.commands == []
    assert not (tmp_path / "run").exists()


def test_a_closed_loop_is_checked_step_by_step(fake: Any, tmp_path: Path) -> None:
    """A limit that only shows in the run stops it before the step moves anything."""

    class Greedy(Closed):
        def steps(self, rig: RigInfo) -> Steps:
            yield Actuate((50.0, 50.0))
            yield Settle(2.0)
            recording = yield Record(0.5)
            yield Actuate((50.0 + 4 * recording.mean_mm[0, 2], 50.0))

    with pytest.raises(
        LabrigError, match=r"^step 3 \(actuate\): c1 \d+\.\d+ kPa is above its limit of 60 kPa"
    ):
        run(Greedy(target_mm=9.0), fake.rig, tmp_path / "run", fake.clock)
    assert max(command[1][0] for command in fake.pressure.world.commands) == 50.0
    assert np.abs(fake.pressure_kpa).max() <= 0.5


def test_the_plan_says_how_long_it_takes(config: Any, fake: Any, tmp_path: Path) -> None:
    """The estimate of the dry run is what the run takes on the same clock, to a tenth."""
    plan = dry_run(Three(), config)
    assert [step.kind for step in plan.steps] == ["actuate", "settle", "record", "record"] * 3
    assert plan.captures == 6
    start_s = fake.clock.now_s()
    run(Three(), fake.rig, tmp_path / "run", fake.clock)
    assert plan.duration_s == pytest.approx(fake.clock.now_s() - start_s, abs=3.5)  # and two vents
    assert plan.duration_s == pytest.approx(7.5, abs=0.6)


def test_the_whole_hold_is_logged(fake: Any, tmp_path: Path) -> None:
    """Frames from the actuation on; a second recording of a hold begins where the first ended."""
    run(Three(), fake.rig, tmp_path / "run", fake.clock)
    data = open_run(tmp_path / "run")
    assert data.sizes["capture"] == 6
    assert float(data["hold_s"][0, 0]) < 0.2
    assert float(data["hold_s"][1, 0]) > float(data["hold_s"][0].max())
    assert data["event_of"].to_numpy().tolist() == [1, 1, 2, 2, 3, 3]
    assert data["repeat"].to_numpy().tolist() == ["r", "", "r", "", "", ""]
    assert data["commanded"].to_numpy()[::2].tolist() == [[10.0, 10.0], [20.0, 10.0], [40.0, 10.0]]
    assert data["event_commanded"].to_numpy()[[0, -1]].tolist() == [[0.0, 0.0]] * 2
    assert not bool(data["settled"][0, 0])
    first = data["settled"][0].to_numpy().astype(bool)
    assert data["hold_s"][0].to_numpy()[first].min() == pytest.approx(1.15, abs=0.15)
    lift = data["position_mm"][0].to_numpy()[first][:, 0, 2]
    assert lift == pytest.approx(2.0, abs=0.3)
    assert np.isnan(data["position_mm"][0].to_numpy()[:, 2, 0]).any()


def test_slew_limits_are_kept_on_the_way(make_rig: Callable[..., Any], tmp_path: Path) -> None:
    """No command is further from the one before than the slew limit allows in the time between."""
    slow = make_rig(chambers=[{"name": "c1", "max_kpa": 60, "slew_kpa_s": 20}, {"name": "c2", "max_kpa": 60}])
    run(Three(), slow.rig, tmp_path / "run", slow.clock)
    commands = [c for c in slow.pressure.world.commands if any(c[1])]
    for (before_s, before), (after_s, after) in pairwise(commands):
        assert abs(after[0] - before[0]) <= 20 * max(after_s - before_s, 0.05) + 1e-9
        assert abs(after[1] - before[1]) <= 100 * max(after_s - before_s, 0.05) + 1e-9
    assert commands[-1][1] == (40.0, 10.0)


def test_stillness_is_measured(fake: Any, tmp_path: Path) -> None:
    """The speed at the end of the settle is the world's, and falls with longer waits."""
    speeds = []

    class Waits(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            for wait_s in (1.0, 2.0, 3.0):
                yield Vent()
                yield Actuate((50.0, 50.0))
                speeds.append((yield Settle(wait_s)))

    run(Waits(), fake.rig, tmp_path / "run", fake.clock)
    measured = [settled.speed_mm_s for settled in speeds[3:]]  # the first three are the dry run's
    assert measured == sorted(measured, reverse=True)
    assert measured[0] == pytest.approx(10.0 / 0.5 * np.exp(-0.75 / 0.5), rel=0.5)
    assert speeds[3].pressure_error_kpa > speeds[5].pressure_error_kpa


class _Log(Observer):
    def __init__(self) -> None:
        self.calls: list[tuple[str, Any]] = []

    def started(self, rig: RigInfo, rest_mm: Any) -> None:
        self.calls.append(("started", rig.name))

    def step_done(self, completed: Completed) -> None:
        self.calls.append(("done", completed.step.kind))

    def event(self, time_s: float, text: str, level: str) -> None:
        self.calls.append((level, text))

    def finished(self, reason: str) -> None:
        self.calls.append(("finished", reason))


def test_observers_hear_of_every_step_in_order(fake: Any, tmp_path: Path) -> None:
    """From the start to the reason of the end."""
    log, progress = _Log(), []
    run(Three(), fake.rig, tmp_path / "run", fake.clock, 0, progress.append, Watching([log]))
    kinds = ["actuate", "settle", "record", "record"] * 3
    assert log.calls == [
        ("started", "fake"),
        ("INFO", "three begins: 12 steps"),
        *(("done", kind) for kind in kinds),
        ("INFO", "completed"),
        ("finished", "completed"),
    ]
    last: Progress = progress[-1]
    assert (last.steps_done, last.steps, last.captures_done, last.captures) == (12, 12, 6, 6)
    assert last.remaining_s == pytest.approx(0.0, abs=0.1)
    assert str(last) == "6 of 6 captures, 12 of 12 steps done (record), 0 s left"
    remaining = [item.remaining_s for item in progress]
    assert all(later <= earlier + 0.3 for earlier, later in pairwise(remaining))


def test_a_pause_vents_and_goes_on(fake: Any, tmp_path: Path) -> None:
    """The hold is finished first; during the pause the chambers are vented; no capture is lost."""
    control = Control()
    held: list[float] = []

    def going_on() -> None:
        if (
            control.paused
            and fake.pressure.world.commands[-1][1] == (0.0, 0.0)
            and not np.any(fake.pressure_kpa > 0.5)
        ):
            held.append(float(np.abs(fake.pressure_kpa).max()))
            control.go_on()

    class Pauses(Three):
        def steps(self, rig: RigInfo) -> Steps:
            for number, step in enumerate(super().steps(rig)):
                if number == 2 and fake.pressure.world.commands:
                    control.pause()
                yield step

    fake.clock.on_sleep = going_on
    run(Pauses(), fake.rig, tmp_path / "run", fake.clock, watching=Watching(control=control))
    assert held
    assert held[0] < 0.5
    data = open_run(tmp_path / "run")
    assert data.sizes["capture"] == 6
    assert [0.0, 0.0] in data["event_commanded"].to_numpy()[1:-1].tolist()


@pytest.mark.skipif(not hasattr(signal, "SIGUSR1"), reason="POSIX only; on Windows a key does it")
def test_a_signal_pauses_and_another_goes_on(fake: Any, tmp_path: Path) -> None:
    """SIGUSR1 before the second hold: vented until it comes again."""
    seen: list[float] = []

    class Signalled(Three):
        def steps(self, rig: RigInfo) -> Steps:
            for number, step in enumerate(super().steps(rig)):
                if number == 4 and fake.pressure.world.commands:
                    signal.raise_signal(signal.SIGUSR1)
                yield step

    def look() -> None:
        if signal.getsignal(signal.SIGUSR1) is not signal.SIG_DFL and paused():
            seen.append(float(np.abs(fake.pressure_kpa).max()))
            if len(seen) == 80:
                signal.raise_signal(signal.SIGUSR1)

    def paused() -> bool:
        return control.paused

    control = Control()
    fake.clock.on_sleep = look
    run(Signalled(), fake.rig, tmp_path / "run", fake.clock, watching=Watching(control=control))
    assert seen[-1] < 0.5
    assert not control.paused
    assert open_run(tmp_path / "run").sizes["capture"] == 6


def test_a_gap_in_motion_capture_repeats_the_recording(fake: Any, tmp_path: Path) -> None:
    """A recording in which no frame arrived is made again once frames are back; none is empty."""
    gap: list[float] = []

    class Gap(Three):
        def steps(self, rig: RigInfo) -> Steps:
            for number, step in enumerate(super().steps(rig)):
                if number == 6 and fake.pressure.world.commands:
                    gap.append(fake.clock.now_s())
                    fake.mocap.faults["lost"] = True
                yield step

    def back() -> None:
        if gap and fake.clock.now_s() > gap[0] + 5.0:
            fake.mocap.faults.clear()

    fake.clock.on_sleep = back
    run(Gap(), fake.rig, tmp_path / "run", fake.clock)
    data = open_run(tmp_path / "run")
    assert data.sizes["capture"] == 6
    settled = data["settled"].to_numpy()
    assert settled.sum(axis=1).min() >= 9
    recordings = [done.result for done in read_completed(tmp_path / "run") if isinstance(done.step, Record)]
    assert all(len(recording.time_s) >= 9 for recording in recordings)  # type: ignore[union-attr]


@pytest.mark.parametrize(("thinned", "lost"), [(1, 0.0), (4, 0.75)])
def test_frames_that_are_lost_are_counted(thinned: int, lost: float, fake: Any, tmp_path: Path) -> None:
    """A network that loses frames is seen by their numbers: in each recording, and in words, once."""
    log = _Log()
    fake.mocap.faults["thinned"] = thinned
    run(Three(), fake.rig, tmp_path / "run", fake.clock, watching=Watching([log]))
    summary = summarise(tmp_path / "run")
    assert summary.frames_lost / (summary.frames + summary.frames_lost) == pytest.approx(lost, abs=0.1)
    said = [text for level, text in log.calls if level == "WARNING"]
    assert [text.partition(" frames were")[0] for text in said] == (["6 of 9"] if lost else [])


def test_a_run_needs_a_folder_of_its_own(fake: Any, tmp_path: Path) -> None:
    """A second run is not written into the first one's folder."""
    run(Three(), fake.rig, tmp_path / "run", fake.clock)
    with pytest.raises(LabrigError) as caught:
        run(Three(), fake.rig, tmp_path / "run", fake.clock)
    assert str(caught.value) == f"{tmp_path / 'run'} holds a run already; choose another folder, or resume it"


def test_a_rig_without_motion_capture_records_its_pressures(
    make_rig: Callable[..., Any], tmp_path: Path
) -> None:
    """The rows are then those of the pressure sensors."""
    blind = make_rig(markers=[], mocap=None)
    run(Three(), blind.rig, tmp_path / "run", blind.clock)
    data = open_run(tmp_path / "run")
    assert data.sizes["capture"] == 6
    assert "position_mm" not in data
    last = data["measured"][5].to_numpy()[data["settled"][5].to_numpy()]
    np.testing.assert_allclose(last[-1], [40.0, 10.0], atol=1.0)


def test_run_yaml_says_what_the_run_is(fake: Any, tmp_path: Path) -> None:
    """Procedure, parameters, seed, rig, identities and versions; the log holds the same."""
    run(Three(top_kpa=30.0), fake.rig, tmp_path / "run", fake.clock, 7)
    facts = yaml.safe_load((tmp_path / "run" / "run.yaml").read_text())
    assert (facts["procedure"], facts["parameters"], facts["seed"]) == ("three", {"top_kpa": 30.0}, 7)
    assert facts["rig"]["chambers"][0]["max_kpa"] == 60.0
    assert facts["identity"]["pressure"] == {
        "kind": "fake",
        "description": "a fake pressure",
        "details": {"version": "1", "port": "A"},
    }
    assert set(facts["versions"]) == {"labrig", "python", "system"}
    assert facts["steps"] == 12


def test_scans_are_kept_with_the_run(fake: Any, tmp_path: Path) -> None:
    """A scanner without files gets a PLY in the run; the result names it and its hash."""

    class Scans(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            yield Scan()
            yield Scan()

    run(Scans(), fake.rig, tmp_path / "run", fake.clock)
    done = read_completed(tmp_path / "run")
    assert [item.result.files for item in done] == [("scans/000/scan.ply",), ("scans/001/scan.ply",)]  # type: ignore[union-attr]
    ply = (tmp_path / "run" / "scans" / "000" / "scan.ply").read_bytes()
    assert b"element vertex 3\n" in ply
    assert np.frombuffer(ply[ply.index(b"end_header\n") + 11 :][:36], "<f4").tolist() == [
        1,
        0,
        0,
        0,
        1,
        0,
        0,
        0,
        1,
    ]


@pytest.mark.parametrize(("limit", "value"), [("SEGMENT_BYTES", 6_000), ("SEGMENT_STEPS", 5)])
def test_a_long_session_is_spread_over_files(
    fake: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limit: str, value: int
) -> None:
    """Segments are closed at a size, or at a number of steps, and read back as one session."""
    run(Three(), fake.rig, tmp_path / "one", fake.clock)
    reference = open_run(tmp_path / "one")
    monkeypatch.setattr(f"labrig.campaign._session.{limit}", value)
    other = _fresh(fake)
    run(Three(), other.rig, tmp_path / "many", other.clock)
    assert len(list((tmp_path / "many").glob("log.*.mcap"))) > 2
    many = open_run(tmp_path / "many")
    assert set(many["session"].to_numpy().tolist()) == {"0"}
    assert many.attrs["warnings"] == []
    assert many.sizes["capture"] == reference.sizes["capture"]
    np.testing.assert_allclose(many["hold_s"], reference["hold_s"], atol=0.06)


def _fresh(fake: Any) -> Any:
    from labrig.rig import connect

    clock = type(fake.clock)()
    return type(fake)(connect(fake.rig.config, clock), clock)
