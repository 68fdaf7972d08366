"""What numbers say about which Gaussian they come from: against closed forms, and against counting."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from labrig.diagnosis import Counted, Outlook
from labrig.experiment._information import bhattacharyya, information, log_bayes

EVEN = np.array([0.5, 0.5])
TWO = np.arange(2)
FULL = Counted(numbers=1, captures=1, conditions=1000)
"""A campaign beside which each number counts for one."""


def outlook(*each: tuple[list[float], list[list[float]]]) -> Outlook:
    """One Gaussian for each mean and factor."""
    return Outlook(
        np.array([mean for mean, _ in each]),
        np.array([factor for _, factor in each]),
        1,
        frozenset(),
        FULL,
    )


def apart(distance: float) -> Outlook:
    """Two means so many standard deviations of the noise apart."""
    return outlook(([0.0, 0.0], [[0.0], [0.0]]), ([distance, 0.0], [[0.0], [0.0]]))


def drawn(random: np.random.Generator, count: int) -> Outlook:
    """Gaussians in three dimensions whose means and covariances differ."""
    return Outlook(
        random.standard_normal((count, 3)), random.standard_normal((count, 3, 2)), 1, frozenset(), FULL
    )


def test_the_numbers_of_both_are_one_gaussian() -> None:
    """Means and covariances are those of all numbers together, also where nothing is put beside them again."""
    random = np.random.default_rng(3)
    one, other = drawn(random, 4), drawn(random, 4)
    factor = np.concatenate([one.factor, other.factor], axis=1)
    for both in (one.beside(other), one.beside(other, last=True)):
        assert both.mean == pytest.approx(np.concatenate([one.mean, other.mean], axis=1))
        assert both.covariance == pytest.approx(factor @ np.swapaxes(factor, 1, 2))


def test_distances_of_equal_covariances() -> None:
    """An eighth of the squared distance, in units of the noise."""
    assert bhattacharyya(apart(4.0)) == pytest.approx(np.array([[0.0, 2.0], [2.0, 0.0]]), abs=1e-12)


def test_a_distance_is_an_integral() -> None:
    """The distance is what drawing from the Gaussians gives, where means and covariances differ."""
    random = np.random.default_rng(1)
    both = drawn(random, 2)
    laws = [
        multivariate_normal(mean, factor @ factor.T + np.eye(3))
        for mean, factor in zip(both.mean, both.factor, strict=True)
    ]
    x = laws[0].rvs(400_000, random_state=random)
    ratio = laws[1].logpdf(x) - laws[0].logpdf(x)
    assert bhattacharyya(both)[0, 1] == pytest.approx(-np.log(np.mean(np.exp(ratio / 2))), rel=0.02)


def test_information_is_nothing_where_all_is_alike_and_the_entropy_where_nothing_is() -> None:
    """Equal Gaussians say nothing; those far apart say all that there is to be known."""
    chance = np.array([0.8, 0.2])
    assert information(apart(0.0), chance, TWO) == pytest.approx(0.0, abs=1e-12)
    assert information(apart(40.0), chance, TWO) == pytest.approx(-chance @ np.log(chance))


def test_forms_of_one_explanation_need_not_be_told_apart() -> None:
    """What differs by its form alone says nothing about the explanation."""
    assert information(apart(40.0), EVEN, np.zeros(2, dtype=int)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_information_is_never_more_than_counting_gives_and_at_least_half(seed: int) -> None:
    """Of four explanations of one form each the estimate is a lower bound, and not a loose one."""
    random = np.random.default_rng(seed)
    four, chance = drawn(random, 4), random.dirichlet(np.ones(4))
    laws = [
        multivariate_normal(mean, factor @ factor.T + np.eye(3))
        for mean, factor in zip(four.mean, four.factor, strict=True)
    ]
    told = 0.0
    for m, law in enumerate(laws):
        x = law.rvs(20_000, random_state=random)
        each = np.stack([other.logpdf(x) for other in laws]) + np.log(chance)[:, None]
        told += chance[m] * float((each[m] - np.log(chance[m]) - logsumexp(each, axis=0)).mean())
    assert 0.5 * told < information(four, chance, np.arange(4)) < 1.01 * told


def test_log_bayes_of_forms() -> None:
    """Over an explanation of two forms, one of which is the truth's own, the Bayes factor is at most their number."""
    three = outlook(([0.0], [[0.0]]), ([0.0], [[0.0]]), ([20.0], [[0.0]]))
    found = log_bayes(three, np.array([0.5, 0.25, 0.25]), np.array([0, 1, 1]))
    assert found[0, 1] == pytest.approx(np.log(2.0))
    assert np.diag(found) == pytest.approx(0.0)


def test_log_bayes_is_what_half_of_the_draws_exceed() -> None:
    """Equal covariances: half of the squared distance. One that is unsure: less than the mean, which few draws make."""
    found = log_bayes(apart(6.0), EVEN, TWO)
    assert found == pytest.approx(np.array([[0.0, 18.0], [18.0, 0.0]]), abs=1.0)
    unsure = outlook(([0.0], [[0.0]]), ([0.0], [[9.0]]))
    variance = 1 + 9.0**2
    mean = (variance - 1 - np.log(variance)) / 2
    median = (0.455 * (variance - 1) - np.log(variance)) / 2  # that of chi squared is 0.455
    assert log_bayes(unsure, EVEN, TWO)[1, 0] == pytest.approx(median, rel=0.2)
    assert log_bayes(unsure, EVEN, TWO)[1, 0] < 0.5 * mean


def test_numbers_of_two_programmes_stand_beside_each_other() -> None:
    """Two programmes that hang on the same coefficients tell less than twice as much; as many numbers count."""
    one = outlook(([0.0], [[3.0]]), ([2.0], [[0.0]]))
    both = one.beside(one)
    assert both.numbers == 2
    assert information(one, EVEN, TWO) < information(both, EVEN, TWO) < 2 * information(one, EVEN, TWO)


def test_few_combinations_hold_what_differs() -> None:
    """Of two hundred numbers in which explanations differ along three ways, a few say as much as all."""
    random = np.random.default_rng(7)
    ways = random.standard_normal((200, 3))
    many = Outlook(
        np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]) @ ways.T / 14,
        np.stack([ways * [0.05, 0.2, 0.0], ways * [0.05, 0.0, 0.1]]),
        200,
        frozenset(),
        FULL,
    )
    few = many.condensed()
    assert few.mean.shape[1] < 40
    assert bhattacharyya(few) == pytest.approx(bhattacharyya(many), rel=1e-6)
    assert few.numbers == 200


def test_numbers_count_as_in_the_diagnosis() -> None:
    """Beside a campaign of many numbers of few conditions others count for little; new conditions help, none twice."""
    far, crowded = apart(8.0), Counted(numbers=4000, captures=40, conditions=8)

    def with_new(conditions: int, inexact: float = 1.0) -> Outlook:
        campaign = replace(crowded, inexact=inexact)
        return Outlook(far.mean, far.factor, 1000, frozenset(range(conditions)), campaign)

    assert with_new(0).worth == pytest.approx(40 / 5000)
    assert with_new(8).worth == pytest.approx(80 / 5000)
    assert with_new(8, inexact=2.0).worth == pytest.approx(40 / 5000)
    assert bhattacharyya(with_new(8))[0, 1] == pytest.approx(8 * 80 / 5000)
    twice = with_new(8).beside(with_new(8))
    assert twice.worth == pytest.approx(80 / 6000)
    assert information(twice, EVEN, TWO) < 2 * information(with_new(8), EVEN, TWO)
