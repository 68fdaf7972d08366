"""The interval of the difference between two errors, where captures near each other go wrong together."""

import numpy as np
import pytest

from labrig.diagnosis._paired import by_block, difference

CAPTURES, OBSERVABLES, BLOCKS = 120, 6, 12


def residuals(random: np.random.Generator, correlation: float) -> tuple[np.ndarray, np.ndarray]:
    """What two models leave, (n, K): errors that both share and errors of their own, correlated along the run."""
    noise = random.normal(size=(3, CAPTURES, OBSERVABLES))
    for i in range(1, CAPTURES):
        noise[:, i] = correlation * noise[:, i - 1] + np.sqrt(1 - correlation**2) * noise[:, i]
    return noise[0] + 0.8 * noise[1], noise[0] + 0.4 * noise[2]


TRUE = float(np.sqrt(1 + 0.64) - np.sqrt(1 + 0.16))


def covered(correlation: float, draws: int = 400, seed: int = 0) -> float:
    """How often the interval holds the true difference."""
    random, held = np.random.default_rng(seed), 0
    block = np.arange(CAPTURES) * BLOCKS // CAPTURES
    for _ in range(draws):
        sums = [by_block([(left**2, block)], BLOCKS) for left in residuals(random, correlation)]
        found = difference(*sums)
        held += found.low <= TRUE <= found.high
    return held / draws


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.8])
def test_the_interval_holds_the_true_difference_as_often_as_it_says(correlation: float) -> None:
    """In 93 to 98.5 of 100 runs where it says 95, also where each capture is much like the one before it."""
    assert 0.93 <= covered(correlation) <= 0.985


def test_an_interval_that_takes_captures_as_independent_is_too_narrow() -> None:
    """What the blocks are for: with one capture a block, correlated captures are taken for more than they are."""
    random, held, draws = np.random.default_rng(1), 0, 300
    for _ in range(draws):
        parts = [[(left**2, np.arange(CAPTURES))] for left in residuals(random, 0.8)]
        found = difference(*(by_block(one, CAPTURES) for one in parts))
        held += found.low <= TRUE <= found.high
    assert held / draws < 0.85


def test_blocks_of_unequal_size_and_cells_that_were_not_seen() -> None:
    """The difference is that of the errors over all cells; an interval needs three blocks."""
    random = np.random.default_rng(2)
    first, second = residuals(random, 0.3)
    hidden = random.random(first.shape) < 0.2
    first[hidden], second[hidden] = np.nan, np.nan
    block = np.repeat([0, 1, 2, 3], [60, 30, 20, 10])
    found = difference(*(by_block([(left**2, block)], 4) for left in (first, second)))
    by_hand = [np.sqrt(np.nanmean(np.nanmean(left**2, axis=0))) for left in (first, second)]
    assert found.value == pytest.approx(by_hand[0] - by_hand[1])
    assert found.low < found.value < found.high
    few = difference(*(by_block([(left**2, block // 2)], 4) for left in (first, second)))
    assert few.blocks == 2
    assert np.isnan([few.low, few.high]).all()
    assert few.nearer is None
