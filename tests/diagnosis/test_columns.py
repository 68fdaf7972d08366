"""Columns: kept as what they do to pressures, they say what they would say written out."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis._columns import Columns

SHAPES = [(7, 3, 2, 4, 5), (7, 2, 3, 200, 1), (6, 4, 2, 3, 0), (6, 1, 1, 0, 4)]
"""Observations, directions, chambers, columns that act through pressures, and others."""


def columns(S: int, r: int, C: int, p: int, d: int, dtype: Any = np.float64) -> Columns:
    """Columns of S observations of three captures, at random."""
    random = np.random.default_rng(S + r + C)
    of = lambda *shape: random.normal(size=shape).astype(dtype)  # noqa: E731  short, and said once
    return Columns(of(S, C, p), of(3, r, C), np.arange(S) % 3, of(S, r, d))


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
    assert Columns.of_matrix(made.whole, 3).whole == pytest.approx(made.whole)
