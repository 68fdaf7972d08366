"""A law may lie in two spaces of its effect: then both are raised, and it has one name and one size."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from labrig.arrays import Floats
from labrig.diagnosis._columns import Columns
from labrig.diagnosis._constants import SLOW_FLOORS
from labrig.diagnosis._design import SLOW, Block, Design
from labrig.diagnosis._explanation import Explanation
from labrig.diagnosis._parts import sizes
from labrig.diagnosis._posterior import Search
from labrig.effects._family import Space

S, R = 40, 3
FIRST, SECOND, OTHER, SLOWLY = slice(0, 2), slice(2, 4), slice(4, 8), slice(8, 9)


def design_of(weights: Floats) -> Design:
    """One owner with two spaces, another with one, which holds most of the first's second; what is seen is made of
    the columns (9,) with these weights and noise of one.
    """
    random = np.random.default_rng(1)
    made = random.normal(size=(S, R, 9))
    made[:, :, 4:6] = made[:, :, 2:4] + 0.5 * made[:, :, 4:6]
    W = Columns(np.zeros((S, 0, 0)), np.zeros((S, R, 0)), np.arange(S), made)
    owners = (("a", FIRST), ("a", SECOND), ("b", OTHER), (SLOW, SLOWLY))
    blocks = tuple(Block(owner, Space(f"{at}", "", ()), at) for owner, at in owners)
    seen = (made @ weights) + random.normal(size=(S, R))
    observations = SimpleNamespace(
        values=seen,
        to_explain=float(np.sqrt(np.mean(seen**2))),
        worth=1.0,
        counts_for=np.full(S, 1.0 / (S * R)),
        curves=np.zeros((S, 0)),
        size_of=lambda values, noise=0.0: float(np.sqrt(max(np.mean(values**2) - noise, 0.0))),
    )
    return Design(cast(Any, observations), np.eye(R), np.ones(R), W, blocks, (), np.ones(R))


def test_a_law_in_two_spaces_has_one_name() -> None:
    """Where what is seen lies in two spaces of one owner, it is alone in the likeliest explanation, with both."""
    search = Search(design_of(np.array([2.0, -1.0, 1.5, 1.0, 0, 0, 0, 0, 0]))).run()
    best = search.posterior().explanations[0]
    assert best.owners == {"a"}
    assert {block for owner, block, _ in best.raised if owner == "a"} == {0, 1}


def test_a_law_in_one_space_needs_no_second() -> None:
    """Where one space is enough, the second is not raised."""
    search = Search(design_of(np.array([2.0, -1.0, 0, 0, 0, 0, 0, 0, 0]))).run()
    assert [block for owner, block, _ in search.posterior().explanations[0].raised if owner == "a"] == [0]


def test_the_size_of_an_effect_is_that_of_its_spaces_together() -> None:
    """It is that of the sum of what both make, with the sd of the sum; not the larger one, nor both added up."""
    design = design_of(np.array([2.0, -1.0, 1.5, 1.0, 0, 0, 0, 0, 0]))
    search = Search(design)
    size = max(search.sizes)
    both = Explanation(frozenset({"a"}), (("a", 0, size), ("a", 1, size)), 0.0, 0.05)
    value, sd, _ = sizes(search, both)["a"]
    prior = np.full(9, search.spike)
    prior[:4], prior[4:8], prior[8] = size, search.spike, 0.05
    X = design.W.whole
    cov = np.linalg.inv(X.T @ X + np.diag(prior**-2.0))
    mean = cov @ X.T @ design.observations.values.ravel()
    made = X[:, :4] @ mean[:4]
    way = X[:, :4].T @ made / (len(made) * np.sqrt(np.mean(made**2)))
    assert value == pytest.approx(np.sqrt(np.mean(made**2)), rel=1e-3)
    assert sd == pytest.approx(np.sqrt(way @ cov[:4, :4] @ way), rel=1e-2)
    alone = sizes(search, replace(both, raised=(("a", 0, size),)))["a"][0]
    assert value > 1.1 * alone


def test_no_explanation_has_more_slow_noise_to_choose_from() -> None:
    """Where slow noise has one size, all explanations are counted with that one: not the likeliest with every size."""
    found = Search(design_of(np.array([2.0, -1.0, 0, 0, 0, 0, 0, 0, 0]))).run().found
    assert {slow for forms in found.values() for _, _, slow in forms} == {min(SLOW_FLOORS)}
