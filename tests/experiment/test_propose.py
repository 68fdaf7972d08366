"""The next experiment: what is proposed, and that the diagnosis with it is right. All formulas are the tests' own."""

import re
from collections.abc import Callable
from typing import Any, cast

import numpy as np
import pytest

from labrig import LabrigError
from labrig.diagnosis import Explained, covariates, diagnose, prepared, rows_from
from labrig.diagnosis._unnamed import unnamed
from labrig.experiment import Experiment, Limits, _propose, plan_next, propose_experiment
from labrig.experiment._rivals import open_rivals, open_sets
from labrig.experiment._search import CHANGES
from labrig.experiment._unknown import _covariates_of

from .conftest import (
    ROWS_S,
    Values,
    leaking,
    long_holds,
    looped,
    measured,
    one_level,
    open_between,
    probabilities,
)


@pytest.mark.parametrize(
    ("name", "values", "rivals", "campaign"),
    [
        ("hysteresis", looped, ("regulator", "friction"), one_level),
        ("leak", leaking, ("creep", "drift"), long_holds),
    ],
)
def test_with_the_experiment_the_right_name_comes_first(
    make_lab, name: str, values: Values, rivals: tuple[str, ...], campaign: Callable[[Any], Any]
) -> None:
    """On and off at one level many names are alike; with the proposed programme the right one is ahead of the rest."""
    lab = campaign(make_lab)
    model, run = lab.model(), lab.dataset(values(lab) + lab.noise(0.05, 0.05))
    experiment = propose_experiment(run, model, summary=open_between(name, *rivals), changes=0)
    others = set(model.library()) - {name, *rivals}
    both = diagnose([run, measured(lab, experiment, values)], model, without=others).summary
    assert probabilities(both)[name] > max(probabilities(both)[r] for r in rivals)
    assert not set(rivals) & set(both["effects"])


LIMITS = Limits(np.zeros(2), np.array([60.0, 40.0]), np.full(2, 50.0))


@pytest.fixture(scope="module")
def proposed(doubt) -> Experiment:
    """What is proposed where three explanations are open, limits are narrower than the run's, and time is short."""
    run, model, found = doubt
    return propose_experiment(run, model, summary=found, limits=LIMITS, minutes=2, changes=0)


@pytest.fixture(scope="module")
def short(doubt) -> Experiment:
    """The same in half a minute."""
    run, model, found = doubt
    return propose_experiment(run, model, summary=found, limits=LIMITS, minutes=0.5)


def test_what_is_proposed(doubt, proposed: Experiment, short: Experiment) -> None:
    """Every pair has an expectation, every probe its share; times add up, limits are kept, and it is the same twice."""
    run, model, found = doubt
    summary = proposed.summary
    titles = {"hysteresis", "creep", "friction"}
    assert {(e["true"], e["other"]) for e in summary["expected"]} == {
        (a, b) for a in titles for b in titles if a != b
    }
    assert summary["separates"] == ["hysteresis", "creep", "friction"]
    assert sum(p["minutes"] for p in summary["probes"]) == pytest.approx(summary["minutes"], abs=0.02)
    assert summary["minutes"] <= 2
    assert summary["captures"] == len(proposed.points) == len(proposed.programme())
    assert min(e["floors"] for e in summary["expected"]) > 0
    pressures = np.array([proposed.limits.actuation(p.share) for p in proposed.points])
    assert (pressures >= LIMITS.low).all()
    assert (pressures <= LIMITS.high).all()
    assert pressures == pytest.approx(np.array([p.share for p in proposed.points]) * LIMITS.high, abs=0.01)
    again = propose_experiment(run, model, summary=found, limits=LIMITS, minutes=0.5)
    assert again.programme() == short.programme()


def test_what_is_sure_stands_beside_each_that_is_possible(doubt) -> None:
    """A sure effect is told apart alone and with each possible one; what it can do alone, it can do with one more."""
    run, model, _ = doubt
    one = {"effect": "creep", "probability": 0.3, "call": "possible"}
    other = {"effect": "friction", "probability": 0.2, "call": "possible"}
    found = open_between(verdict="identified", effects=["hysteresis"], effects_considered=[one, other])
    summary = propose_experiment(run, model, summary=found, minutes=4, changes=0).summary
    creep, friction = "hysteresis + creep", "hysteresis + friction"
    pairs = {(creep, "hysteresis"), (creep, friction), (friction, "hysteresis"), (friction, creep)}
    assert {(e["true"], e["other"]) for e in summary["expected"]} == pairs
    assert summary["separates"] == ["hysteresis", "creep", "friction"]


def test_probabilities_are_the_diagnosis_own(doubt) -> None:
    """Explanations weigh as the diagnosis says; the only name is told from the next one, or at least from none."""
    run, model, _ = doubt
    library = model.library()

    def explanations(sure: list[str], **possible: float) -> dict[str, float]:
        calls = [("not it", "possible")[p >= 0.1] for p in possible.values()]
        considered = [
            {"effect": n, "probability": p, "call": call}
            for (n, p), call in zip(possible.items(), calls, strict=True)
        ]
        rivals = [c["effect"] for c in considered if c["call"] == "possible" and not sure]
        sets = open_sets(library, {"effects": sure, "rivals": rivals, "effects_considered": considered})
        names = {n for each, _ in sets for n in each}
        explained = Explained(prepared(rows_from(run), model), {n: library[n] for n in names})
        rivals = open_rivals(explained, sets)
        assert all(r.weight.sum() == pytest.approx(1.0) for r in rivals)
        return {r.title: pytest.approx(r.probability) for r in rivals}

    assert explanations([], creep=0.6, friction=0.2) == {"creep": 0.75, "friction": 0.25}
    beside = explanations(["hysteresis"], creep=0.3, leak=0.02)
    assert beside == {"hysteresis + creep": 0.3, "hysteresis": 0.7}
    assert set(explanations([], creep=0.8, friction=0.05)) == {"creep", "friction"}
    assert set(explanations([], creep=0.8)) == {"creep", "no effect"}
    assert set(explanations(["hysteresis"], creep=0.02, leak=0.05)) == {"hysteresis", "leak"}
    assert explanations(["hysteresis"], creep=0.002) == {}


def test_partners_are_told_from_each_of_them_alone() -> None:
    """Of effects that fit together it is open whether all of them are there: each is left out in turn, no more."""
    considered = [
        {"effect": name, "probability": p, "call": "possible"}
        for name, p in (("leak", 0.5), ("drift", 0.3), ("tension", 0.2))
    ]
    summary = {"effects": [], "rivals": ["leak", "drift", "tension"], "effects_considered": considered}
    library = dict.fromkeys(("leak", "drift", "tension"), cast("Any", None))
    sets = open_sets(library, cast("Any", summary | {"together": ["leak", "drift"]}))
    assert [names for names, _ in sets] == [("leak", "drift"), ("drift",), ("leak",)]
    assert [p for _, p in sets] == pytest.approx([0.15, 0.15, 0.35])
    alone = open_sets(library, cast("Any", summary))
    assert [names for names, _ in alone] == [("leak",), ("drift",), ("tension",)]


def test_more_time_tells_more(proposed: Experiment, short: Experiment) -> None:
    """The weakest expectation does not fall when the programme may be longer."""
    weakest = [min(e["log10_bayes"] for e in each.summary["expected"]) for each in (proposed, short)]
    assert weakest[0] > weakest[1]


def test_what_has_no_name_is_looked_for_where_least_is_known(make_lab) -> None:
    """After captures of one level only, the programme for an unknown error goes to other levels and visits twice."""
    lab = one_level(make_lab)
    model, run = lab.model(), lab.dataset(looped(lab) + lab.noise())
    found = open_between(verdict="unknown", carried_by="pressures together")
    experiment = propose_experiment(run, model, summary=found, minutes=3)
    levels = {tuple(np.round(p.share, 2)) for p in experiment.points}
    assert len(levels) >= 6
    assert all(p["times"] == 2 for p in experiment.summary["probes"])
    assert "carried by pressures together" in experiment.summary["why"]
    assert experiment.summary["minutes"] <= 3


def test_every_word_for_what_has_no_name_has_covariates_of_its_own(make_lab) -> None:
    """Each word that a diagnosis may use is looked for in a set of covariates that exists: all three sets are used."""
    lab = make_lab(captures=30, rows_s=ROWS_S)
    context = prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), lab.model()).context
    sets = {_covariates_of(space.key): space.key for space in unnamed(context)}
    assert set(sets) <= set(covariates(context))
    assert len(sets) == 3


def test_too_few_data_ask_for_more(make_lab, few_effects) -> None:
    """Where an effect of the tolerance could hide, or captures are few, a programme that visits all twice is."""
    few_effects("leak", "creep", "drift", "regulator")
    lab = make_lab(captures=16, chambers=1, force=True)
    model, run = lab.model(), lab.dataset(lab.predict(lab.u) + lab.noise())
    experiment = propose_experiment(run, model, tolerance=0.001, minutes=2)
    assert experiment.summary["verdict"] == "underpowered"
    assert 0 < experiment.summary["minutes"] <= 2
    assert len([label for label in experiment.repeats if label]) > 2
    few = run.isel(capture=slice(2), event=slice(2))
    experiment = propose_experiment(few, model, minutes=2)
    assert experiment.summary["verdict"] == "underpowered"
    assert len([label for label in experiment.repeats if label]) > 2


def test_clear_verdicts_need_no_experiment(make_lab, few_effects) -> None:
    """Nothing missing, or identified with no other effect near: said in one line."""
    few_effects("leak", "creep", "drift")
    lab = make_lab(chambers=2, captures=40)
    model, run = lab.model(), lab.dataset(lab.predict(lab.u) + lab.noise())
    with pytest.raises(LabrigError) as caught:
        propose_experiment(run, model)
    assert str(caught.value) == "the verdict is nothing_missing: it leaves nothing to settle"
    assert caught.value.exit_code == 4
    considered = [{"effect": "leak", "probability": 0.99, "call": "sure"}]
    considered += [{"effect": "creep", "probability": 0.002, "call": "not it"}]
    sure = {"verdict": "identified", "effects": ["leak"], "rivals": [], "effects_considered": considered}
    with pytest.raises(LabrigError) as caught:
        propose_experiment(run, model, summary=sure)
    assert str(caught.value) == (
        "the verdict is identified and no other effect comes near: there is nothing to settle; check it at other "
        "set-points (of a rig that labrig runs: labrig run capture, with another seed)"
    )
    with pytest.raises(LabrigError) as caught:
        propose_experiment(run, model, minutes=0)
    assert str(caught.value) == "an experiment of 0 min: give it some time"


def test_what_is_not_done_in_the_time_is_not_proposed(doubt) -> None:
    """Where nothing has a name, too, a programme takes no longer than it may: the shortest that there is is named."""
    run, model, _ = doubt
    found = {**open_between(), "verdict": "unknown", "carried_by": None}
    with pytest.raises(LabrigError) as caught:
        propose_experiment(run, model, summary=found, minutes=0.2)
    said = re.fullmatch(
        r"no programme takes 0\.2 min or less: the shortest takes (\d\.\d+)", str(caught.value)
    )
    assert said
    least = float(said[1]) + 0.01
    assert propose_experiment(run, model, summary=found, minutes=least).summary["minutes"] <= least


def test_a_tolerance_is_not_for_a_diagnosis_that_is_given(doubt) -> None:
    """It was made with its own: another one beside it is refused, not left aside."""
    run, model, found = doubt
    with pytest.raises(LabrigError) as caught:
        propose_experiment(run, model, summary=found, tolerance=0.1)
    assert str(caught.value) == (
        "tolerance is for a diagnosis that is made here, and one is given: it has its own"
    )


def test_what_may_be_there_beside_three_that_are_sure(doubt) -> None:
    """More than three effects are not compared at once: the way is to add those that are sure first."""
    run, model, _ = doubt
    fourth = [{"effect": "coupling", "probability": 0.3, "call": "possible"}]
    sure = ["hysteresis", "creep", "friction"]
    found = open_between(verdict="multiple", effects=sure, effects_considered=fourth)
    with pytest.raises(LabrigError) as caught:
        propose_experiment(run, model, summary=found, minutes=4)
    assert str(caught.value) == (
        "the verdict is multiple and coupling may be there beside it: more at once than can be told apart; add what is "
        "sure to the model (labrig improve), and diagnose again"
    )


def test_a_base_that_ignores_the_pressures_is_refused(make_lab) -> None:
    """A model that predicts the same at all pressures can judge no programme: it is said so, with what to do."""
    lab = make_lab(captures=30, rows_s=ROWS_S)
    run = lab.dataset(lab.predict(lab.u) + lab.noise())
    lab.reach = 0 * lab.reach
    with pytest.raises(LabrigError) as caught:
        propose_experiment(run, lab.model(), minutes=2)
    assert str(caught.value).startswith("the model predicts the same at all pressures: ")
    assert "base: {kind: static, degree: 1}" in str(caught.value)


def test_what_no_programme_tells_is_for_a_person(make_lab) -> None:
    """Where there is no time to tell two effects apart it is said so, with what to do by hand."""
    lab = make_lab(captures=40, markers=4)
    model, run = lab.model(), lab.dataset(lab.predict(lab.u) + 0.8 + lab.noise())
    with pytest.raises(LabrigError) as caught:
        propose_experiment(run, model, summary=open_between("frame", "rest_shape"), minutes=0.1)
    start = (
        "no programme of 0.1 min within the rig's limits tells frame and rest_shape apart; by hand: frame: "
    )
    assert str(caught.value).startswith(start)
    assert "register the measuring frame again by three fixed markers" in str(caught.value)
    assert "scan the vented surface once" in str(caught.value)


def test_what_evidence_is_sure_of_is_to_be_tried(make_lab) -> None:
    """Where no programme tells, and evidence is sure of a name already, the way on is to add it and to predict."""
    lab = make_lab(captures=40, markers=4)
    model, run = lab.model(), lab.dataset(lab.predict(lab.u) + 0.8 + lab.noise())
    considered = [
        {"effect": "frame", "probability": 0.6, "call": "possible", "by_evidence": 0.99},
        {"effect": "rest_shape", "probability": 0.2, "call": "possible", "by_evidence": 0.01},
        {"effect": "leak", "probability": 0.9, "call": "sure", "by_evidence": 0.99},
    ]
    summary = open_between("frame", "rest_shape", effects_considered=considered)
    with pytest.raises(LabrigError) as caught:
        propose_experiment(run, model, summary=summary, minutes=0.1)
    assert str(caught.value).endswith(
        "; what was measured is as clear on frame as it gets: add it (labrig improve), and see whether it predicts a "
        "run with other set-points better (labrig compare)"
    )


def test_what_says_too_little_is_not_proposed(make_lab) -> None:
    """A programme for which there is time, and after which the odds of two names were as before: of a run without any
    error neither a frame nor a shape predicts more than noise. That the frame was registered anew was tried already.
    """
    lab = make_lab(chambers=2, captures=30, rows_s=ROWS_S)
    model, run = lab.model(), lab.dataset(looped(lab) + lab.noise())
    tried = [{"effect": "frame", "probability": 0.5, "call": "possible", "gone": 0.95}]
    summary = open_between("frame", "rest_shape", effects_considered=tried)
    exact = lab.dataset(lab.predict(lab.u) + lab.noise())
    with pytest.raises(LabrigError) as caught:
        propose_experiment(exact, model, summary=summary, minutes=0.4)
    assert str(caught.value).startswith(
        "no programme of 0.4 min within the rig's limits tells frame and rest_shape apart; by hand: "
    )
    assert propose_experiment(
        run, model, summary=open_between("hysteresis", "friction"), minutes=0.4, changes=0
    ).summary["captures"]


def test_the_short_form_in_a_diagnosis(doubt) -> None:
    """An open diagnosis gets the programme's probes and minutes; a clear one stays as it is."""
    run, model, _ = doubt
    found = open_between("hysteresis", "creep")
    summary = {**found, "next_experiment": {"separates": ["hysteresis", "creep"], "probes": ["a text"]}}
    plan_next(run, model, summary)
    planned = summary["next_experiment"]
    assert planned["probes"] == ["a text"]
    assert set(planned) == {"separates", "probes", "programme", "minutes", "captures", "why", "unsettled"}
    assert all(" from " in pair for pair in planned["unsettled"])
    assert all(set(p) == {"probe", "separates", "times", "minutes"} for p in planned["programme"])
    clear = {"verdict": "identified", "next_experiment": None}
    plan_next(run, model, clear)
    assert clear["next_experiment"] is None


def test_the_short_form_has_the_canonical_probes(doubt, monkeypatch: pytest.MonkeyPatch) -> None:
    """A diagnosis does not wait for probes that are changed and chosen from again; a proposal does."""
    run, model, _ = doubt
    asked: list[int] = []
    monkeypatch.setattr(_propose, "search_programme", lambda *_, changes: asked.append(changes))
    found = open_between("hysteresis", "creep")
    plan_next(run, model, {**found, "next_experiment": {"separates": [], "probes": []}})
    with pytest.raises(LabrigError, match="no programme"):
        propose_experiment(run, model, summary=found)
    assert asked == [0, CHANGES]


def test_what_another_form_would_hold_is_not_promised(make_lab) -> None:
    """Of one chamber a gain of its sensor is any curve of the pressure: no programme promises ten decades.

    The plain forms of both names differ by hundreds of floors where nothing was measured; their families do not.
    """
    lab = make_lab(chambers=1, force=True, captures=26, rows_s=ROWS_S, repeats=False)
    model, run = lab.model(), lab.dataset(lab.predict(1.08 * lab.u) + lab.noise(0.01, 0.01))
    summary = propose_experiment(run, model, summary=open_between("regulator", "tension")).summary
    assert {each["true"] for each in summary["expected"]} == {"regulator", "tension"}
    assert max(each["log10_bayes"] for each in summary["expected"]) < 10
