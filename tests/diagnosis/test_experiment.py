"""The next experiment: what is proposed, and that the diagnosis with it is right. All formulas are the tests' own."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from labrig import LabrigError
from labrig.diagnosis import Experiment, Limits, diagnose, plan_next, propose_experiment
from labrig.diagnosis._experiment_plan import Point, Probe, repeat_labels
from labrig.diagnosis._experiment_probes import on_few_levels

ROWS_S = (1.2, 2.0, 3.0, 4.0)
Values = Callable[[Any], np.ndarray]


def leaking(lab: Any) -> np.ndarray:
    """An orifice: the root of the pressure falls in a straight line."""
    return lab.predict(np.maximum(np.sqrt(lab.u) - 0.0035 * lab.hold_s[:, :, None], 0.0) ** 2)


def creeping(lab: Any) -> np.ndarray:
    """A power law of time since each change of pressure, superposed (Boltzmann)."""
    u = lab.u
    crept = np.zeros_like(u)
    for i in range(len(u)):
        last = np.zeros(lab.chambers)
        for j in range(i + 1):
            since = lab.event_s[i] - lab.event_s[j] + lab.hold_s[i]
            crept[i] += (np.maximum(since, 0.0) ** 0.35)[:, None] * (lab.commanded[j] - last)
            last = lab.commanded[j]
    return lab.predict(u + 0.006 * crept)


def looped(lab: Any) -> np.ndarray:
    """A Bouc-Wen loop on every pressure."""
    u, z, last = lab.u, np.zeros(lab.chambers), np.zeros(lab.chambers)
    for i, way in lab.path(60):
        for point in way:
            d = (point - last) / 60.0
            z = z + d / 0.08 * (1 - np.abs(z) ** 1.4 * (0.5 * np.sign(d * z) + 0.5))
            last = point
        u[i] -= 4.0 * z
    return lab.predict(u)


def wandering(lab: Any) -> np.ndarray:
    """The force sensor's zero climbs with the time in session."""
    return lab.predict(lab.u) + 0.004 * (lab.time_s - lab.event_s[0])[:, :, None]


def one_long_hold(make_lab: Any, **settings: Any) -> Any:
    """One actuation watched for long: little but the form of a curve to go by."""
    rows = tuple(np.geomspace(1.2, 300.0, 60))
    lab = make_lab(chambers=1, force=True, captures=1, rows_s=rows, repeats=False, **settings)
    lab.commanded[:] = 45.0
    return lab


def one_level(make_lab: Any, **settings: Any) -> Any:
    """One set of pressures, on and off: two states in all."""
    lab = make_lab(chambers=2, markers=4, captures=40, rows_s=ROWS_S, repeats=False, **settings)
    lab.commanded[:] = np.where(np.arange(40)[:, None] % 2 == 0, [42.0, 36.0], 0.0)
    lab.label[:] = ["on" if i % 2 == 0 else "off" for i in range(40)]
    return lab


def measured(lab: Any, experiment: Experiment, values: Values, seed: int = 5) -> Any:
    """What the same rig shows under the proposed programme, as another run."""
    from dataclasses import replace

    points = experiment.points
    holds = [tuple(h for h in np.geomspace(1.2, p.hold_s, 4 if p.hold_s < 8 else 8)) for p in points]
    other = replace(lab, captures=len(points), rows_s=ROWS_S, long_s=(), seed=seed, repeats=False)
    other.commanded = np.array([experiment.limits.actuation(p.share) for p in points])
    other.label = list(experiment.repeats)
    other.session = np.zeros(len(points), dtype=int)
    other.hold_s = np.full((len(points), max(map(len, holds))), np.nan)
    for i, rows in enumerate(holds):
        other.hold_s[i, : len(rows)] = rows
    other.event_s = np.concatenate([[0.0], np.cumsum([p.hold_s + 0.6 for p in points])[:-1]])
    other.time_s = other.hold_s + other.event_s[:, None]
    return other.dataset(values(other) + other.noise(0.05, 0.1))


@pytest.mark.parametrize(
    ("name", "values", "rival"),
    [("leak", leaking, "drift"), ("creep", creeping, "drift"), ("drift", wandering, "leak")],
)
def test_after_the_experiment_the_verdict_is_right(make_lab, name: str, values: Values, rival: str) -> None:
    """A slow change of one force in one hold: the proposed programme settles what it is."""
    lab = one_long_hold(make_lab)
    model = lab.model()
    run = lab.dataset(values(lab) + lab.noise(0.05, 0.0))
    first = diagnose(run, model).summary
    confounded = {**first, "verdict": "confounded", "effects": [name], "rivals": [rival]}
    experiment = propose_experiment(run, model, summary=confounded, minutes=12)
    both = diagnose([run, measured(lab, experiment, values)], model).summary
    assert (both["verdict"], both["effects"]) == ("identified", [name])
    assert experiment.summary["minutes"] <= 12


def test_a_loop_is_told_from_a_gain(make_lab) -> None:
    """On and off at one level a loop looks like a wrong gain; with the proposed programme it does not."""
    lab = one_level(make_lab)
    model, run = lab.model(), lab.dataset(looped(lab) + lab.noise())
    found = {**diagnose(run, model).summary, "verdict": "confounded"}
    found |= {"effects": ["regulator"], "rivals": ["friction", "hysteresis"]}
    experiment = propose_experiment(run, model, summary=found)
    both = diagnose([run, measured(lab, experiment, looped)], model).summary
    assert (both["verdict"], both["effects"]) == ("identified", ["hysteresis"])


@pytest.fixture
def doubt(make_lab) -> tuple[Any, Any, dict[str, Any]]:
    """A run of three chambers, its model, and a diagnosis that leaves three explanations open."""
    lab = make_lab(captures=30, rows_s=ROWS_S)
    model, run = lab.model(), lab.dataset(looped(lab) + lab.noise())
    found = diagnose(run, model).summary
    return (
        run,
        model,
        {**found, "verdict": "confounded", "effects": ["hysteresis"], "rivals": ["creep", "friction"]},
    )


def test_what_is_proposed(doubt) -> None:
    """Every pair has an expectation, every probe its share; times add up, limits are kept, and it is the same twice."""
    run, model, found = doubt
    low, high = np.zeros(3), np.array([60.0, 40.0, 20.0])
    limits = Limits(low, high, np.full(3, 50.0))
    experiment = propose_experiment(run, model, summary=found, limits=limits, minutes=4)
    summary = experiment.summary
    titles = {"hysteresis", "creep", "friction"}
    assert {(e["true"], e["other"]) for e in summary["expected"]} == {
        (a, b) for a in titles for b in titles if a != b
    }
    assert summary["separates"] == ["hysteresis", "creep", "friction"]
    assert sum(p["minutes"] for p in summary["probes"]) == pytest.approx(summary["minutes"], abs=0.02)
    assert summary["minutes"] <= 4
    assert summary["captures"] == len(experiment.points) == len(experiment.programme())
    assert min(e["floors"] for e in summary["expected"]) > 0
    pressures = np.array([experiment.limits.actuation(p.share) for p in experiment.points])
    assert (pressures >= low).all()
    assert (pressures <= high).all()
    again = propose_experiment(run, model, summary=found, limits=limits, minutes=4)
    assert again.programme() == experiment.programme()


def test_more_time_tells_more(doubt) -> None:
    """The weakest expectation does not fall when the programme may be longer."""
    run, model, found = doubt

    def weakest(minutes: float) -> float:
        summary = propose_experiment(run, model, summary=found, minutes=minutes).summary
        return min(e["log10_bayes"] for e in summary["expected"])

    assert weakest(4) > weakest(0.6)


def test_what_has_no_name_is_looked_for_where_least_is_known(make_lab) -> None:
    """After captures of one level only, the programme for an unknown error goes to other levels and visits twice."""
    lab = one_level(make_lab)
    model, run = lab.model(), lab.dataset(looped(lab) + lab.noise())
    found = diagnose(run, model).summary
    open_ = {**found, "verdict": "unknown", "effects": [], "rivals": [], "carried_by": "pressure"}
    experiment = propose_experiment(run, model, summary=open_, minutes=3)
    levels = {tuple(np.round(p.share, 2)) for p in experiment.points}
    assert len(levels) >= 6
    assert all(p["times"] == 2 for p in experiment.summary["probes"])
    assert "pressure" in experiment.summary["why"]
    assert experiment.summary["minutes"] <= 3


def test_too_few_data_ask_for_more(make_lab) -> None:
    """Where an effect of the tolerance could hide, a programme that visits everything twice is proposed."""
    lab = make_lab(captures=16, chambers=1, force=True)
    model, run = lab.model(), lab.dataset(lab.predict(lab.u) + lab.noise())
    experiment = propose_experiment(run, model, tolerance=0.001, minutes=2)
    assert experiment.summary["verdict"] == "underpowered"
    assert 0 < experiment.summary["minutes"] <= 2
    assert len([label for label in experiment.repeats if label]) > 2


def test_clear_verdicts_need_no_experiment(make_lab) -> None:
    """Nothing missing, or identified with nobody near: said in one line."""
    lab = make_lab(captures=40)
    model, run = lab.model(), lab.dataset(lab.predict(lab.u) + lab.noise())
    with pytest.raises(LabrigError) as caught:
        propose_experiment(run, model)
    assert str(caught.value) == "the verdict is nothing_missing: it leaves nothing to settle"
    ranking = [{"effect": "leak", "heldout_error": 0.1}, {"effect": "creep", "heldout_error": 0.9}]
    sure = {"verdict": "identified", "effects": ["leak"], "rivals": [], "ranking": ranking}
    with pytest.raises(LabrigError) as caught:
        propose_experiment(run, model, summary=sure)
    assert str(caught.value) == (
        "the verdict is identified and no other effect comes near: there is nothing to settle; check it on a fresh "
        "programme (labrig run capture, with another seed)"
    )
    with pytest.raises(LabrigError) as caught:
        propose_experiment(run, model, minutes=0)
    assert str(caught.value) == "an experiment of 0 min: give it some time"


def test_what_no_programme_tells_is_for_a_person(make_lab) -> None:
    """A shifted frame and a rest shape differ by no pressure: it is said so, with what to do by hand."""
    lab = make_lab(captures=40, markers=4)
    model, run = lab.model(), lab.dataset(lab.predict(lab.u) + 0.8 + lab.noise())
    found = diagnose(run, model).summary
    same = {**found, "verdict": "confounded", "effects": ["frame"], "rivals": ["rest_shape"]}
    with pytest.raises(LabrigError) as caught:
        propose_experiment(run, model, summary=same)
    start = (
        "no programme of 10 min within the rig's limits tells frame and rest_shape apart; by hand: frame: "
    )
    assert str(caught.value).startswith(start)
    assert "register the measuring frame again by three fixed markers" in str(caught.value)
    assert "scan the vented surface once" in str(caught.value)


def test_the_short_form_in_a_diagnosis(doubt) -> None:
    """An open diagnosis gets the programme's probes and minutes; a clear one stays as it is."""
    run, model, found = doubt
    summary = {**found, "next_experiment": {"separates": ["hysteresis", "creep"], "probes": ["a text"]}}
    plan_next(run, model, summary)
    planned = summary["next_experiment"]
    assert planned["probes"] == ["a text"]
    assert set(planned) == {"separates", "probes", "programme", "minutes", "captures", "why"}
    assert all(set(p) == {"probe", "separates", "times", "minutes"} for p in planned["programme"])
    clear = {"verdict": "identified", "next_experiment": None}
    plan_next(run, model, clear)
    assert clear["next_experiment"] is None


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


def test_a_probe_knows_how_long_it_takes() -> None:
    """Ways at the slowest chamber's rate, and holds."""
    limits = Limits(np.zeros(2), np.array([60.0, 30.0]), np.array([30.0, 10.0]))
    probe = Probe("p", "s", (Point((0.5, 0.5), 4.0), Point((0.0, 0.0), 2.0)))
    assert probe.seconds(limits) == pytest.approx(1.5 + 4.0 + 1.5 + 2.0)
