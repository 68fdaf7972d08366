"""A programme before it is measured: repeats, levels and time."""

import numpy as np
import pytest

from labrig.effects import rows_of
from labrig.experiment import Limits
from labrig.experiment._plan import Point, Probe, planned_rows, repeat_labels
from labrig.experiment._probes import moves, on_few_levels


def test_repeats_are_the_same_hold_after_the_same_one() -> None:
    """Labels are shared only by points whose set-point, hold and predecessor agree."""
    rest, up = (0.0,), (0.8,)
    points = [
        Point(up, 4.0),
        Point(rest, 4.0),
        Point(up, 4.0),
        Point(rest, 4.0),
        Point(up, 60.0),
        Point(rest, 4.0),
    ]
    labels = repeat_labels(points, rest)
    assert labels[1] == labels[3] != ""
    assert labels[0] == labels[2] == labels[4] == labels[5] == ""


def test_few_levels_for_a_base_that_is_slow() -> None:
    """Set-points are moved to thirds, and the same one is not visited twice on end; long holds stay."""
    rest = (0.0, 0.1)
    points = (Point((0.15, 0.1), 4.0), Point((0.3, 0.1), 4.0), Point((0.9, 0.1), 60.0), Point(rest, 4.0))
    (probe,) = on_few_levels([Probe("c1: steps", "s", points)], rest)
    assert [p.share for p in probe.points] == [(0.0, 0.1), (0.3, 0.1), (0.9, 0.1), (0.0, 0.1)]
    assert 60.0 in [p.hold_s for p in probe.points]


def test_a_probe_is_called_by_what_it_does() -> None:
    """A long hold is in its title as it is planned, also once it was changed; short ones need no words."""
    rest = (0.0,)
    long = Probe("c1: hold and recovery", "creep", (Point((0.9,), 300.0), Point(rest, 60.0)))
    assert long.title == "c1: hold and recovery, 300 s"
    changed = [p for p in moves(long, rest) if p.points[0].hold_s == 120.0]
    assert [p.title for p in changed] == ["c1: hold and recovery, 120 s"]
    assert Probe("c1: steps up and down", "s", (Point((0.9,), 4.0),)).title == "c1: steps up and down"


@pytest.mark.parametrize(("unit", "low", "high"), [("mm", 20.5, 44.0), ("kPa", 0.0, 60.0)])
def test_a_stage_goes_no_farther_than_it_has_been(make_lab, unit: str, low: float, high: float) -> None:
    """A run whose table states no limits has zero as one: a length is not sent there, a chamber may be vented."""
    lab = make_lab(captures=24, chambers=1, repeats=False)
    lab.commanded[:] = np.linspace(20.5, 44.0, 24)[:, None]
    run = lab.dataset(lab.predict(lab.u))
    run["commanded"].attrs["units"] = unit
    limits = Limits.of(rows_of(run))
    assert (limits.low[0], limits.high[0]) == (low, high)


def test_a_probe_knows_how_long_it_takes() -> None:
    """Ways at the slowest chamber's rate, and holds."""
    limits = Limits(np.zeros(2), np.array([60.0, 30.0]), np.array([30.0, 10.0]))
    probe = Probe("p", "s", (Point((0.5, 0.5), 4.0), Point((0.0, 0.0), 2.0)))
    assert probe.seconds(limits) == pytest.approx(1.5 + 4.0 + 1.5 + 2.0)


@pytest.mark.parametrize("each", [1.0, 1000.0, 10.0, 0.01, 0.001])
def test_a_plan_is_the_same_in_every_unit(each: float) -> None:
    """Where no rig states a rate: the same time, and set-points as fine, for kPa, Pa, mbar, bar and MPa."""
    shares = [(0.6, 0.123456), (0.75, 0.3), (0.0, 0.0)]
    probe = Probe("p", "s", tuple(Point(share, 4.0) for share in shares))
    plain, other = (Limits.between(np.zeros(2), k * np.array([60.0, 30.0])) for k in (1.0, each))
    assert plain.slew_per_s.tolist() == [100.0, 50.0]
    assert probe.seconds(other) == pytest.approx(probe.seconds(plain))
    for share in shares:
        np.testing.assert_allclose(other.actuation(share) / each, plain.actuation(share), rtol=1e-12)
    assert plain.actuation(shares[0]).tolist() == [36.0, 3.7]


def test_a_model_that_follows_measured_pressures_can_be_asked_about_a_plan(make_lab) -> None:
    """In a programme that nobody has run, pressures are what is commanded, where the run says what they were."""
    lab = make_lab(captures=12, chambers=2)
    run = lab.dataset(lab.predict(lab.u))
    left = np.exp(-lab.hold_s / 90.0)[:, :, None]
    run["measured"] = (("capture", "time", "chamber"), np.where(np.isfinite(left), lab.u * left, np.nan))
    rows = rows_of(run)
    predictor = lab.model("[{name: leak, form: as measured, parameters: {sensor: {value: 1.0}}}]").predictor(
        rows
    )
    planned = planned_rows(rows, [(Point((0.5, 0.8), 30.0),)], Limits.of(rows)).rows
    np.testing.assert_allclose(predictor.context(planned).base, lab.predict(planned.actuation))


def test_a_chamber_that_is_never_filled_is_planned_around() -> None:
    """One whose limits are both 0 kPa stays vented, and the others' set-points are as fine as ever."""
    limits = Limits.between(np.array([0.0, 0.0]), np.array([60.0, 0.0]))
    assert limits.rest == (0.0, 0.0)
    assert limits.actuation([0.12345, 0.5]).tolist() == [7.41, 0.0]
    assert Limits.between(np.zeros(1), np.zeros(1)).actuation([1.0]).tolist() == [0.0]
