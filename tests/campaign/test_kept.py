"""What a procedure was told is done is kept: over a power cut, and over more than one resume."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from labrig import LabrigError
from labrig.campaign import (
    Actuate,
    Completed,
    Note,
    Procedure,
    Record,
    Recording,
    RigInfo,
    Scan,
    Settle,
    Steps,
    _kept,
    read_completed,
    resume,
    run,
)
from labrig.campaign._runfile import write_run_yaml
from labrig.log import read_run_yaml
from tests.campaign.stopping import stop_after


class Told(Procedure):
    """A short run that calls `heard` with the number of steps whose results it has."""

    heard: ClassVar[Callable[[int], None]]

    def steps(self, rig: RigInfo) -> Steps:
        """Two captures and a scan."""
        steps = [Actuate((20.0, 10.0)), Settle(3.0), Record(0.5), Scan(), Note("a note"), Record(0.5)]
        for number, step in enumerate(steps, 1):
            yield step
            self.heard(number)


@pytest.mark.parametrize("segment_steps", [10_000, 2])
def test_a_step_whose_result_is_known_survives_a_power_cut(
    fake: Any, disk: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, segment_steps: int
) -> None:
    """Cut at the moment when the procedure gets a result: the step, its data, its scan and run.yaml are there."""
    monkeypatch.setattr("labrig.campaign._session.SEGMENT_STEPS", segment_steps)
    folder = tmp_path / "runs" / "one"
    folder.parent.mkdir()
    looked: list[int] = []

    def heard(number: int) -> None:
        if not fake.pressure.world.commands:
            return  # the dry run
        left = disk.cut(folder.parent, tmp_path / f"left{number}") / "one"
        done = read_completed(left)
        assert [item.index for item in done] == list(range(number))
        assert read_run_yaml(left) == read_run_yaml(folder)
        for item in done:
            for file in getattr(item.result, "files", ()):
                assert (left / file).read_bytes() == (folder / file).read_bytes()
        looked.append(number)

    monkeypatch.setattr(Told, "heard", staticmethod(heard), raising=False)
    run(Told(), fake.rig, folder, fake.clock)
    assert looked == [1, 2, 3, 4, 5, 6]


def test_run_yaml_survives_a_power_cut_before_the_log_begins(disk: Any, tmp_path: Path) -> None:
    """What the run is going to be is durable before anything moves: the file, its name, and that of its folder."""
    folder = tmp_path / "run"
    folder.mkdir()
    write_run_yaml(folder, {"procedure": "told", "seed": 3})
    left = disk.cut(tmp_path, tmp_path.with_name(f"{tmp_path.name}-left"))
    assert read_run_yaml(left / "run") == {"procedure": "told", "seed": 3}


def test_what_is_kept_in_memory_has_an_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run of a week does not fill the memory with its captures: the first ones are kept, and no more."""
    monkeypatch.setattr(_kept, "MOST", 3)
    kept = _kept.Kept(1)
    kept.done(Completed(0, Actuate((10.0,))))
    recording = Recording(np.zeros(1), np.zeros((1, 2, 3)), np.zeros(1), np.zeros((1, 1)))
    for index in range(1, 6):
        kept.done(Completed(index, Record(), recording))
    assert [about["step"] for about in kept.facts] == [1, 2, 3]
    assert len(kept.values) == 3


class Seeks(Procedure):
    """A closed loop: each set-point follows from the recording before it."""

    closed_loop: ClassVar[bool] = True
    gain: ClassVar[float] = 1.0

    def steps(self, rig: RigInfo) -> Steps:
        """Eight rounds."""
        pressure_kpa = 10.0
        for _ in range(8):
            yield Actuate((pressure_kpa, pressure_kpa))
            yield Settle(3.0)
            recording = yield Record(0.2)
            pressure_kpa = (
                10.0 + self.gain * float(recording.mean_mm[0, 2]) + float(recording.time_s[0]) % 7.0
            )
            yield Note(f"{pressure_kpa!r}")


def test_a_session_is_followed_from_where_it_began(make_rig: Callable[..., Any], tmp_path: Path) -> None:
    """Damage in the first session makes the second begin earlier: from there on the first one counts no more.

    What both have is taken from the second, whose results the procedure went on with, and what only the first has is
    of a run that was given up.
    """
    folder = tmp_path / "run"
    rigs = [make_rig() for _ in range(3)]
    for number, rig in enumerate(rigs):
        rig.clock.sleep(1003.0 * number)  # sessions at other times measure other things
    stop_after(12, lambda: run(Seeks(), rigs[0].rig, folder, rigs[0].clock))
    first = read_completed(folder)
    log = folder / "log.000.mcap"
    whole = bytearray(log.read_bytes())
    damaged = 0
    while len(read_completed(folder)) != 4:  # the chunk of the fifth step
        log.write_bytes(whole)
        damaged = whole.index(b"\x04\x00\x00\x00zstd", damaged + 1)
        log.write_bytes(whole[: damaged + 40] + b"\xff" * 8 + whole[damaged + 48 :])
    stop_after(4, lambda: resume(Seeks(), rigs[1].rig, folder, rigs[1].clock))
    second = read_completed(folder)
    assert [item.index for item in second] == list(range(8))
    assert [item.step for item in second[:4]] == [item.step for item in first[:4]]
    assert all(item.started_s > 1000.0 for item in second[4:])
    resume(Seeks(), rigs[2].rig, folder, rigs[2].clock)
    third = read_completed(folder)
    assert [item.index for item in third] == list(range(32))
    assert [item.step for item in third[:8]] == [item.step for item in second]


def test_a_closed_loop_that_was_edited_is_refused(make_rig: Callable[..., Any], tmp_path: Path) -> None:
    """Its steps cannot be compared beforehand: the first that differs in the replay ends it, and nothing moves."""
    folder = tmp_path / "run"
    first, second = make_rig(), make_rig()
    stop_after(8, lambda: run(Seeks(), first.rig, folder, first.clock))
    edited = type("Seeks", (Seeks,), {"gain": 2.0})
    with pytest.raises(LabrigError) as caught:
        resume(edited(), second.rig, folder, second.clock)
    assert str(caught.value).startswith(f"cannot resume {folder}: step 3 was {{'kind': 'note', 'text': '")
    assert str(caught.value).endswith("; start a new run; the chambers are vented")
    assert {command for _, command in second.pressure.world.commands} == {(0.0, 0.0)}
