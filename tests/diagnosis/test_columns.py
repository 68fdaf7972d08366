"""Columns: kept as what they do to pressures, they say what they would say written out."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis._columns import Columns, flushed
from labrig.diagnosis._design import Block, Design, design_of
from labrig.diagnosis._observations import observe
from labrig.diagnosis._problem import prepared, rows_from

SHAPES = [(7, 3, 2, 4, 5), (7, 2, 3, 200, 1), (6, 4, 2, 3, 0), (6, 1, 1, 0, 4)]
"""Observations, directions, chambers, columns that act through pressures, and others."""


def columns(S: int, r: int, C: int, p: int, d: int, dtype: Any = np.float64) -> Columns:
    """Columns of S observations of three captures, at random; every other one is nothing within holds."""
    random = np.random.default_rng(S + r + C)
    of = lambda *shape: random.normal(size=shape).astype(dtype)  # noqa: E731  short, and said once
    through, plain = of(S, C, p), of(S, r, d)
    through[3:, :, ::2], plain[3:, :, 1::2] = 0.0, 0.0
    return Columns(through, of(3, r, C), np.arange(S) % 3, plain)


@pytest.mark.parametrize("shape", SHAPES)
def test_written_out(shape: tuple[int, ...]) -> None:
    """A column through pressures is the capture's slopes times what it does to them; the others come after."""
    made = columns(*shape)
    S, r, C, p, _ = shape
    for s in range(S):
        for j in range(r):
            through = [
                sum(made.moves[s % 3, j, c] * made.through[s, c, i] for c in range(C)) for i in range(p)
            ]
            assert made.whole[s * r + j] == pytest.approx([*through, *made.plain[s, j]])


@pytest.mark.parametrize("shape", SHAPES)
def test_products_are_those_of_the_whole(shape: tuple[int, ...]) -> None:
    """The Gram matrix, products with values and with regressors, and what weights make, are those of the matrix."""
    made, random = columns(*shape), np.random.default_rng(0)
    S, r = shape[:2]
    whole, values, G = made.whole, random.normal(size=(S, r)), random.normal(size=(S, 2))
    weights = random.normal(size=made.width)
    G[3:, 1] = 0.0
    assert made.gram() == pytest.approx(whole.T @ whole)
    assert made.times(values) == pytest.approx(whole.T @ values.ravel())
    assert made.beside(G) == pytest.approx(np.einsum("sg,srp->grp", G, whole.reshape(S, r, -1)))
    assert made.made(weights).ravel() == pytest.approx(whole @ weights)


@pytest.mark.parametrize("at", [slice(0, 3), slice(2, 6), slice(5, 9), slice(4, 4)])
def test_some_columns_and_some_observations(at: slice) -> None:
    """Slices of either kind, or across both, and single observations, are those of the matrix."""
    made = columns(*SHAPES[0])
    assert made.of(at) == pytest.approx(made.whole[:, at])
    rows = np.array([5, 0])
    assert made.some(rows).whole == pytest.approx(made.whole.reshape(7, 3, -1)[rows].reshape(6, -1))


def test_single_precision_stays_single() -> None:
    """What is kept in single precision is written out so, and its sums come in double."""
    made = columns(*SHAPES[0], dtype=np.float32)
    assert made.whole.dtype == made.beside(np.ones((7, 1))).dtype == np.float32
    assert made.gram().dtype == made.times(np.ones((7, 3))).dtype == np.float64


def test_a_space_of_several_owners_is_laid_out_once(make_lab) -> None:
    """Three effects and the base's own form share one space, and its columns; all other blocks have columns of their
    own, and each space that acts through pressures is what it would be alone.
    """
    lab = make_lab(captures=30)
    model = lab.model()
    ready = prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), model)
    library = model.library()
    observations = observe(ready.context, ready.residual, ready.floor)
    design = design_of(observations, library)
    places = [(b.at.start, b.at.stop) for b in design.blocks]
    same = [b for b in design.blocks if places.count((b.at.start, b.at.stop)) > 1]
    assert {b.owner for b in same} == {"coupling", "regulator", "stiffening", "tension", "?motion"}
    assert {b.space.key.split(",")[0] for b in same} == {"any curve", "reached"}
    covered = np.concatenate([np.arange(*at) for at in sorted(set(places))])
    assert np.array_equal(covered, np.arange(design.W.width))
    alone = design_of(observations, {"tension": library["tension"]})
    for block in (b for b in alone.blocks if b.owner == "tension"):
        other = next(b for b in design.blocks if (b.owner, b.space.key) == ("tension", block.space.key))
        one, two = variance(alone, block), variance(design, other)
        assert one == pytest.approx(two, rel=0.05, abs=1e-3 * one.max())


def variance(design: Design, block: Block) -> np.ndarray:
    """The prior variance (S, K) of each observation when one block acts at one floor."""
    columns = design.W.of(block.at).reshape(-1, design.V.shape[1], block.at.stop - block.at.start)
    return np.square(design.V @ columns).sum(axis=2)


def test_what_is_next_to_nothing_is_nothing() -> None:
    """No number is left whose product with another would not be a normal one of single precision."""
    faded = np.float32(10.0) ** -np.arange(0, 40, 3, dtype=np.float32)
    kept = flushed(faded.copy())
    assert kept[:6] == pytest.approx(faded[:6])
    products = kept[:, None] * kept
    assert (products[products != 0] >= np.finfo(np.float32).tiny).all()
