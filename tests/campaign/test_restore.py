"""What a resumed run, or a capture that is taken again, brings back: the same set-points, for as long as they were."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig import open_run
from labrig.campaign import (
    Actuate,
    Control,
    Note,
    Procedure,
    Record,
    RigInfo,
    Scan,
    Settle,
    Steps,
    Vent,
    Watching,
    read_completed,
    resume,
    run,
)
from labrig.campaign._replay import holds_to_restore
from tests.campaign.stopping import stop_after


class Scanned(Procedure):
    """A hold with a scan, which takes 2 s, and what a test puts between its steps."""

    def steps(self, rig: RigInfo) -> Steps:
        """One hold, two captures."""
        yield Actuate((20.0, 10.0))
        yield Settle(3.0)
        self.think()
        yield Scan()
        yield Record(1.0)
        yield Record(1.0)

    def think(self) -> None:
        """Nothing, at once."""


class Emptied(Procedure):
    """A hold, a vent, and a capture of the vented chambers."""

    def steps(self, rig: RigInfo) -> Steps:
        """Up, down, and nothing more."""
        yield Actuate((20.0, 10.0))
        yield Settle(3.0)
        yield Vent()
        yield Note("vented")
        yield Record(1.0)


def holds_s(folder: Path) -> list[float]:
    """When the first frame of each capture was taken, s from its actuation's beginning."""
    data = open_run(folder)
    found = np.where(data["settled"], data["hold_s"], np.nan)
    return [round(float(first), 1) for first in np.nanmin(found, axis=1)]


@pytest.fixture
def thinking(fake: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A rig whose procedure thinks for 4 s in the middle of its hold, whenever it has its clock."""
    monkeypatch.setattr(Scanned, "think", lambda _: fake.clock.sleep(4.0))
    return fake


def test_the_time_of_a_scan_is_restored(make_rig: Callable[..., Any], tmp_path: Path) -> None:
    """The capture after a scan lies as late in its hold in a run that was resumed as in one that was not."""
    whole, first, second = make_rig(), make_rig(), make_rig()
    run(Scanned(), whole.rig, tmp_path / "whole", whole.clock)
    stop_after(4, lambda: run(Scanned(), first.rig, tmp_path / "run", first.clock))
    resume(Scanned(), second.rig, tmp_path / "run", second.clock)
    assert holds_s(tmp_path / "whole") == pytest.approx([5.2, 6.2], abs=0.11)
    assert holds_s(tmp_path / "run") == pytest.approx(holds_s(tmp_path / "whole"), abs=0.11)


def test_the_time_between_two_steps_is_restored(thinking: Any, make_rig: Any, tmp_path: Path) -> None:
    """The chambers are held while the procedure thinks: what is measured later must not come sooner."""
    second = make_rig()
    stop_after(4, lambda: run(Scanned(), thinking.rig, tmp_path / "run", thinking.clock))
    resume(Scanned(), second.rig, tmp_path / "run", second.clock)
    assert holds_s(tmp_path / "run") == pytest.approx([9.2, 10.2], abs=0.11)


def test_a_capture_that_is_taken_again_is_as_late_in_its_hold(
    thinking: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The hold before it is as long again as it was, its scan and the procedure's thinking included, and no longer."""
    fake, scanner = thinking, thinking.rig.scanner._device
    scan = scanner.scan

    def then_leak(timeout_s: float) -> Any:
        found = scan(timeout_s)
        fake.pressure.faults |= {"leaks": {0: np.inf}, "leaks_until_vents": 2}
        return found

    monkeypatch.setattr(scanner, "scan", then_leak)
    run(Scanned(), fake.rig, tmp_path / "run", fake.clock)
    assert len(fake.pressure.vents) == 3, "one capture was taken again"
    assert holds_s(tmp_path / "run") == pytest.approx([9.2, 10.2], abs=0.11)


def test_a_pause_is_no_part_of_the_hold_before_it(fake: Any, tmp_path: Path) -> None:
    """The chambers were vented in it: a resumed run holds the set-point before it for as long as it was held."""
    control = Control()
    ticks: list[int] = []

    def wait_a_while() -> None:
        if fake.pressure.world.target_kpa.any():
            control.pause()
        elif control.paused:
            ticks.append(1)
            if len(ticks) > 200:
                control.go_on()
                fake.clock.on_sleep = lambda: None

    class Two(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            for pressure_kpa in (20.0, 40.0):
                yield Actuate((pressure_kpa, 10.0))
                yield Settle(3.0)
                yield Record(1.0)

    fake.clock.on_sleep = wait_a_while
    run(Two(), fake.rig, tmp_path / "run", fake.clock, watching=Watching((), control))
    done = read_completed(tmp_path / "run")
    assert done[3].started_s - done[2].ended_s > 10.0, "it was paused"
    held = [held_s for _, held_s in holds_to_restore(done[:5], Record())]
    assert held == pytest.approx([4.0, 3.0], abs=0.1)


def test_what_a_vent_emptied_is_not_filled_again(make_rig: Callable[..., Any], tmp_path: Path) -> None:
    """A run that is resumed after a vent of its own goes on vented: nothing from before it comes back."""
    first, second = make_rig(), make_rig()
    stop_after(4, lambda: run(Emptied(), first.rig, tmp_path / "run", first.clock))
    resume(Emptied(), second.rig, tmp_path / "run", second.clock)
    assert {command for _, command in second.pressure.world.commands} == {(0.0, 0.0)}
