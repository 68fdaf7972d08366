"""What can act one way only, as a stop that holds back: its evidence, and its name."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.stats import multivariate_normal, norm

from labrig.arrays import Floats
from labrig.diagnosis import Explained
from labrig.diagnosis._columns import Columns
from labrig.diagnosis._design import SLOW, Block, Design
from labrig.diagnosis._design import design_of as laid_out
from labrig.diagnosis._evidence import State, Sums, beside_free
from labrig.diagnosis._observations import observe
from labrig.diagnosis._posterior import Search
from labrig.diagnosis._problem import prepared, rows_from
from labrig.diagnosis._signs import gains_alone, log_gain, log_gain_together
from labrig.effects import Feature, Space, field, library, pattern, pressure
from labrig.effects._family import one_way
from tests.effects.test_family import context_of
from tests.naming import calls_of

S, R = 40, 3
ONE = np.ones((9, 2))
PAST, PLAIN, SLOWLY = slice(0, 2), slice(2, 5), slice(5, 6)


def design_of(acts: float, way: Floats | None) -> Design:
    """Two owners: what a stop does (two columns, which go `way` if they must), which acts so much, and something else
    that holds most of it in three; noise of one.
    """
    random = np.random.default_rng(3)
    made = random.normal(size=(S, R, 6))
    made[:, :, 2:4] = made[:, :, 0:2] + 0.2 * made[:, :, 2:4]
    blocks = (
        Block("stop", Space("stop", "", ()), PAST, way=way),
        Block("other", Space("other", "", ()), PLAIN),
        Block(SLOW, Space(SLOW, "", ()), SLOWLY),
    )
    seen = made[:, :, :2] @ np.array([acts, 0.3 * acts]) + random.normal(size=(S, R))
    observations = SimpleNamespace(
        values=seen,
        to_explain=float(np.sqrt(np.mean(seen**2))),
        worth=1.0,
        counts_for=np.full(S, 1 / (S * R)),
    )
    W = Columns(np.zeros((S, 0, 0)), np.zeros((S, R, 0)), np.arange(S), made)
    return Design(cast(Any, observations), np.eye(R), np.ones(R), W, blocks, (), np.ones(R))


@settings(max_examples=30)
@given(st.floats(-2.0, 2.0), st.floats(0.3, 3.0))
def test_the_evidence_of_one_sign_is_that_of_half_a_prior(acts: float, sd: float) -> None:
    """Integrated over positive coefficients alone, with twice their density, it is the Gaussian one times the gain."""
    x = np.linspace(0.2, 1.0, 5)
    y = acts * x + 0.3 * np.sin(9 * x)

    def half(c: float) -> float:
        return 2 * norm.pdf(c, scale=sd) * float(np.prod(norm.pdf(y - c * x)))

    whole = multivariate_normal(cov=np.eye(5) + sd**2 * np.outer(x, x)).pdf(y)
    precision = x @ x + sd**-2.0
    gain = float(log_gain(np.array(x @ y / precision), np.array(precision**-0.5)))
    assert np.log(whole) + gain == pytest.approx(np.log(quad(half, 0, 40, points=[1.0])[0]), abs=1e-5)


PLACES = st.floats(-3.0, 3.0)
TWO_WAYS = [[0, 1], [0, 1, 2], [2, 1, 3], [0, 3], [0, 4, 3, 2], [1, 3, 4]]
"""Sets of five blocks, in each of which two go one way."""


@given(PLACES, PLACES, st.floats(-0.98, 0.98), st.floats(0.1, 10.0))
def test_of_two_both_must_have_their_sign(one: float, two: float, alike: float, sd: float) -> None:
    """Two parts gain what both being positive gains, whatever their scales: from the bivariate normal's integral."""
    covariance = np.array([[sd**2, alike * sd], [alike * sd, 1.0]])
    both = multivariate_normal(cov=np.array([[1, alike], [alike, 1]])).cdf([one, two])
    found = float(log_gain_together(np.array([[sd * one, two]]), covariance[None])[0])
    assert np.exp(found) / 4 == pytest.approx(both, abs=2e-3)


@given(st.floats(0.3, 30.0), st.floats(0.3, 30.0))
def test_how_far_one_more_block_acts_along_a_way(one: float, two: float) -> None:
    """For several sizes at once it is what raising the block to each by itself gives, mean and sd."""
    design, way = design_of(1.0, None), np.array([0.7, -0.2])
    state = State.of(beside_free(Sums.of(design), np.zeros((0, R))), np.full(6, 0.2))
    begun = state.raised([PLAIN], [1.5])
    for mean, sd, size in zip(*begun.further_along(PAST, np.array([one, two]), way), (one, two), strict=True):
        alone = state.raised([PLAIN, PAST], [1.5, size])
        assert mean == pytest.approx(way @ alone.mean[PAST], rel=1e-5, abs=1e-9)
        assert sd == pytest.approx(np.sqrt(way @ alone.covariance(PAST) @ way), rel=1e-5)


@given(st.integers(0, 999))
def test_of_many_sets_at_once_each_gains_what_it_gains_by_itself(seed: int) -> None:
    """Of sets of any width, also where two owners have the same columns: from the state with all columns raised."""
    random = np.random.default_rng(seed)
    made = random.normal(size=(30, 9))
    precision = made.T @ made
    state = State(
        np.full(9, 0.3), np.linalg.inv(precision + np.eye(9) / 0.09), random.normal(size=9), 1.0, 0.0
    )
    ats = [slice(0, 2), slice(2, 5), slice(5, 6), slice(0, 2), slice(6, 9)]
    ways = {0: random.normal(size=2), 1: random.normal(size=3), 3: random.normal(size=2)}
    sets = [[(ats[b], float(random.uniform(0.5, 3)), b) for b in numbers] for numbers in TWO_WAYS]
    for found, parts in zip(gains_alone(state, sets, ways), sets, strict=True):
        raised = state.raised([at for at, _, _ in parts], [sd for _, sd, _ in parts])
        along = np.zeros((2, 9))
        for row, (at, b) in zip(along, [(at, b) for at, _, b in parts if b in ways], strict=True):
            row[at] = ways[b]
        whole = raised.covariance(np.arange(9))
        there = multivariate_normal(along @ raised.mean, along @ whole @ along.T, allow_singular=True)
        assert np.exp(found) / 4 == pytest.approx(there.cdf([0, 0], lower_limit=[np.inf] * 2), abs=2e-3)


@pytest.mark.parametrize(("acts", "named"), [(1.5, True), (-1.5, False)])
def test_what_goes_the_other_way_has_another_name(acts: float, named: bool) -> None:
    """What fits as well both ways is a stop where it holds back, and where it drives on not even a trace of one."""
    free = design_of(acts, None)
    assert Search(free).run().posterior().explanations[0].owners == {"stop"}
    columns = free.W.of(PAST)
    best = Search(design_of(acts, columns.sum(axis=1) @ columns)).run().posterior().explanations[0]
    assert ("stop" in {owner for owner, _, _ in best.raised}) is named
    assert ("stop" in best.owners) is named


@pytest.mark.parametrize("seed", range(3))
def test_two_stops_that_are_nearly_one_do_not_drive_on_either(seed: int) -> None:
    """Two spaces of a stop, the same but for a tenth, are no way around the sign: something else is named."""
    random = np.random.default_rng(seed)
    made = random.normal(size=(S, R, 4))
    made[:, :, 1] = made[:, :, 0] + 0.15 * made[:, :, 1]
    made[:, :, 2] = made[:, :, 0] + 0.3 * made[:, :, 2]
    at = [slice(i, i + 1) for i in range(4)]
    blocks = (
        Block("stop", Space("near", "", ()), at[0], way=np.ones(1)),
        Block("stop", Space("far", "", ()), at[1], way=np.ones(1)),
        Block("other", Space("other", "", ()), at[2]),
        Block(SLOW, Space(SLOW, "", ()), at[3]),
    )
    seen = -1.5 * made[:, :, 0] + random.normal(size=(S, R))
    size = float(np.sqrt(np.mean(seen**2)))
    observations = SimpleNamespace(
        values=seen, to_explain=size, worth=1.0, counts_for=np.full(S, 1 / (S * R))
    )
    W = Columns(np.zeros((S, 0, 0)), np.zeros((S, R, 0)), np.arange(S), made)
    design = Design(cast(Any, observations), np.eye(R), np.ones(R), W, blocks, (), np.ones(R))
    posterior = Search(design).run().posterior()
    stopped = [
        p for e, p in zip(posterior.explanations, posterior.probability, strict=True) if "stop" in e.owners
    ]
    assert sum(stopped) < 0.01


def test_each_space_of_contact_holds_back(make_lab) -> None:
    """Whatever a stop does, it can only take from a motion: each of its spaces says along what."""
    lab = make_lab(captures=40, markers=12)
    spaces = list(library()["contact"].family(context_of(lab, lab.predict(lab.u))))
    assert {space.spectrum for space in spaces} >= {"contact limit", "contact from below", "contact end"}
    assert all(space.along is not None for space in spaces)


def test_chambers_that_pull_against_each_other_are_held_back_all_the_same(make_lab) -> None:
    """A stop of one chamber acts the way that a stop acts, also where another one moves the markers back further."""
    lab = make_lab(captures=60, chambers=2, markers=6)
    lab.reach[:, 1] = -3.0 * lab.reach[:, 0]
    x = lab.u / lab.u.max()
    met = np.stack([0.05 * np.arctan(np.maximum(x[..., 0] - 0.5, 0) / 0.3), 0 * x[..., 1]], axis=-1)
    data = lab.dataset(lab.predict(lab.u - met * lab.u.max()) + 0.01 * lab.noise())
    model = lab.model()
    ready = prepared(rows_from(data), model)
    observations = observe(ready.context, ready.residual, ready.floor)
    design = laid_out(observations, {"contact": model.library()["contact"]})
    block = next(b for b in design.blocks if b.space.key == "limit 0.5")
    values = (observations.values @ design.V).ravel()
    weights = np.linalg.lstsq(design.W.of(block.at), values, rcond=1e-3)[0]
    assert block.way is not None
    assert block.way @ weights > 0


def test_forms_of_one_set_are_given_their_signs() -> None:
    """Before the forms of a set are compared, however improbable the set is, its likeliest has its sign counted."""
    search = Search(design_of(-1.5, np.ones(2))).run()
    search.settle(frozenset({"stop"}))
    value, whole, slow = max(search.found[frozenset({"stop"})])
    assert (whole, slow) in search.signed
    assert value < search.score((), slow, whole) - 10


def test_the_next_experiment_compares_forms_with_their_signs(make_lab) -> None:
    """The forms of a stop that a programme is planned for are its likeliest with their signs, where a wall gives."""
    lab = make_lab(captures=40, markers=6)
    past = (lab.u / lab.u.max() - 0.7) / 0.08
    there = lab.u + 0.012 * (past + np.log(2 * np.cosh(past))) * lab.u.max()
    model = lab.model()
    ready = prepared(rows_from(lab.dataset(lab.predict(there) + lab.noise())), model)
    effects = {name: model.library()[name] for name in ("contact", "stiffening", "leak")}
    explained = Explained(ready, effects)
    for names in (["contact"], ["contact", "leak"]):
        forms = explained.forms(names, 3)
        assert forms
        assert all((form.raised, form.slow) in explained.search.signed for form in forms)


@pytest.mark.parametrize("features", [(pattern("a", np.ones(9)),), (field("a", ONE), pressure("b", ONE))])
def test_a_space_of_several_kinds_has_no_one_way(features: tuple[Feature, ...]) -> None:
    """Of a free pattern, or of pressures beside fields, nobody can say which way they go."""
    with pytest.raises(
        ValueError, match=r"^space 's': one_way takes pressures only, or fields only, not \['"
    ):
        one_way(Space("s", "s", features))


@pytest.mark.parametrize("holds_back", [True, False])
def test_a_bulge_is_no_stop(make_lab, few_effects, holds_back: bool) -> None:
    """A wall that gives way past some pressure, by a log-cosh, is no contact; one that is held back as much is."""
    few_effects("contact", "stiffening", "tension", "regulator", "coupling")
    lab = make_lab(chambers=2, captures=80, markers=8)
    x = lab.u / lab.u.max()
    past = (x - 0.7) / 0.08
    more = 0.012 * (past + np.log(2 * np.cosh(past)))
    there = lab.u + (-1 if holds_back else 1) * more * lab.u.max()
    calls = calls_of(lab.dataset(lab.predict(there) + lab.noise()), lab.model())
    assert (calls["contact"] == "not it") is not holds_back
