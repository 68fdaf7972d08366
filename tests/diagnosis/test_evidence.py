"""The evidence: what the fast formulas give is the Gaussian log density, computed densely on a tiny design."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from labrig.diagnosis import _constants as k
from labrig.diagnosis._columns import Columns
from labrig.diagnosis._design import DECLARED, SLOW, Block, Design, FreeBlock
from labrig.diagnosis._evidence import (
    RaisedState,
    State,
    Sums,
    beside_free,
    free_fit,
    free_variances,
    unexplained,
)
from labrig.diagnosis._freed import taken
from labrig.diagnosis._parts import sizes
from labrig.diagnosis._posterior import Explanation, Search, small_sizes
from labrig.effects._family import Space

S, K, R, C = 11, 5, 3, 2
WIDTHS = {"a": 2, "b": 3, SLOW: 2}
SEEDS = st.integers(0, 10_000)


def space(name: str) -> Space:
    """A space of that name without features."""
    return Space(name, name, ())


def tiny(seed: int = 0, widths: Mapping[str, int] = WIDTHS, free: Mapping[str, int] | None = None) -> Design:
    """S observations of K observables along R directions; the widths of its blocks and free blocks, by owner.

    The first two columns act through the pressures of C chambers.
    """
    rng = np.random.default_rng(seed)
    V, _ = np.linalg.qr(rng.normal(size=(K, R)))
    blocks, start = [], 0
    for owner, width in widths.items():
        blocks.append(Block(owner, space(owner), slice(start, start + width)))
        start += width
    patterns = [
        FreeBlock(owner, space(owner), np.linalg.qr(rng.normal(size=(S, g)))[0] * np.arange(2, g + 2))
        for owner, g in (free or {}).items()
    ]
    observations = SimpleNamespace(values=rng.normal(size=(S, K)), to_explain=2.0, worth=1.0)
    capture = np.sort(rng.integers(0, 4, S))
    through, moves = rng.normal(size=(S, C, 2)), rng.normal(size=(4, R, C))
    spread, W = (
        np.array([1.5, 1.0, 0.5]),
        Columns(through, moves, capture, rng.normal(size=(S, R, start - 2))),
    )
    return Design(cast(Any, observations), V, spread, W, tuple(blocks), tuple(patterns), np.ones(len(spread)))


def plain(matrix: np.ndarray, r: int) -> Columns:
    """Columns that are written out, (S r, P), of which none acts through pressures."""
    made = matrix.reshape(-1, r, matrix.shape[1])
    nothing, moves = np.zeros((len(made), 0, 0)), np.zeros((len(made), r, 0))
    return Columns(nothing.astype(matrix.dtype), moves.astype(matrix.dtype), np.arange(len(made)), made)


def covariance(design: Design, sd: np.ndarray, variance: np.ndarray | None = None) -> np.ndarray:
    """Of the observations (S R,), where columns have prior sds (P,) and free regressors variances (g, R)."""
    C = np.eye(S * R) + (design.W.whole * sd**2) @ design.W.whole.T
    if variance is not None:
        G = np.concatenate([f.G for f in design.free], axis=1)
        for j in range(R):
            C += np.kron((G * variance[:, j]) @ G.T, np.diag(np.arange(R) == j))
    return C


def seen(design: Design) -> np.ndarray:
    """The observations along the directions, one after the other, (S R,)."""
    return (design.observations.values @ design.V).ravel()


def log_density(design: Design, C: np.ndarray) -> float:
    """Log density of what was seen."""
    return float(multivariate_normal(np.zeros(S * R), C).logpdf(seen(design)))


def log_evidence(state: State | RaisedState) -> float:
    """The same of the fast formulas, up to a constant."""
    return -0.5 * (state.quad + state.logdet)


def raise_to(design: Design, sd: np.ndarray, numbers: Sequence[int], sizes: Sequence[float]) -> np.ndarray:
    """The prior sds (P,) where some blocks have larger ones."""
    out = sd.copy()
    for i, size in zip(numbers, sizes, strict=True):
        out[design.blocks[i].at] = size
    return out


def state_of(design: Design, sd: np.ndarray) -> State:
    """The state of a design without free patterns."""
    return State.of(beside_free(Sums.of(design), np.zeros((0, R))), sd)


@given(SEEDS, st.floats(0.01, 0.5), st.floats(0.6, 50.0), st.floats(0.6, 50.0))
@settings(max_examples=40)
def test_raised_is_the_gaussian_evidence(seed: int, small: float, one: float, two: float) -> None:
    """Raising a block, or two, changes the evidence by what the dense log densities differ by."""
    design = tiny(seed)
    sd = np.full(7, small)
    state = state_of(design, sd)
    before, dense = log_evidence(state), log_density(design, covariance(design, sd))
    for numbers, sds in (([0], [one]), ([1], [two]), ([0, 1], [one, two]), ([0, 1, 2], [one, two, 1.0])):
        fast = log_evidence(state.raised([design.blocks[i].at for i in numbers], sds)) - before
        slow = log_density(design, covariance(design, raise_to(design, sd, numbers, sds))) - dense
        assert fast == pytest.approx(slow, abs=1e-3)


@pytest.mark.parametrize("together", [400_000, 40])
@given(seed=SEEDS, small=st.floats(0.01, 0.5), two=st.floats(0.6, 50.0))
@settings(max_examples=40)
def test_one_more_of_some_blocks_at_several_sizes(together: int, seed: int, small: float, two: float) -> None:
    """Raising one more block to several sizes, many blocks at once or few, gives what each by itself gives."""
    design, sizes = tiny(seed), [two, 1.0]
    state, at = state_of(design, np.full(7, small)), [block.at for block in design.blocks]
    for begun in ([], at[:1], at[:2]):
        before, free = state.raised(begun, [3.0] * len(begun)), at[len(begun) :]
        with patch("labrig.diagnosis._evidence.TOGETHER", together):
            found = np.stack(before.further(free, np.array(sizes)), axis=-1)
        each = [[state.raised([*begun, a], [3.0] * len(begun) + [s]) for s in sizes] for a in free]
        alone = np.array([[(one.quad, one.logdet) for one in of] for of in each])
        assert found == pytest.approx(alone, rel=1e-6, abs=1e-6)


def test_the_evidence_is_absolute() -> None:
    """With the constant of a unit normal it is the log density itself."""
    design = tiny()
    sd = np.full(7, 0.7)
    whole = log_evidence(state_of(design, sd)) - S * R / 2 * np.log(2 * np.pi)
    assert whole == pytest.approx(log_density(design, covariance(design, sd)), abs=1e-4)


@given(SEEDS, st.floats(0.05, 5.0), st.floats(0.05, 5.0))
@settings(max_examples=40)
def test_beside_free_is_the_kronecker_product(seed: int, one: float, two: float) -> None:
    """Marginalising patterns of free shape gives the evidence with their whole covariance in it."""
    design = tiny(seed, free={"?history": 2, DECLARED: 3})
    variance = free_variances(design, {"?history": one, DECLARED: two})
    assert variance[:2] == pytest.approx(np.outer([one**2] * 2, design.spread))
    assert variance[2:] == pytest.approx(two**2)  # the base's own parameters spread evenly
    sd = np.full(7, 0.3)
    state = State.of(beside_free(Sums.of(design), variance), sd)
    for numbers, sds in (([], []), ([1], [4.0]), ([0, 1], [1.0, 2.0])):
        wanted = log_density(design, covariance(design, raise_to(design, sd, numbers, sds), variance))
        raised = state.raised([design.blocks[i].at for i in numbers], sds)
        assert log_evidence(raised) - S * R / 2 * np.log(2 * np.pi) == pytest.approx(wanted, abs=2e-3)


@given(SEEDS, st.floats(0.1, 20.0))
@settings(max_examples=30)
def test_what_is_left_unexplained(seed: int, size: float) -> None:
    """It is y' C^-1 y, where only the blocks that act are in C; without any, beside free patterns alone."""
    design = tiny(seed, free={"?history": 2})
    variance = free_variances(design, {"?history": 1.0})
    sums, y = Sums.of(design), seen(design)
    for numbers, sds in (([], []), ([1], [size]), ([2, 0], [size, 1.0])):
        sd = raise_to(design, np.zeros(7), numbers, sds)
        C, columns = covariance(design, sd, variance), np.flatnonzero(sd)
        left = unexplained(beside_free(sums.some(columns), variance), sd[columns])
        assert left == pytest.approx(y @ np.linalg.solve(C, y), rel=1e-4)


@pytest.mark.parametrize("numbers", [(), (1,), (2, 0)])
def test_posterior_means_and_their_spread(numbers: Sequence[int]) -> None:
    """With blocks raised coefficients are those of a ridge regression, each block's covariance from its inverse."""
    design = tiny()
    sd, sizes = np.full(7, 0.2), [3.0, 0.7][: len(numbers)]
    fitted = state_of(design, sd).raised([design.blocks[i].at for i in numbers], sizes)
    precision = design.W.whole.T @ design.W.whole + np.diag(raise_to(design, sd, numbers, sizes) ** -2.0)
    whole = np.linalg.inv(precision)
    for block in design.blocks:
        assert fitted.covariance(block.at) == pytest.approx(whole[block.at, block.at], abs=1e-6)
    assert fitted.mean == pytest.approx(np.linalg.solve(precision, design.W.whole.T @ seen(design)), abs=1e-5)
    assert fitted.whole.covariance == pytest.approx(whole, abs=1e-6)


@pytest.mark.parametrize("worth", [0.1, 1.0])
def test_an_observation_may_be_worth_less_than_one(worth: float) -> None:
    """The likelihood to a power is one of more noise; the prior keeps its whole weight."""
    design = tiny()
    sd = np.full(7, 0.5)
    state = State.of(beside_free(Sums.of(design, worth), np.zeros((0, R))), sd)
    C = covariance(design, sd) + (1 / worth - 1) * np.eye(S * R)
    y = seen(design)
    assert state.quad == pytest.approx(y @ np.linalg.solve(C, y), rel=1e-4)
    assert state.logdet == pytest.approx(np.linalg.slogdet(worth * C)[1], abs=1e-4)


def test_parts_of_the_observations_add_up() -> None:
    """Sums over some observations and over the others make those over all."""
    design = tiny(free={"?history": 2})
    first = np.arange(S) < 4
    one, two, all_ = (Sums.of(design, keep=keep) for keep in (first, ~first, None))
    for name in ("A", "b", "GG", "GY", "GW", "square"):
        assert getattr(one, name) + getattr(two, name) == pytest.approx(getattr(all_, name), abs=1e-4)


@given(SEEDS, st.permutations([0, 1, 2]))
@settings(max_examples=30)
def test_the_order_of_blocks_does_not_matter(seed: int, order: list[int]) -> None:
    """Laid out in another order, the same blocks have the same evidence."""
    design = tiny(seed)
    columns = np.concatenate([np.r_[design.blocks[i].at] for i in order])
    ends = np.cumsum([0, *[design.blocks[i].at.stop - design.blocks[i].at.start for i in order]])
    blocks = tuple(
        replace(design.blocks[i], at=slice(int(a), int(b)))
        for i, a, b in zip(order, ends, ends[1:], strict=False)
    )
    other = replace(design, W=plain(design.W.whole[:, columns], R), blocks=blocks)
    sd = np.linspace(0.1, 0.4, 7)
    one = state_of(design, sd).raised([b.at for b in design.blocks[:2]], [2.0, 5.0])
    again = [other.blocks[order.index(i)].at for i in (1, 0)]
    two = state_of(other, sd[columns]).raised(again, [5.0, 2.0])
    assert log_evidence(one) == pytest.approx(log_evidence(two), abs=1e-3)


def twice(seed: int) -> tuple[Design, Design]:
    """A design in which two owners have the same space: with the same columns, and with columns of their own."""
    one = tiny(seed)
    W, first = one.W.whole, one.blocks[0].at
    observations = SimpleNamespace(
        **vars(one.observations), counts_for=np.full(S, 1 / (S * R)), curves=np.zeros((S, 0))
    )
    observations.size_of = lambda values, noise=0.0: float(np.sqrt(np.mean(values**2)))
    again = plain(np.concatenate([W, W[:, first]], axis=1), R)
    shared, own = (Block("c", space("a"), at) for at in (first, slice(7, 9)))
    both = [
        replace(one, W=W, observations=cast(Any, observations), blocks=(*one.blocks, block))
        for W, block in ((one.W, shared), (again, own))
    ]
    return both[0], both[1]


@given(SEEDS, st.floats(0.6, 50.0), st.floats(0.6, 50.0))
@settings(max_examples=40)
def test_owners_of_the_same_space(seed: int, one: float, two: float) -> None:
    """What several owners have is laid out once: the evidence of either, of both and of one beside the other is that of
    columns of their own, and so is how large each part is.
    """
    small, found = 1e-3, []
    assert small_sizes(twice(seed)[0], small, small)[:2] == pytest.approx(np.sqrt(2) * small)
    for design in twice(seed):
        state = state_of(design, small_sizes(design, small, small))
        a, b, _, c = (block.at for block in design.blocks)
        before = state.raised([a], [one])
        alone = [
            log_evidence(state.raised(at, sds)) for at, sds in (([c], [two]), ([a, b, c], [one, 1.0, two]))
        ]
        beside = np.add(*before.further([c], np.array([two])))
        found.append([*alone, log_evidence(before), *(-0.5 * beside[0])])
    assert np.diff(found[0]) == pytest.approx(np.diff(found[1]), rel=1e-3, abs=1e-2)


def test_parts_that_are_the_same() -> None:
    """Two parts of an explanation that have the same columns share what these say by the squares of their sizes."""
    form = Explanation(frozenset("abc"), (("a", 0, 3.0), ("b", 1, 2.0), ("c", 3, 1.0)), 0.0, k.SLOW_FLOORS[0])
    once, apart = (sizes(Search(design), form) for design in twice(1))
    for owner in "abc":
        assert once[owner] == pytest.approx(apart[owner], rel=0.02)
    assert once["a"][0] == pytest.approx(9 * once["c"][0])


@given(SEEDS, SEEDS)
@settings(max_examples=30)
def test_directions_are_only_a_basis(seed: int, turn: int) -> None:
    """Turned within their span, and together with all observables, they give the same evidence."""
    design = tiny(seed, free={DECLARED: 2})
    rng = np.random.default_rng(turn)
    Q, _ = np.linalg.qr(rng.normal(size=(R, R)))
    P, _ = np.linalg.qr(rng.normal(size=(K, K)))
    W = replace(design.W, moves=Q.T @ design.W.moves, plain=Q.T @ design.W.plain)
    observations = SimpleNamespace(values=design.observations.values @ P)
    other = replace(design, V=P.T @ design.V @ Q, W=W, observations=cast(Any, observations))
    variance = free_variances(design, {DECLARED: 2.0})
    one, two = (State.of(beside_free(Sums.of(d), variance), np.full(7, 0.3)) for d in (design, other))
    at = [design.blocks[0].at]
    assert log_evidence(one.raised(at, [3.0])) == pytest.approx(log_evidence(two.raised(at, [3.0])), abs=1e-3)


@given(
    SEEDS,
    st.floats(0.001, 0.3),
    st.floats(0.31, 20.0),
    st.sampled_from(["?history", "?place", "both"]),
    st.sampled_from([0.0, np.inf]),
)
@settings(max_examples=60)
def test_free_patterns_that_grow(seed: int, small: float, large: float, which: str, many: float) -> None:
    """A state beside larger free patterns is the one that is worked out from the start, in all that it says; also where
    they take so many rows that it is factored anew.
    """
    design = tiny(seed, free={"?history": 2, "?place": 3, DECLARED: 1})
    sums, sd, at = Sums.of(design, 0.8), np.full(7, 0.4), design.blocks[1].at
    size = {"?history": small, "?place": small, DECLARED: 50.0}
    grown = {owner: large for owner in ("?history", "?place") if which in (owner, "both")}
    before, after = (free_variances(design, way) for way in (size, size | grown))
    smaller = beside_free(sums, before)
    with patch("labrig.diagnosis._evidence._MANY", many):
        begun = State.of(smaller, sd).beside(taken(sums, before, after), smaller)
    anew = State.of(beside_free(sums, after), sd)
    # each leaves out what the data say a thousandth of, not the same
    assert begun.quad == pytest.approx(anew.quad, abs=2e-2)
    assert begun.logdet == pytest.approx(anew.logdet, abs=2e-2)
    np.testing.assert_allclose(begun.mean, anew.mean, atol=5e-3)
    np.testing.assert_allclose(begun.covariance, anew.covariance, atol=5e-3)
    assert log_evidence(begun.raised([at], [3.0])) == pytest.approx(
        log_evidence(anew.raised([at], [3.0])), abs=2e-2
    )


def test_a_search_scores_by_evidence_and_prior() -> None:
    """The score of a form beside a free pattern is its dense log density, those absent kept small, and its prior."""
    design = tiny(3, {"a": 2, "b": 3, "?clock": 2, SLOW: 1}, {"?history": 2})
    search = Search(design)
    present = max(search.sizes)
    background = (("?history", -1, present),)
    slow = k.SLOW_FLOORS[0]

    def dense(numbers: Sequence[int], size: float) -> float:
        sd = np.full(8, search.spike)
        sd[design.blocks[3].at] = slow
        variance = free_variances(design, {"?history": present})
        raised = raise_to(design, sd, numbers, [size] * len(numbers))
        return log_density(design, covariance(design, raised, variance))

    def prior(*raised: tuple[str, int, float]) -> float:
        return search.prior((*background, *raised))

    nothing = search.score(background, slow, ()) - prior()
    for owner, number in (("a", 0), ("b", 1), ("?clock", 2)):
        form = (owner, number, present)
        gained = search.score(background, slow, (form,)) - prior(form) - nothing
        assert gained == pytest.approx(dense([number], present) - dense([], present), abs=2e-3)
    assert prior(("a", 0, present)) - prior() == pytest.approx(np.log(k.P_EFFECT / len(search.sizes)))


def test_probabilities_of_all_that_was_looked_at() -> None:
    """They sum to one, the likeliest first; what acts on the observations is in it, what does not is not."""
    design = tiny(5, {"a": 2, "b": 3, SLOW: 1})
    moved = (design.W.of(design.blocks[1].at) @ np.array([4.0, -3.0, 5.0])).reshape(S, R) @ design.V.T
    observations = SimpleNamespace(values=design.observations.values + moved, to_explain=6.0, worth=1 / 1.09)
    posterior = Search(replace(design, observations=cast(Any, observations))).run().posterior()
    assert posterior.probability.sum() == pytest.approx(1.0)
    assert (np.diff(posterior.probability) <= 0).all()
    assert posterior.explanations[0].owners == {"b"}
    each = zip(posterior.explanations, posterior.probability, strict=True)
    assert sum(p for e, p in each if "a" in e.owners) < 0.2


def test_free_patterns_are_those_of_the_joint_fit() -> None:
    """Free coefficients beside the columns' posterior means are the joint posterior mean, solved densely."""
    design = tiny(3, free={"?f": 2})
    sd, variance = np.full(design.W.width, 0.8), np.outer([0.5, 2.0], [1.0, 0.3, 1.7])
    sums = Sums.of(design)
    columns = State.of(beside_free(sums, variance), sd).mean
    G = design.free[0].G
    X = np.column_stack([design.W.whole, *(np.kron(G[:, [g]], np.eye(R)) for g in range(2))])
    prior = np.concatenate([sd**-2.0, (1 / variance).ravel()])
    joint = np.linalg.solve(X.T @ X + np.diag(prior), X.T @ seen(design))
    assert np.allclose(columns, joint[: len(columns)], atol=1e-3)
    assert np.allclose(free_fit(sums, variance, columns).ravel(), joint[len(columns) :], atol=1e-3)


def test_what_has_no_variance_is_not_there() -> None:
    """Free patterns of variance zero, beside even ones and others, change nothing."""
    design = tiny(4, free={"?history": 2, DECLARED: 3})
    variance = free_variances(design, {"?history": 0.0, DECLARED: 2.0})
    alone = replace(design, free=design.free[1:])
    sd = np.full(design.W.width, 0.3)
    one = State.of(beside_free(Sums.of(design), variance), sd)
    two = State.of(beside_free(Sums.of(alone), variance[2:]), sd)
    assert (one.quad, one.logdet) == pytest.approx((two.quad, two.logdet))


@pytest.mark.parametrize("seed", range(8))
def test_columns_in_single_precision_that_say_the_same(seed: int) -> None:
    """Of columns that are sums of others, thousands of floors large and free to be, there is a covariance."""
    design = tiny(seed, {"a": 3, "b": 4, SLOW: 1})
    W = (1e5 * design.W.whole).astype(np.float32)
    W[:, 3:7] = W[:, :3] @ np.random.default_rng(seed).normal(size=(3, 4)).astype(np.float32)
    sums = Sums.of(replace(design, W=plain(W, R)))
    state = State.of(beside_free(sums, np.zeros((0, R))), np.full(8, 300.0))
    assert (np.diag(state.covariance) > 0).all()
