"""What each shipped procedure plans: inside the limits, with the repeats and holds that it promises."""

from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import labrig_procedures
from labrig.campaign import Actuate, Procedure, Record, RigInfo, Scan, Settle, dry_run
from labrig.rig import parse_rig
from labrig_drivers import Channel
from labrig_procedures import Capture, Check, Hold, Idle, Pairs, Repeatability, Survey, Sweep

ALL = [getattr(labrig_procedures, name) for name in labrig_procedures.__all__ if name != "Validate"]
"""All that need nothing but a rig; validate needs targets and a model, and has tests of its own in tests/ik."""


def _info(chambers: int = 9, seed: int = 0) -> RigInfo:
    channels = tuple(Channel(f"c{n + 1}", -10.0 if n == 0 else 0.0, 60.0 - n, 100.0) for n in range(chambers))
    return RigInfo("made", channels, ("m1",), seed=seed)


def _steps(procedure: Procedure, info: RigInfo | None = None) -> list[Any]:
    return list(procedure.steps(info or _info()))


def _captures(steps: list[Any]) -> list[tuple[tuple[float, ...], Record]]:
    """Each recording with the set-point at which it was made."""
    found, setpoint = [], ()
    for step in steps:
        if isinstance(step, Actuate):
            setpoint = tuple(step.pressure_kpa)
        elif isinstance(step, Record):
            found.append((setpoint, step))
    return found


@pytest.mark.parametrize("kind", ALL)
@pytest.mark.parametrize("chambers", [1, 2, 9])
def test_the_defaults_stay_inside_the_limits(kind: type[Procedure], chambers: int) -> None:
    """Every set-point of every procedure is allowed, on small rigs and large ones."""
    info = _info(chambers)
    content = {
        "name": "made",
        "chambers": [{"name": c.name, "min_kpa": c.min_kpa, "max_kpa": c.max_kpa} for c in info.channels],
        "pressure": {"kind": "openpneu"},
        "scanner": {"kind": "artec", "folder": "scans"},
    }
    plan = dry_run(kind(), parse_rig(content, "rig.yaml", Path()))
    assert plan.broken == []
    assert plan.stopped is None
    assert plan.captures > 0
    assert not kind.closed_loop


@pytest.mark.parametrize(
    "procedure",
    [
        Capture(pattern="corners"),
        Capture(pattern="grid"),
        Check(highest=1.0, hold_share=1.0),
        Hold(shares=(1.0,)),
        Idle(share=1.0),
        Pairs(share=1.0),
        Sweep(others=1.0),
    ],
)
def test_limits_of_more_than_three_decimals_are_kept(procedure: Procedure) -> None:
    """Five psi are 34.4738 kPa: what is commanded at the limit is not rounded to 34.474, and refused."""
    info = RigInfo("psi", tuple(Channel(name, -34.4738, 34.4738, 100.0) for name in ("c1", "c2")), ("m1",))
    setpoints = np.array([step.pressure_kpa for step in _steps(procedure, info) if isinstance(step, Actuate)])
    assert np.abs(setpoints).max() == 34.4738


@pytest.mark.parametrize("kind", ALL)
def test_the_same_seed_gives_the_same_steps(kind: type[Procedure]) -> None:
    """A plan is a function of the parameters, the rig and the seed: resume depends on it."""
    assert _steps(kind()) == _steps(kind())


@pytest.mark.parametrize("kind", ALL)
def test_every_parameter_is_described(kind: type[Procedure]) -> None:
    """Each has a default and a text, and a length of time says its unit."""
    for name, field in kind.model_fields.items():
        assert not field.is_required()
        assert field.description
        if name.endswith(("_s", "_min")):
            assert field.description.endswith((", s", ", min"))


@pytest.mark.parametrize("pattern", ["halton", "random", "grid", "corners"])
@pytest.mark.parametrize("captures", [1, 6, 7, 40, 101])
def test_capture_makes_as_many_as_asked(pattern: Any, captures: int) -> None:
    """Repeats are part of the number."""
    assert len(_captures(_steps(Capture(captures=captures, pattern=pattern)))) == captures


def test_capture_repeats_with_the_same_and_with_another_history() -> None:
    """Each repeated set-point: three visits after the same one, one visit after another."""
    programme = Capture().programme(_info())
    visits: dict[str, list[tuple[float, ...]]] = {}
    values: dict[str, set[tuple[float, ...]]] = {}
    for (before, _), (setpoint, label) in pairwise([((), ""), *programme]):
        if label:
            visits.setdefault(label, []).append(before)
            values.setdefault(label, set()).add(setpoint)
    for group in ("r1", "r2", "r3"):
        counts = Counter(visits[group])
        assert sorted(counts.values()) == [1, 3]
        assert len(visits[f"{group}-before"]) == 3
    assert all(len(setpoints) == 1 for setpoints in values.values())
    assert len({setpoint for setpoint, _ in programme}) == 25


def test_capture_spreads_its_repeats_over_the_session() -> None:
    """The first and the last visit of a set-point are more than half a session apart."""
    labels = [label for _, label in Capture().programme(_info())]
    for group in ("r1", "r2", "r3"):
        places = [index for index, label in enumerate(labels) if label == group]
        assert places[-1] - places[0] > 20


@pytest.mark.parametrize(("scans", "expected"), [(0, 0), (1, 1), (10, 10), (100, 25)])
def test_survey_scans_different_set_points_after_their_markers(scans: int, expected: int) -> None:
    """It captures what `capture` does, and each scan follows a recording, at a set-point of its own."""
    steps = _steps(Survey(scans=scans))
    assert [s for s in steps if not isinstance(s, Scan)] == _steps(Capture())
    setpoint, scanned = (), []
    for before, step in pairwise(steps):
        setpoint = before.pressure_kpa if isinstance(before, Actuate) else setpoint
        if isinstance(step, Scan):
            assert isinstance(before, Record)
            scanned.append(setpoint)
    assert len(scanned) == len(set(scanned)) == expected
    if expected == 10:  # spread over the session
        points = [point for point, _ in Capture().programme(_info())]
        assert max(points.index(point) for point in scanned) > 30


@pytest.mark.parametrize(("pattern", "values"), [("corners", {0.0, 60.0}), ("grid", {0.0, 30.0, 60.0})])
def test_patterns_visit_what_they_say(pattern: Any, values: set[float]) -> None:
    """Corners are ends of the range only; a grid of two chambers with nine points has three levels."""
    info = RigInfo("made", (Channel("c1", 0.0, 60.0), Channel("c2", 0.0, 60.0)))
    points = Capture(pattern=pattern).setpoints(info, 4 if pattern == "corners" else 9)
    assert {float(value) for value in points.ravel()} == values
    assert len({tuple(point) for point in points}) == len(points)


def test_halton_fills_the_range_better_than_chance() -> None:
    """The largest gap in each chamber's values is smaller than that of random points."""
    info = _info(3)
    gaps = {
        pattern: np.diff(
            np.sort(Capture(pattern=pattern).setpoints(info, 60) / info.max_kpa, axis=0), axis=0
        ).max()
        for pattern in ("halton", "random")
    }
    assert gaps["halton"] < gaps["random"]


def test_a_narrower_range_is_kept() -> None:
    """lowest and highest are shares of the way from vented to the limit of each chamber, on either side of 0."""
    info = _info()
    points = Capture(lowest=0.4, highest=0.6).setpoints(info, 50)
    share = np.abs(points / np.where(points < 0, info.min_kpa, info.max_kpa))
    assert (share >= 0.4 - 1e-3).all()
    assert (share <= 0.6 + 1e-3).all()
    assert (points[:, 0] < 0).any()


LOW = {
    "capture": Capture(highest=0.4),
    "check": Check(highest=0.4),
    "sweep": Sweep(highest=0.4, others=0.4),
    "hold": Hold(shares=(0.4,), durations_s=(3.0,)),
    "pairs": Pairs(share=0.4),
    "idle": Idle(share=0.4, duration_min=2.0),
}


@pytest.mark.parametrize("name", LOW)
@pytest.mark.parametrize(("low", "high"), [(0.0, 60.0), (-60.0, 0.0), (-30.0, 60.0), (-60.0, 30.0)])
def test_a_low_highest_is_gentle_on_every_rig(name: str, low: float, high: float) -> None:
    """No set-point, nor a hold, is farther from vented than that share, and vacuum is counted as pressure is."""
    procedure, info = LOW[name], RigInfo("made", (Channel("c1", low, high), Channel("c2", low, high)))
    points = np.array([setpoint for setpoint, _ in _captures(_steps(procedure, info))])
    assert points.min() >= 0.4 * low - 1e-3
    assert points.max() <= 0.4 * high + 1e-3
    assert np.abs(points).max() > 0.3 * max(-low, high)


@pytest.mark.parametrize("name", LOW)
def test_a_rig_of_vacuum_is_the_mirror_of_one_of_pressure(name: str) -> None:
    """The same procedure goes to the same set-points with the other sign."""
    rigs = [RigInfo("made", (Channel("c1", *ends), Channel("c2", *ends))) for ends in ((0, 60.0), (-60.0, 0))]
    up, down = (np.array([p for p, _ in _captures(_steps(LOW[name], rig))]) for rig in rigs)
    np.testing.assert_array_equal(up, -down)


def test_repeatability_comes_from_both_sides() -> None:
    """Each set-point five times from above and five from below, under one label."""
    captures = _captures(_steps(Repeatability()))
    counts = Counter((record.repeat, record.label) for _, record in captures)
    assert counts == {(f"p{n}", side): 5 for n in range(1, 5) for side in ("above", "below")}
    assert len({(record.repeat, setpoint) for setpoint, record in captures}) == 4


def test_sweep_goes_up_and_down() -> None:
    """One chamber moves, in even steps, and turns without stopping twice."""
    captures = _captures(_steps(Sweep(chamber="c2", levels=3, cycles=2, others=0.5)))
    assert [setpoint[1] for setpoint, _ in captures] == [0.0, 29.5, 59.0, 29.5, 0.0, 29.5, 59.0, 29.5, 0.0]
    assert {setpoint[0] for setpoint, _ in captures} == {30.0}
    assert [record.repeat for _, record in captures][:3] == ["c2=0", "c2=29.5", "c2=59"]


def test_hold_records_whole_holds_and_their_recovery() -> None:
    """Every duration at both pressures, and after each the release."""
    steps = _steps(Hold(durations_s=(3.0, 10.0)))
    captures = _captures(steps)
    labels = ["hold 3 s", "recovery after 3 s"] * 2 + ["hold 10 s", "recovery after 10 s"] * 2
    assert [record.label for _, record in captures] == labels
    assert all(not any(setpoint) for setpoint, record in captures if record.label.startswith("recovery"))
    lengths = [steps[i + 1].duration_s + steps[i + 2].duration_s for i in range(0, len(steps), 3)]
    assert lengths == [3.0, 30.0, 3.0, 30.0, 10.0, 30.0, 10.0, 30.0]


def test_pairs_have_singles_and_both() -> None:
    """Each chamber alone, each pair, and rest, each from rest."""
    info = _info(4)
    captures = _captures(_steps(Pairs(), info))
    sizes = Counter(sum(value > 0 for value in setpoint) for setpoint, _ in captures)
    assert sizes == {0: 1, 1: 4, 2: 6}
    neighbours = _captures(_steps(Pairs(which="neighbours"), info))
    assert sum("+" in record.repeat for _, record in neighbours) == 3


def test_idle_visits_at_regular_intervals() -> None:
    """Thirty visits in half an hour, each of both set-points; the time between is the same."""
    steps = _steps(Idle())
    captures = _captures(steps)
    assert Counter(record.repeat for _, record in captures) == {"middle": 30, "rest": 30}
    waiting = sum(step.duration_s for step in steps if isinstance(step, Settle | Record))
    assert waiting == pytest.approx(30 * 60.0)


def test_an_unknown_chamber_is_named() -> None:
    """The error lists those that there are."""
    from labrig import LabrigError

    with pytest.raises(LabrigError) as caught:
        _steps(Sweep(chamber="left"), _info(2))
    assert str(caught.value) == "rig made has no chamber left; it has c1, c2"


def test_check_is_the_same_every_morning_and_short() -> None:
    """No seed changes it; it begins and ends at rest, repeats each set-point, and takes less than five minutes."""
    first, other = (_steps(Check(), _info(seed=seed)) for seed in (0, 1))
    assert first == other
    captures = _captures(first)
    assert not any(captures[0][0])
    assert not any(captures[-1][0])
    counts = Counter(record.repeat for _, record in captures)
    assert {counts[f"p{n}"] for n in range(1, 5)} == {4}
    assert sum(step.duration_s for step in first if isinstance(step, Settle | Record)) < 300
    points = np.array([setpoint for setpoint, record in captures if record.repeat == "p1"])
    assert len(np.unique(points, axis=0)) == 1
    varied = np.array([setpoint for setpoint, record in captures if record.repeat.startswith("p")])
    assert (np.ptp(varied, axis=0) > 0.4 * (_info().max_kpa - _info().min_kpa)).all()
