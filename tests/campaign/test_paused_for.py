"""How long a run has left while it is paused: as long as before."""

from pathlib import Path
from typing import Any

import pytest

from labrig.campaign import (
    Actuate,
    Control,
    Procedure,
    Progress,
    Record,
    RigInfo,
    Settle,
    Steps,
    Watching,
    run,
)

PAUSE_S = 20.0


class Two(Procedure):
    """Two captures."""

    def steps(self, rig: RigInfo) -> Steps:
        """Up and up."""
        for pressure_kpa in (10.0, 30.0):
            yield Actuate((pressure_kpa, 10.0))
            yield Settle(2.0)
            yield Record(1.0)


def test_what_is_left_stands_still_during_a_pause(fake: Any, tmp_path: Path) -> None:
    """A pause is not in the plan: what is left of it afterwards is what was left before."""
    control, began_s = Control(), []
    told: list[Progress] = []

    class Pauses(Two):
        def steps(self, rig: RigInfo) -> Steps:
            for number, step in enumerate(super().steps(rig)):
                if number == 3 and fake.pressure.world.commands:
                    began_s.append(fake.clock.now_s())
                    control.pause()
                yield step

    def going_on() -> None:
        if control.paused and fake.clock.now_s() - began_s[0] > PAUSE_S:
            control.go_on()

    fake.clock.on_sleep = going_on
    run(Pauses(), fake.rig, tmp_path / "run", fake.clock, 0, told.append, Watching(control=control))
    paused = [each.remaining_s for each in told if each.paused]
    assert len(paused) > 10
    assert paused == pytest.approx([3.0] * len(paused), abs=0.01)
    after = [each.remaining_s for each in told if not each.paused and each.captures_done == 1]
    assert max(after) == pytest.approx(3.0, abs=0.5)
