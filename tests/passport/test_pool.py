"""Pooling: the random-effects mean, by hand and by chance."""

import numpy as np
import pytest

from labrig.passport import pooled


def test_by_hand() -> None:
    """DerSimonian and Laird's estimate of three values, worked out with pencil and paper.

    Values 1, 2, 6 with variances 1: mean 3, Q = 4 + 1 + 9 = 14, sum w - sum w^2 / sum w = 3 - 1 = 2, so the variance
    between is (14 - 2) / 2 = 6, and the mean's is (1 + 6) / 3.
    """
    pool = pooled(np.array([[1.0], [2.0], [6.0]]), np.ones((3, 1)))
    assert pool.mean == pytest.approx([3.0])
    assert pool.between**2 == pytest.approx([6.0])
    assert pool.sd**2 == pytest.approx([7.0 / 3.0])
    assert pool.predicted_sd == pytest.approx([2.0 * np.sqrt(7.0 / 3.0 + 6.0)])


def test_unequal_weights_by_hand() -> None:
    """Values 0 and 2 with variances 1 and 1/4, w = 1 and 4: mean 8/5, Q = 16/5, denominator 5 - 17/5 = 8/5."""
    pool = pooled(np.array([[0.0], [2.0]]), np.array([[1.0], [0.5]]))
    between = (16 / 5 - 1) / (8 / 5)
    w = np.array([1 / (1 + between), 1 / (0.25 + between)])
    assert pool.between**2 == pytest.approx([between])
    assert pool.mean == pytest.approx([2 * w[1] / w.sum()])


def test_as_another_library_has_it() -> None:
    """The figures of statsmodels 0.15.0 (`combine_effects`, chi2) for nine drawn estimates."""
    random = np.random.default_rng(0)
    value, sd = random.normal(size=9), random.uniform(0.2, 0.6, 9)
    pool = pooled(value[:, None], sd[:, None])
    assert pool.between**2 == pytest.approx([0.4769295375939506])
    assert pool.mean == pytest.approx([0.24329433232504943])
    assert pool.sd == pytest.approx([0.2697074021885221])


def test_estimates_that_agree_have_no_scatter_between() -> None:
    """Then the mean is weighted by precision alone."""
    pool = pooled(np.array([[1.0], [1.1], [0.9]]), np.array([[0.5], [0.5], [0.5]]))
    assert pool.between == pytest.approx([0.0])
    assert pool.sd == pytest.approx([0.5 / np.sqrt(3)])


def test_one_place_is_as_uncertain_as_is_said() -> None:
    """From a single estimate, another place may differ by the share that is stated, and by the estimate's error."""
    pool = pooled(np.array([[2.0]]), np.array([[0.1]]), spread=0.3)
    assert pool.mean == pytest.approx([2.0])
    assert pool.predicted_sd == pytest.approx([np.hypot(0.1, 0.6)])


def test_a_chamber_with_none_of_it_may_have_some_elsewhere() -> None:
    """A value near zero may differ by the share of what its neighbours have; an unsure one adds nothing."""
    pool = pooled(np.array([[0.02, 1.0, -1.0]]), np.full((1, 3), 0.01), spread=0.3)
    usual = np.sqrt((0.02**2 + 2 * 1.0 - 3 * 0.01**2) / 3)
    assert pool.predicted_sd[0] == pytest.approx(np.hypot(0.01, 0.3 * usual))
    assert pool.predicted_sd[1:] == pytest.approx(np.hypot(0.01, 0.3), rel=1e-3)
    unsure = pooled(np.array([[0.02, 5.0]]), np.array([[0.01, 9.0]]), spread=0.3)
    assert unsure.predicted_sd[0] < 0.02


def test_what_says_nothing_counts_for_nothing() -> None:
    """An estimate with an infinite standard deviation, or all of them."""
    pool = pooled(np.array([[1.0, 5.0], [9.0, 7.0]]), np.array([[0.1, np.inf], [np.inf, np.inf]]))
    assert pool.mean[0] == pytest.approx(1.0)
    assert pool.sd == pytest.approx([0.1, np.inf])


def test_it_covers() -> None:
    """Of many drawn sets of places, what one more shows lies within two predicted sds nine times in ten or more."""
    random = np.random.default_rng(0)
    m, draws = 8, 2000
    sd = random.uniform(0.2, 0.6, (m, draws))
    true = 1.0 + 0.5 * random.normal(size=(m + 1, draws))
    pool = pooled(true[:m] + sd * random.normal(size=(m, draws)), sd)
    inside = np.abs(true[m] - pool.mean) < 2 * pool.predicted_sd
    assert 0.88 < inside.mean() < 0.98
