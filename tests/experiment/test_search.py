"""How a programme is searched for: what is asked of its probes, and which of them are chosen."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import SURE, calibration, diagnose, prepared, rows_from
from labrig.experiment import Experiment, Limits, _propose, propose_experiment
from labrig.experiment._plan import Point
from labrig.experiment._problem import Problem
from labrig.experiment._search import Chosen
from labrig.model import Model

from .conftest import ROWS_S, leaking, looped, open_between


def test_a_map_for_each_session_is_one_for_all_that_is_planned(make_lab) -> None:
    """A static base that is fitted in each session: the probes are one session together, and tell names apart."""
    lab = make_lab(chambers=2, captures=40, rows_s=ROWS_S, sessions=2)
    path = lab.folder / "static.yaml"
    path.write_text("base: {kind: static, degree: 2, in_each_session: true}\n")
    summary = propose_experiment(
        lab.dataset(looped(lab) + lab.noise()),
        Model.load(path),
        summary=open_between("hysteresis", "creep"),
        minutes=4,
    ).summary
    assert all(e["settles"] for e in summary["expected"])
    assert summary["minutes"] <= 4


MEMORY = """
import numpy as np

def predict(u, t):
    out = np.zeros(len(u))
    for i in range(1, len(u)):
        out[i] = u[i, 0] + (out[i - 1] - u[i, 0]) * np.exp(-(t[i] - t[i - 1]) / 3.0)
    return out
"""


def test_each_programme_has_its_own_history(make_lab) -> None:
    """A base with memory predicts a programme as if it were alone, whatever else is asked about beside it."""
    lab = make_lab(chambers=1, force=True, captures=30, rows_s=ROWS_S)
    (lab.folder / "lag.py").write_text(MEMORY)
    path = lab.folder / "lag.yaml"
    path.write_text("base: {kind: python, file: lag.py, function: predict, memory: record}\n")
    rows, model = rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), Model.load(path)
    problem = Problem(prepared(rows, model), model.predictor(rows), Limits.of(rows))
    low, high = [Point((0.2,), 4.0)], [Point((0.9,), 4.0), Point((0.1,), 4.0)]
    alone, _ = problem.joint([high])
    both, planned = problem.joint([low, high])
    n = len(rows.capture)
    assert both.base[n:][planned.owner == 1] == pytest.approx(alone.base[n:])
    assert both.rows.sessions[-1].endswith("planned")
    assert len(both.rows.sessions) == len(rows.sessions) + 1


def test_a_proposal_has_the_floor_of_the_diagnosis(make_lab, few_effects) -> None:
    """Of one observable the noise is what no effect can follow, also where repeats happen to be alike."""
    few_effects("leak", "creep", "drift", "regulator")
    lab = make_lab(chambers=2, force=True, captures=60, rows_s=ROWS_S)
    noise = lab.noise(0.05, 0.4)
    again = [i for i, label in enumerate(lab.label) if label]
    noise[again] *= 0.1
    run = lab.dataset(leaking(lab) + noise)
    found = diagnose(run, lab.model()).summary["error"]["floor"]
    proposed = propose_experiment(
        run, lab.model(), summary=open_between("leak", "creep"), minutes=3, changes=0
    ).summary
    assert prepared(rows_from(run), lab.model()).floor.mean[0] < 0.5 * found
    assert proposed["floor"] == pytest.approx(found, rel=0.25)


@pytest.fixture(scope="module")
def chosen(doubt: Any) -> tuple[Problem, Chosen]:
    """What a proposal asked and what was chosen, where each probe is a candidate twice."""
    run, model, _ = doubt
    kept: list[tuple[Problem, Chosen]] = []
    search, named = _propose.search_programme, _propose.for_names

    def asked(problem: Problem, seeds: Any, *more: Any, **settings: Any) -> Any:
        return search(problem, [*seeds] * 2, *more, **settings)

    def found_it(asked_for: Any, problem: Problem, choice: Chosen) -> Experiment:
        kept.append((problem, choice))
        return named(asked_for, problem, choice)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_propose, "search_programme", asked)
        patch.setattr(_propose, "for_names", found_it)
        propose_experiment(run, model, summary=open_between("hysteresis", "creep"), minutes=15, changes=1)
    return kept[-1]


def test_evidence_is_asked_for_until_the_true_one_is_stated_to_be_sure(
    chosen: tuple[Problem, Chosen],
) -> None:
    """What is stated has less of the odds than evidence gives, so that so much more of it is a goal."""
    problem, _ = chosen
    odds = [problem.rivals[m].probability / problem.rivals[n].probability for m, n in problem.pairs]
    by_evidence = np.array(odds) * np.exp(problem.goals)
    assert [calibration().stated(one / (1 + one)) for one in by_evidence] == pytest.approx([SURE] * len(odds))


def test_no_probe_is_done_twice(chosen: tuple[Problem, Chosen]) -> None:
    """What a change of one probe gives may be another probe: it is one candidate, and is done once."""
    _, choice = chosen
    points = [probe.points for probe in choice.probes]
    assert len(points) > 1
    assert len(set(points)) == len(points)


def test_what_is_open_is_settled_three_times_over(chosen: tuple[Problem, Chosen]) -> None:
    """Each time by other probes: the programme falls into three parts, each of which settles every pair."""
    problem, choice = chosen
    parts, together = 0, None
    for outlook in choice.outlooks:
        together = outlook if together is None else together.beside(outlook).condensed()
        if (problem.log_bayes(together) >= problem.goals).all():
            parts, together = parts + 1, None
    assert parts == 3
    assert together is None
