"""Where repeats say little: the noise of few observables, twins without a name, and what nothing follows."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from labrig.diagnosis import diagnose
from labrig.diagnosis._constants import FLOOR_SPREAD
from labrig.diagnosis._design import design_of
from labrig.diagnosis._diagnose import laid_out, verdict_on
from labrig.diagnosis._names import has_name, spans
from labrig.diagnosis._noise_scale import _SCALES, _SIZES, everything, noise_of_few, noise_scale
from labrig.diagnosis._observations import observe
from labrig.diagnosis._problem import prepared, rows_from
from labrig.effects._family import Space, pattern, pressure
from tests.sensors import model_of_both, two_sensors


@pytest.mark.parametrize("wrong", [0.5, 1.0, 2.0])
def test_a_floor_that_is_wrong_is_put_right(make_lab, wrong: float) -> None:
    """Of one force beside a leak by an orifice, the noise comes back, whatever few repeats said."""
    lab = make_lab(chambers=1, force=True, captures=80, long_s=(3.0, 8.0, 20.0))
    lost = np.sqrt(lab.u) * 0.02 * lab.hold_s[:, :, None]
    model = lab.model()
    ready = prepared(rows_from(lab.dataset(lab.predict(lab.u - lost) + lab.noise())), model)
    alone = prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), model)
    true = (
        observe(alone.context, alone.residual, alone.floor).values[: lab.captures].std() * alone.floor.mean[0]
    )
    floor = replace(ready.floor, mean=np.full(1, wrong * true), freedom=np.ones(1, dtype=int))
    again = noise_of_few(design_of(observe(ready.context, ready.residual, floor), model.library()))
    assert again.mean[0] == pytest.approx(true, rel=0.3)


def test_what_has_a_name_is_not_unnamed_as_well() -> None:
    """A space in another's span is left out; one with a direction of its own, or of another kind, stays."""
    t = np.linspace(0, 1, 200)
    named = [spans(Space("named", "named", (pattern("one", np.ones(200)), pattern("two", t))))]
    assert has_name(Space("a", "a", (pattern("tilted", 3 - 2 * t),)), named)
    assert not has_name(Space("b", "b", (pattern("wave", np.cos(9 * t)),)), named)
    assert not has_name(Space("c", "c", (pressure("pressure", np.ones((200, 1))),)), named)


def test_what_nothing_follows_is_unknown(make_lab, few_effects) -> None:
    """An error by chance for each set-point, the same when it is repeated, is no noise and has no name."""
    few_effects("frame", "rest_shape", "creep", "drift", "regulator", "hysteresis")
    lab = make_lab(chambers=2, captures=60)
    values = lab.predict(lab.u)
    for i, u in enumerate(lab.commanded):
        seed = int(1000 * np.abs(u).sum())
        values[i] += np.random.default_rng(seed).normal(size=values.shape[2:]) * 1.0
    summary = diagnose(lab.dataset(values + lab.noise()), lab.model()).summary
    assert summary["verdict"] == "unknown"
    assert summary["unnamed"]["nothing that was recorded"] > 0.4


def test_the_scale_is_that_of_the_dense_covariance(make_lab) -> None:
    """From thin columns the same scale comes as from Gaussian densities with their whole covariance."""
    lab = make_lab(chambers=1, force=True, captures=240)
    model, rows = lab.model(), rows_from(lab.dataset(lab.predict(lab.u) + 2.0 * lab.noise()))
    ready = prepared(rows, model)
    design = design_of(observe(ready.context, ready.residual, ready.floor), {"leak": model.library()["leak"]})
    n, r = design.observations.n_captures, design.V.shape[1]
    columns = everything(design, np.arange(n), np.asarray(design.V, dtype=float))
    assert columns.shape[0] > np.linalg.matrix_rank(columns)  # some noise lies beside all columns
    values = (design.observations.values @ design.V)[:n].reshape(-1)
    few = min(1.0 / np.sqrt(max(design.observations.floor.freedom[0], 1)), 2 * FLOOR_SPREAD)
    upper = design.observations.floor.upper[0] / design.observations.unit[0]
    log = []
    for scale in _SCALES:
        each = [
            multivariate_normal(cov=size**2 * columns @ columns.T + scale**2 * np.eye(n * r)).logpdf(values)
            for size in _SIZES
        ]
        log.append(logsumexp(each) - 0.5 * (np.log(scale) / (few if scale > 1 else FLOOR_SPREAD)) ** 2)
        log[-1] -= np.inf if scale > upper else 0.0
    p = np.exp(np.array(log) - max(log))
    found = noise_scale(design, np.ones(1, dtype=bool))
    assert found == pytest.approx(np.exp((p * np.log(_SCALES)).sum() / p.sum()), rel=1e-6)


def test_each_unit_has_a_noise_of_its_own(make_lab) -> None:
    """Where captures beside each other differ by a loop in the force, the voltage keeps its noise.

    Single rows at scattered set-points: what neighbours differ by is the loop, and says nothing of the noise.
    """
    lab = make_lab(force=True, chambers=2, captures=60, rows_s=(3.0,), repeats=False, bent=0.0)
    force = lab.predict(lab.looped(4.0)) + lab.noise()
    voltage = lab.predict(lab.u) + lab.noise()
    noise = float(np.hypot(0.05, 0.1))
    model = model_of_both(lab)
    ready = prepared(rows_from(two_sensors(lab, force, voltage)), model)
    again, observations, design = laid_out(ready, model.library())
    assert ready.floor.mean[0] > 10 * noise
    assert again.floor.mean[0] < 0.5 * ready.floor.mean[0]
    assert again.floor.mean[1] == pytest.approx(noise, rel=0.3)
    verdict = verdict_on(again, observations, design, model.library())
    assert verdict.verdict != "nothing_missing"


def test_noise_is_no_larger_than_what_repeats_differ_by(make_lab, few_effects) -> None:
    """An error that no effect follows is no noise where set-points that came again, from elsewhere, read the same."""
    few_effects("creep", "drift", "regulator", "hysteresis", "stiffening")
    lab = make_lab(force=True, chambers=1, captures=80, repeats=False)
    lab.commanded[40:] = np.random.default_rng(4).permutation(lab.commanded[:40])
    error = np.sin(lab.predict(lab.u) * 2 * np.pi / 7.0)  # a wheel that runs out of true
    values, model = lab.predict(lab.u) + error + lab.noise(), lab.model()
    ready, _, _ = laid_out(prepared(rows_from(lab.dataset(values)), model), model.library())
    assert ready.floor.mean[0] < 3 * np.hypot(0.1, 0.05 / np.sqrt(3))
    assert diagnose(lab.dataset(values), model).summary["verdict"] != "nothing_missing"


def test_repeats_that_are_alike_to_the_last_digit_are_no_noise(make_lab) -> None:
    """One pair of a coarse encoder that reads the same says nothing of the noise: that within holds does."""
    lab = make_lab(force=True, chambers=1, captures=30, repeats=False)
    lab.commanded[7:9] = lab.commanded[3:5]
    values = lab.predict(lab.u) + lab.noise()
    values[8] = values[4] + 1e-14
    found = diagnose(lab.dataset(values), lab.model()).summary
    assert 0.02 < found["error"]["floor"] < 0.5
    assert all(e["size_floors"] < 100 for e in found["effects_considered"])


@pytest.mark.parametrize("seed", [0, 2])
def test_a_stop_is_no_noise(make_lab, seed: int) -> None:
    """Of one force that a stop holds at a hundred floors below the model, what repeats say of the noise stands."""
    lab = make_lab(chambers=1, force=True, captures=30, seed=seed, bent=0.0)
    values = np.minimum(lab.predict(lab.u), 20.0) + lab.noise(0.05, 0.1)
    model = lab.model()
    ready, _, _ = laid_out(prepared(rows_from(lab.dataset(values)), model), model.library())
    assert ready.floor.mean[0] == pytest.approx(np.hypot(0.1, 0.05 / np.sqrt(3)), rel=0.35)
