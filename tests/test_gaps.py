"""Gaps of a matrix are filled by what is like them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrig._gaps import filled


@given(st.integers(0, 1000), st.floats(0.02, 0.3))
@settings(max_examples=20)
def test_gaps_are_filled_by_what_is_alike(seed: int, share: float) -> None:
    """What was seen stays to the digit; what was not is nearer to the truth than its column's mean is."""
    rng = np.random.default_rng(seed)
    whole = 5 * rng.normal(size=(80, 2)) @ rng.normal(size=(2, 18)) + rng.normal(size=(80, 18))
    holed = np.where(rng.random(whole.shape) < share, np.nan, whole)
    found, seen = filled(holed), np.isfinite(holed)
    assert (found[seen] == whole[seen]).all()
    if not seen.all():
        mean = np.nanmean(holed, axis=0, keepdims=True)
        assert np.square((found - whole)[~seen]).mean() < 0.7 * np.square((mean - whole)[~seen]).mean()


def test_gaps_in_noise_are_filled_with_nothing() -> None:
    """Where no direction stands above the noise, what was not seen is taken as no error at all."""
    rng = np.random.default_rng(0)
    holed = np.where(rng.random((80, 18)) < 0.1, np.nan, rng.normal(size=(80, 18)))
    assert (filled(holed)[np.isnan(holed)] == 0.0).all()


@pytest.mark.parametrize("share", [0.05, 0.15, 0.3])
def test_markers_out_of_sight_are_filled_to_the_noise(share: float) -> None:
    """Whole markers are away at a time, of motions that are far larger than the noise: what is filled in is off by
    little more than noise, though each of the markers moves the more for one chamber.
    """
    rng = np.random.default_rng(0)
    near = np.exp(-np.abs(np.arange(12)[:, None] - [1.0, 6.0, 10.0]) / 2.0)
    moves = near[:, None] * rng.normal(size=(12, 3, 1)) + 0.1 * rng.normal(size=(12, 3, 3))
    whole = 40.0 * rng.random((80, 3)) @ moves.reshape(36, 3).T + rng.normal(size=(80, 36))
    away = np.repeat(rng.random((80, 12)) < share, 3, axis=1)
    off = (filled(np.where(away, np.nan, whole)) - whole)[away]
    assert np.sqrt(np.mean(off**2)) < 1.6
    assert np.sqrt(np.mean(whole[away] ** 2)) > 10


def test_a_few_rows_of_noise_are_filled_with_hardly_anything() -> None:
    """Of six rows of 48 columns any two directions hold a third of the noise: that is no signal to go by."""
    off = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        whole = rng.normal(size=(6, 48))
        away = np.repeat(rng.random((6, 16)) < 0.15, 3, axis=1)
        off.append((filled(np.where(away, np.nan, whole)) - whole)[away])
    assert np.sqrt(np.mean(np.concatenate(off) ** 2)) < 1.2


@pytest.mark.parametrize("shape", [(1, 30), (2, 9), (3, 2), (40, 1), (5, 102), (200, 4)])
def test_any_shape_is_filled_with_numbers(shape: tuple[int, int]) -> None:
    """Few rows, few columns, rows and columns that were never seen, and what is exact: no gap stays, nothing warns."""
    rng = np.random.default_rng(1)
    for whole in (rng.normal(size=shape), np.outer(np.arange(shape[0]), np.ones(shape[1])), np.zeros(shape)):
        holed = np.where(rng.random(shape) < 0.3, np.nan, whole)
        holed[0], holed[:, -1] = np.nan, np.nan
        assert np.isfinite(filled(holed)).all()
