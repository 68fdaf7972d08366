"""What explanations expect of captures that were not measured yet: against the dense way, and against what came."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import Explained, prepared, rows_from
from labrig.diagnosis._design import DECLARED, SLOW, design_of
from labrig.diagnosis._observations import observe
from labrig.diagnosis._posterior import DECLARED_FLOORS
from labrig.experiment import Limits
from labrig.experiment._plan import Point, planned_rows
from labrig.experiment._problem import join_contexts

ROWS_S = (1.2, 2.0, 3.0, 4.0)
POINTS = [Point((0.8,), 8.0), Point((0.2,), 4.0)]
ORDER = ["leak", "creep"]


def leaking(lab: Any) -> np.ndarray:
    """An orifice: the root of the pressure falls in a straight line."""
    return lab.predict(np.maximum(np.sqrt(lab.u) - 0.02 * lab.hold_s[:, :, None], 0.0) ** 2)


@pytest.fixture
def asked(make_lab) -> tuple[Any, ...]:
    """A leaking chamber that was measured, a programme of two points, and all that explanations are asked with."""
    lab = make_lab(chambers=1, force=True, captures=30, rows_s=ROWS_S)
    rows = rows_from(lab.dataset(leaking(lab) + lab.noise()))
    model = lab.model()
    ready, predictor = prepared(rows, model), model.predictor(rows)
    explained = Explained(ready, {n: e for n, e in model.library().items() if n in ORDER})
    planned = planned_rows(ready.context.rows, [POINTS, POINTS[:1]], Limits.of(rows))
    joint = join_contexts(ready.context, predictor.context(planned.rows))
    return explained, joint, planned


def dense(
    explained: Explained, joint: Any, declared: Any, number: int, owner: Any, form: Any
) -> tuple[Any, Any]:
    """Mean and covariance of a programme's observations by one Gaussian over all observations, in floors."""
    residual = np.zeros(joint.base.shape)
    residual[: len(explained.ready.residual)] = explained.ready.residual
    observations = explained._beside(observe(joint, residual, explained.ready.floor))
    design = design_of(observations, explained.effects, declared)
    known = observations.capture < explained.observations.n_captures
    sizes = {(o, explained.design.blocks[b].space.key): size for o, b, size in form.raised}
    spaces = [b.owner for b in design.blocks]
    prior = np.zeros((len(known), len(known)))
    for block in design.blocks:
        W, key = design.W.of(block.at), block.space.key
        square = explained.search.spike**2 / spaces.count(block.owner)
        if block.owner == SLOW:
            square = form.slow**2
        elif (block.owner, key) in sizes:
            run = next(b for b in explained.design.blocks if (b.owner, b.space.key) == (block.owner, key))
            square = sizes[block.owner, key] ** 2
            square *= np.sum(explained.design.W.of(run.at) ** 2) / np.sum(W[known] ** 2)
        prior += square * W @ W.T
    for free in design.free:
        if free.owner == DECLARED:
            prior += DECLARED_FLOORS**2 * free.G @ free.G.T
    noisy = prior[np.ix_(known, known)] + np.eye(known.sum()) / explained.observations.worth
    rows = np.concatenate([np.full(len(explained.ready.residual), -1), owner])
    ahead = rows[observations.first][observations.capture] == number
    gain = np.linalg.solve(noisy, prior[np.ix_(known, ahead)]).T
    mean = gain @ observations.values[known, 0] * design.V[0, 0]
    weight = recorded(observations, ahead)
    covariance = prior[np.ix_(ahead, ahead)] - gain @ prior[np.ix_(known, ahead)]
    return weight * mean, weight[:, None] * covariance * weight


def recorded(observations: Any, ahead: Any) -> np.ndarray:
    """What brings planned holds of three rows, or of six, to the three contrasts of a measured one of four."""
    rows = np.bincount(observations.index)[observations.capture]
    means = np.arange(len(rows)) < observations.n_captures
    return np.where(means, 1.0, np.sqrt(3 / np.maximum(rows - 1, 1)))[ahead]


@pytest.mark.parametrize("declares", [False, True])
@pytest.mark.parametrize("number", [0, 1])
def test_it_is_the_conditional_gaussian(asked, declares: bool, number: int) -> None:
    """Means and covariances are those of one Gaussian over everything, given what was measured."""
    explained, joint, planned = asked
    declared = np.stack([np.ones(len(joint.base)), joint.rows.actuation[:, 0]], axis=1) if declares else None
    forms = [explained.forms([name], 1)[0] for name in ORDER]
    outlook = explained.outlooks(joint, declared, None, planned.owner, forms)[number]
    for m, form in enumerate(forms):
        mean, covariance = dense(explained, joint, declared, number, planned.owner, form)
        assert outlook.mean[m] == pytest.approx(mean, rel=1e-4, abs=1e-4)
        assert outlook.factor[m] @ outlook.factor[m].T == pytest.approx(covariance, rel=1e-3, abs=1e-3)


def test_what_comes_is_what_the_truth_expects(make_lab, asked) -> None:
    """The forecast of a leak is near to what a leaking chamber shows in longer holds, that of creep is not."""
    explained, joint, planned = asked
    leak, creep = (explained.forms([name], 1)[0] for name in ORDER)
    outlook = explained.outlooks(joint, None, None, planned.owner, [leak, creep])[0]
    hold_s = planned.rows.hold_s[planned.owner == 0]
    u = planned.rows.actuation[planned.owner == 0, 0]
    lab = make_lab(chambers=1, force=True, captures=30, rows_s=ROWS_S)
    lost = np.maximum(np.sqrt(u) - 0.02 * hold_s, 0.0) ** 2
    change = (lab.predict(lost[:, None]) - lab.predict(u[:, None]))[:, 0]
    observations = observe(joint, np.zeros(joint.base.shape), explained.ready.floor)
    rows = np.zeros(len(joint.base))
    rows[np.flatnonzero(planned.owner == 0) + len(joint.base) - len(planned.owner)] = (
        change / explained.observations.unit[0]
    )
    came = (observations.whiten @ rows)[: len(observations.values)]
    of_row = np.concatenate([np.full(len(joint.base) - len(planned.owner), -1), planned.owner])
    own = of_row[observations.first][observations.capture] == 0
    came = recorded(observations, own) * came[own]
    off = np.linalg.norm(outlook.mean - came, axis=1)
    assert off[0] < 0.3 * off[1]
    assert off[0] < 0.3 * np.linalg.norm(came)


def test_forms_of_effects(asked) -> None:
    """An explanation's forms are those of exactly its effects, likeliest first; none where one can't act."""
    explained, *_ = asked
    forms = explained.forms(["leak"], 3)
    assert [f.score for f in forms] == sorted((f.score for f in forms), reverse=True)
    assert len({frozenset(number for _, number, _ in f.raised) for f in forms}) == 3  # not one in three sizes
    assert {o for f in forms for o, _, size in f.raised if size not in explained.search.traces} == {"leak"}
    pair = explained.forms(["leak", "creep"], 1)[0]
    assert {o for o, _, size in pair.raised if size not in explained.search.traces} == {"leak", "creep"}
    assert explained.forms(["leak", "gravity"], 1) == []
    assert [o for o, _, s in explained.forms([], 1)[0].raised if s not in explained.search.traces] == []


def test_programmes_that_repeat_what_was_measured_have_no_new_conditions(asked) -> None:
    """A programme's numbers count by its new conditions: none, where the run has measured all of them."""
    explained, joint, planned = asked
    form = explained.forms(["leak"], 1)
    new = explained.outlooks(joint, None, None, planned.owner, form)[0]
    assert len(new.conditions) >= 4
    n = len(explained.ready.residual)
    event = joint.rows.event.copy()
    first = np.flatnonzero(explained.ready.context.rows.capture == 5)
    hold_s = joint.rows.hold_s.copy()
    actuation = joint.rows.actuation.copy()
    for k, row in enumerate(range(n, len(event))):
        source = first[k % len(first)]
        event[row], hold_s[row], actuation[row] = event[source], hold_s[source], actuation[source]
    again = replace(
        joint, rows=replace(joint.rows, event=event, hold_s=hold_s, actuation=actuation), _memo={}
    )
    old = explained.outlooks(again, None, None, planned.owner, form)[0]
    assert old.conditions == frozenset()
    assert old.numbers == new.numbers


def test_a_limit_stays_where_it_was_when_more_is_planned(make_lab) -> None:
    """A stop at two thirds of the travel that was measured is still there, where the programme goes twice as far."""
    lab = make_lab(chambers=2, markers=4, captures=40, rows_s=ROWS_S, repeats=False)
    lab.commanded[:] *= 0.5
    rest = lab.predict(np.zeros((1, 2)))

    def travel(u: np.ndarray) -> np.ndarray:
        return np.linalg.norm(lab.predict(u) - rest, axis=-1)

    limit = 0.67 * travel(lab.u.reshape(-1, 2)).max()

    def stopped(u: np.ndarray) -> np.ndarray:
        """A soft stop: the travel bends towards its limit."""
        return rest + (lab.predict(u) - rest) * (1 + (travel(u) / limit) ** 8)[..., None] ** (-1 / 8)

    rows = rows_from(lab.dataset(stopped(lab.u) + lab.noise()))
    model = lab.model()
    ready, predictor = prepared(rows, model), model.predictor(rows)
    explained = Explained(ready, {"contact": model.library()["contact"]})
    within, beyond = [Point((0.4, 0.4), 4.0)], [Point((0.9, 0.9), 4.0)]
    planned = planned_rows(ready.context.rows, [within, beyond], Limits.of(rows))
    joint = join_contexts(ready.context, predictor.context(planned.rows))
    forms = explained.forms(["contact"], 1)
    outlook = explained.outlooks(joint, None, None, planned.owner, forms)[0]
    u = planned.rows.actuation[:1]
    change = np.linalg.norm((stopped(u) - lab.predict(u)).reshape(-1) / explained.observations.unit)
    assert np.linalg.norm(outlook.mean[0]) == pytest.approx(change, rel=0.15)


def test_what_was_not_seen_in_the_campaign_is_filled_as_without_a_programme(make_lab) -> None:
    """Markers hidden in some captures: their values are filled from the campaign alone, not from what is planned."""
    lab = make_lab(chambers=1, markers=4, captures=30, rows_s=ROWS_S)
    values = leaking(lab) + lab.noise() + 2.0
    hidden = np.random.default_rng(5).random((30, 4)) < 0.2
    values[np.broadcast_to(np.repeat(hidden, 3, axis=1)[:, None], values.shape)] = np.nan
    rows, model = rows_from(lab.dataset(values)), lab.model()
    explained = Explained(prepared(rows, model), {"leak": model.library()["leak"]})
    planned = planned_rows(explained.ready.context.rows, [POINTS], Limits.of(rows))
    joint = join_contexts(explained.ready.context, model.predictor(rows).context(planned.rows))
    residual = np.zeros(joint.base.shape)
    residual[: len(explained.ready.residual)] = explained.ready.residual
    both = explained._beside(observe(joint, residual, explained.ready.floor))
    known = both.capture < explained.observations.n_captures
    assert both.values[known] == pytest.approx(explained.observations.values)
    assert not both.values[~known].any()
    assert both.to_explain == explained.observations.to_explain
    assert both.worth == explained.observations.worth
