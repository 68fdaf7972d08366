"""Pressures that do not follow are noticed, said by name, and do not count."""

import math
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig import open_run
from labrig.campaign import (
    Actuate,
    Control,
    Observer,
    Procedure,
    Record,
    Recording,
    RigInfo,
    Settle,
    Steps,
    Tally,
    Watching,
    read_completed,
    run,
)
from labrig.campaign._follow import misses
from labrig.log import load_segments, summarise
from labrig_drivers import DeviceError, PressureSample

NOBODY = Watching()


class Two(Procedure):
    """Two captures at different pressures."""

    sag: bool = False

    def steps(self, rig: RigInfo) -> Steps:
        """Actuate, settle, record, twice."""
        for pressure_kpa in (20.0, 40.0):
            yield Actuate((pressure_kpa, 10.0))
            yield Settle(3.0)
            yield Record(1.0, sag=self.sag)


def _samples(values: list[list[float]]) -> list[PressureSample]:
    return [PressureSample(0.05 * index, np.array(value)) for index, value in enumerate(values)]


def _events(folder: Path) -> list[str]:
    return [text for _, text in summarise(folder).events]


def _states(folder: Path) -> list[tuple[int, int]]:
    from labrig.log import Topic
    from labrig_schema.step_pb2 import Step

    segments, _ = load_segments(folder)
    steps = [Step.FromString(payload) for payload in segments[0].messages(Topic.STEP).payload]
    return [
        (step.index, step.state) for step in steps if step.kind == "record" and step.state != Step.STARTED
    ]


@pytest.mark.parametrize(
    ("values", "sag", "missed"),
    [
        ([[38.0, 0.1]] * 5, False, []),
        ([[27.1, 0.1]] * 5, False, []),
        ([[26.9, 0.1]] * 5, False, ["c1"]),
        ([[53.1, 0.1]] * 5, False, ["c1"]),
        ([[40.0, 3.1]] * 5, False, ["c2"]),
        ([[40.0, 0.0], [0.0, 0.0], [0.0, 0.0], [40.0, 0.0], [0.0, 0.0], [0.0, 0.0]], False, []),
        ([[40.0, 0.0]] * 30 + [[20.0, 0.0]] * 3, False, ["c1"]),
        ([[40.0, 0.0]] * 30 + [[20.0, 0.0]] * 3, True, []),
        ([[20.0, 0.0]] * 30, True, ["c1"]),
        ([[math.nan, 0.0]] * 5, False, []),
        ([[0.0, 0.0]], False, ["c1"]),
        ([], False, []),
    ],
)
def test_three_samples_in_a_row_outside_the_tolerance_are_a_miss(
    config: Any, values: list[list[float]], sag: bool, missed: list[str]
) -> None:
    """3 kPa and a quarter of the set-point are allowed; a slip, a blind sensor and a sag that is wanted are none."""
    found = misses(_samples(values), np.array([40.0, 0.0]), config, sag=sag)
    assert [miss.chamber for miss in found] == missed


def test_a_tube_that_is_off_ends_a_run_that_nobody_watches(fake: Any, tmp_path: Path) -> None:
    """The capture is taken once more; then the run ends, vented, and the chamber is named with its pressures."""
    fake.pressure.faults["leaks"] = {0: math.inf}
    with pytest.raises(DeviceError) as caught:
        run(Two(), fake.rig, tmp_path / "run", fake.clock)
    assert str(caught.value) == (
        "pressure: c1 was asked for 20.0 kPa and reads 0.0 kPa (it may be 8.0 kPa off); check its tube, valve and "
        "sensor; the chambers are vented"
    )
    assert _states(tmp_path / "run") == [(2, 3), (2, 3)]
    assert open_run(tmp_path / "run").sizes["capture"] == 0
    assert [done.step.kind for done in read_completed(tmp_path / "run")] == ["actuate", "settle"]
    assert np.abs(fake.pressure_kpa).max() <= 0.5


def test_a_tube_that_is_off_is_noticed_where_pressures_are_read_seldom(
    make_rig: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A reading every three seconds falls into few recordings: each goes on until there is one."""
    fake = make_rig(safety={"stale_pressure_s": 10.0})
    fake.pressure.faults["leaks"] = {0: math.inf}
    driver = fake.pressure._device
    often = driver.samples
    monkeypatch.setattr(driver, "samples", lambda: [s for s in often() if round(20 * s.time_s) % 60 == 0])
    with pytest.raises(DeviceError, match=r"c1 was asked for 20.0 kPa and reads 0.0 kPa"):
        run(Two(), fake.rig, tmp_path / "run", fake.clock)


def test_a_chamber_that_leaks_half_its_pressure_is_noticed(fake: Any, tmp_path: Path) -> None:
    """It is not only the tube that is off: half of the pressure is missing, and that is said."""
    fake.pressure.faults["leaks"] = {0: 2.0}
    with pytest.raises(DeviceError, match=r"c1 was asked for 20.0 kPa and reads 10.0 kPa"):
        run(Two(), fake.rig, tmp_path / "run", fake.clock)


def test_a_command_that_was_lost_is_sent_again(fake: Any, tmp_path: Path) -> None:
    """The repeat begins with a vent: what a link lost on the way is sent anew, and every capture counts."""
    fake.pressure.faults |= {"leaks": {0: math.inf}, "leaks_until_vents": 2}
    run(Two(), fake.rig, tmp_path / "run", fake.clock)
    assert _states(tmp_path / "run") == [(2, 3), (2, 2), (5, 2)]
    data = open_run(tmp_path / "run")
    assert data["commanded"].to_numpy().tolist() == [[20.0, 10.0], [40.0, 10.0]]
    hold_s = data.isel(capture=0)["hold_s"].to_numpy()
    assert np.nanmax(hold_s) == pytest.approx(4.0, abs=0.3), "the hold begins at the second approach"
    assert any("taking the capture again" in text for text in _events(tmp_path / "run"))


def test_a_capture_that_missed_may_be_left_out(make_rig: Callable[..., Any], tmp_path: Path) -> None:
    """With on_miss: skip the run goes on; the capture is in the log, the procedure knows, and it does not count."""
    fake = make_rig(follow={"on_miss": "skip", "repeats": 0})
    fake.pressure.faults["leaks"] = {0: 2.0}  # 10 of 20 kPa is a miss, 20 of 40 kPa as well
    with pytest.warns(RuntimeWarning, match=r"2 of 2 captures were left out"):
        run(Two(), fake.rig, tmp_path / "run", fake.clock)
    assert open_run(tmp_path / "run").sizes["capture"] == 0
    assert summarise(tmp_path / "run").captures == 0
    assert summarise(tmp_path / "run").state == "completed"
    results = [done.result for done in read_completed(tmp_path / "run")]
    recordings = [result for result in results if isinstance(result, Recording)]
    assert [recording.missed for recording in recordings] == [("c1",), ("c1",)]


def test_a_run_that_is_watched_waits_for_a_person(fake: Any, tmp_path: Path) -> None:
    """It vents and waits; when the tube is back on and the person goes on, the capture is taken and counts."""
    control = Control(attended=True)
    fake.pressure.faults["leaks"] = {0: math.inf}
    seen: list[float] = []

    def mend() -> None:
        while not control.paused:
            time.sleep(0.005)
        time.sleep(0.1)
        seen.append(float(np.abs(fake.pressure_kpa).max()))
        fake.pressure.faults.clear()
        control.go_on()

    person = threading.Thread(target=mend)
    person.start()
    run(Two(), fake.rig, tmp_path / "run", fake.clock, watching=Watching((), control))
    person.join()
    assert seen[0] <= 0.5
    assert open_run(tmp_path / "run").sizes["capture"] == 2
    assert [state for _, state in _states(tmp_path / "run")] == [3, 3, 2, 2]


def test_a_person_hears_how_much_was_left_out(make_rig: Callable[..., Any], tmp_path: Path) -> None:
    """At the end of the run one line says how many of how many captures, and because of which chambers."""
    told: list[str] = []

    class Watcher(Observer):
        def event(self, time_s: float, text: str, level: str) -> None:
            if level == "WARNING":
                told.append(text)

    fake = make_rig(follow={"on_miss": "skip", "repeats": 0})
    fake.pressure.faults["leaks"] = {0: 2.0, 1: 9.0}
    run(Two(), fake.rig, tmp_path / "run", fake.clock, watching=Watching((Watcher(),)))
    assert told[-1] == (
        "2 of 2 captures were left out, since the pressures did not follow (c1 in 2, c2 in 2); check tubes, valves and "
        "sensors: labrig rig check"
    )
    tally = Tally.of(read_completed(tmp_path / "run"))
    assert (tally.none_kept, str(tally)) == (True, told[-1])


def test_after_a_pause_a_capture_has_all_its_repeats_again(fake: Any, tmp_path: Path) -> None:
    """Where a person goes on and it misses again, it is taken again as often as before the next pause."""
    control = Control(attended=True)
    pauses: list[int] = []

    def person() -> None:
        if control.paused:
            pauses.append(1)
            if len(pauses) == 2:
                fake.pressure.faults.clear()
            control.go_on()

    fake.pressure.faults["leaks"] = {0: math.inf}
    fake.clock.on_sleep = person
    run(Two(), fake.rig, tmp_path / "run", fake.clock, watching=Watching((), control))
    assert len(pauses) == 2
    assert [state for _, state in _states(tmp_path / "run")] == [3, 3, 3, 3, 2, 2]


def test_what_was_commanded_and_reached_is_in_the_log(fake: Any, tmp_path: Path) -> None:
    """Every recording says for each chamber what was asked for and what was there on the mean."""
    import json

    from labrig.log import Topic
    from labrig_schema.step_pb2 import Step

    fake.pressure.faults["leaks"] = {0: 0.1}
    run(Two(), fake.rig, tmp_path / "run", fake.clock)
    segments, _ = load_segments(tmp_path / "run")
    steps = [Step.FromString(payload) for payload in segments[0].messages(Topic.STEP).payload]
    results = [
        json.loads(step.result_json) for step in steps if step.kind == "record" and step.state == Step.DONE
    ]
    assert [result["commanded_kpa"] for result in results] == [[20.0, 10.0], [40.0, 10.0]]
    assert results[1]["reached_kpa"] == pytest.approx([40.0 / 1.05, 10.0], abs=0.2)


def test_a_person_is_told_while_the_run_goes_on(make_rig: Callable[..., Any], tmp_path: Path) -> None:
    """The warning reaches who watches, with the chamber, what was asked for and what was read."""
    told: list[str] = []

    class Watcher(Observer):
        def event(self, time_s: float, text: str, level: str) -> None:
            if level == "WARNING":
                told.append(text)

    fake = make_rig(follow={"on_miss": "abort", "repeats": 1})
    fake.pressure.faults["leaks"] = {1: math.inf}
    with pytest.raises(DeviceError):
        run(Two(), fake.rig, tmp_path / "run", fake.clock, watching=Watching((Watcher(),)))
    assert told == [
        "step 2: c2 was asked for 10.0 kPa and reads 0.0 kPa (it may be 5.5 kPa off): taking the capture again"
    ]


def test_a_summary_says_how_well_the_pressures_followed(make_rig: Callable[..., Any], tmp_path: Path) -> None:
    """What missed is counted apart; of what counts, the farthest of each chamber is kept."""
    fake = make_rig(follow={"on_miss": "skip", "repeats": 0, "tolerance_kpa": 6.5, "tolerance_share": 0.0})
    fake.pressure.faults["leaks"] = {0: 0.5}  # 16 of 20 kPa, 32 of 40 kPa: the second is a miss
    with pytest.warns(RuntimeWarning, match=r"1 of 2 captures were left out"):
        run(Two(), fake.rig, tmp_path / "run", fake.clock)
    summary = summarise(tmp_path / "run")
    assert (summary.captures, summary.missed) == (1, 1)
    assert summary.off_kpa["c1"] == pytest.approx(4.0, abs=0.1)
    assert summary.off_kpa["c2"] < 0.1
