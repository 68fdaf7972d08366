"""How much a procedure may ask for, how quickly its plan is there, and that a long one needs no more memory."""

import math
import time
from pathlib import Path
from typing import Any

import pytest

import labrig_procedures
from labrig import LabrigError
from labrig.api._procedures import shipped
from labrig.campaign import Actuate, Procedure, Record, RigInfo, Settle, Steps, dry_run, rig_info, run
from labrig.campaign._session import Session
from labrig.rig import parse_rig

RIG = parse_rig(
    {
        "name": "made",
        "chambers": [{"name": "c1", "max_kpa": 60}, {"name": "c2", "max_kpa": 40}],
        "pressure": {"kind": "openpneu"},
    },
    "rig.yaml",
    Path(),
)
TOO_MUCH = {
    "capture": {"captures": 10**9},
    "survey": {"captures": 10**9},
    "sweep": {"levels": 10**5, "cycles": 10**5},
    "idle": {"duration_min": 1e12},
    "programme": {"rounds": 10**9},
    "repeatability": {"points": 10**9},
    "check": {"points": 10**9},
    "pairs": {"rounds": 10**9},
    "hold": {"durations_s": [1.0] * 400, "shares": [0.5] * 400},
}


@pytest.mark.parametrize("name", sorted(TOO_MUCH))
def test_more_than_a_plan_may_have_is_refused_at_once(name: str) -> None:
    """A count that is a slip of the hand is told in one line, before its steps are made, in every procedure."""
    procedure = shipped()[name].model_validate(TOO_MUCH[name])
    began = time.monotonic()
    with pytest.raises(LabrigError, match=rf"^{name}: more than 100000 set-points; ask for fewer"):
        dry_run(procedure, RIG)
    assert time.monotonic() - began < 2.0


def test_every_procedure_of_labrigs_says_how_many_it_has() -> None:
    """What a procedure says beforehand is not less than half of what its steps then are."""
    for name, kind in shipped().items():
        if name == "validate":  # as many as it has targets
            continue
        procedure = kind()
        made = sum(isinstance(step, Actuate) for step in dry_run(procedure, RIG).steps if name != "survey")
        assert procedure.set_points(rig_info(RIG)) >= made / 2, name


def test_a_procedure_of_ones_own_is_counted(monkeypatch: Any) -> None:
    """A procedure that does not say how many set-points it has ends when there are too many."""
    monkeypatch.setattr("labrig.campaign._plan.MOST_SET_POINTS", 50)

    class Mine(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            while True:
                yield Actuate((1.0, 1.0))

    with pytest.raises(LabrigError, match=r"^mine: more than 50 set-points"):
        dry_run(Mine(), RIG)


def test_a_day_is_planned_in_a_moment() -> None:
    """Waits cost no time in a dry run, and what a procedure learns at their ends is as it was."""

    class Long(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            yield Actuate((1.0, 1.0))
            settled = yield Settle(86_400.0)
            assert settled.took_s == 86_400.0
            recorded = yield Record(86_400.0)
            assert recorded.mean_kpa.tolist() == [1.0, 1.0]

    began = time.monotonic()
    assert dry_run(Long(), RIG).duration_s >= 172_800.0
    assert time.monotonic() - began < 5.0


def test_a_slow_way_is_planned_in_a_moment() -> None:
    """A slew limit of almost nothing, such as one in another unit, costs a dry run no time: the plan says how long."""
    slow = tuple(chamber.model_copy(update={"slew_kpa_s": 1e-4}) for chamber in RIG.chambers)
    began = time.monotonic()
    plan = dry_run(shipped()["sweep"](), RIG.model_copy(update={"chambers": slow}))
    assert time.monotonic() - began < 20.0
    assert plan.duration_s == pytest.approx(32 * 60.0 / 8 / 1e-4, rel=0.1)


def test_a_survey_of_many_is_planned_in_a_moment() -> None:
    """Which of thousands of set-points are scanned is found without comparing each with every other."""
    points = [(float(k), 0.0) for k in range(50_000)]
    began = time.monotonic()
    assert len(labrig_procedures.Survey(scans=3)._scanned(points)) == 3
    assert time.monotonic() - began < 2.0


def test_a_long_wait_does_not_fill_the_memory(
    fake: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a wait of hours nobody needs more than the end: only that is kept, and how still it is then."""
    most = [0]

    class Counting(Session):
        def poll(self) -> None:
            super().poll()
            most[0] = max(most[0], len(self.held.frames), len(self.held.samples))

    class Waits(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            settled = yield Settle(600.0)
            assert math.isfinite(settled.speed_mm_s)
            assert math.isfinite(settled.pressure_error_kpa)

    monkeypatch.setattr("labrig.campaign._runner.Session", Counting)
    run(Waits(), fake.rig, tmp_path / "run", fake.clock)
    assert 10 < most[0] < 100
