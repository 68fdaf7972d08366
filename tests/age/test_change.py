"""What counts as a change, and how often chance is taken for one."""

import numpy as np
import pytest

from labrig.age import Series, changes
from labrig.age._moments import Moments
from labrig.age._wander import WANDERS

ALPHA = 0.05
DAYS = 50


def series(value: np.ndarray, kind: list[str] | None = None, sd: float = float("nan")) -> Series:
    """A quantity read every day."""
    n, width = len(value), value.size // max(len(value), 1)
    return Series(
        np.arange(n, dtype=float),
        value.reshape(n, width),
        np.full(n, sd),
        np.array(kind or ["check"] * n),
    )


def noise(seed: int, *shape: int) -> np.ndarray:
    """Normal scatter of unit size."""
    return np.random.default_rng(seed).normal(size=shape or (DAYS,))


def test_chance_is_seldom_taken_for_a_change() -> None:
    """Of series that only scatter, looked at after every run, no more have a change than alpha says."""
    false = sum(bool(changes(series(noise(seed)), ALPHA).changes) for seed in range(300))
    assert false <= ALPHA * 300


@pytest.mark.parametrize("correlation", [0.7, 0.8])
def test_what_is_as_it_was_yesterday_is_seldom_taken_for_a_change(correlation: float) -> None:
    """Of quantities of a rig that wander, such as its softness with the room, few are named in 50 days."""
    false = 0
    for seed in range(40):
        value = noise(seed)
        for day in range(1, DAYS):
            value[day] = correlation * value[day - 1] + np.sqrt(1 - correlation**2) * value[day]
        false += bool(changes(series(value), ALPHA / 60).changes)
    assert false <= 4


@pytest.mark.parametrize("seed", range(5))
def test_a_step_is_found_where_it_is(seed: int) -> None:
    """A step of ten times the scatter is sure after two runs, and its size and its date are right."""
    value = noise(seed)
    value[30:] += 10.0
    (found,) = changes(series(value), ALPHA).changes
    assert (found.shape, found.begins, found.noticed) == ("step", 30, 31)
    assert found.first <= 30 <= found.last
    assert abs(found.amount[0] - 10.0) < 4 * found.sd


@pytest.mark.parametrize("seed", range(5))
def test_a_growth_is_a_slope(seed: int) -> None:
    """What grows steadily is found well before the end; what is told in the end is a slope, not a stair."""
    value = noise(seed) + 20.0 * np.maximum(np.arange(DAYS) - 20, 0) / 30.0
    found = changes(series(value), ALPHA).changes
    assert found[-1].shape == "slope"
    assert len(found) <= 2
    assert abs(found[0].begins - 20) <= 8
    assert found[0].noticed < DAYS - 10


def test_what_comes_back_is_two_changes() -> None:
    """A fault that is mended is a step there and a step back."""
    value = noise(1)
    value[15:30] += 12.0
    found = changes(series(value), ALPHA).changes
    assert [each.begins for each in found] == [15, 30]
    assert found[0].amount[0] > 0 > found[1].amount[0]


def test_one_odd_run_is_no_change() -> None:
    """A run that differs by itself changes nothing; if it is the last one, it is said that another will tell."""
    value = noise(2)
    value[25] += 40.0
    assert changes(series(value), ALPHA) == type(changes(series(value), ALPHA))((), False)
    value = noise(2)
    value[-1] += 40.0
    found = changes(series(value), ALPHA)
    assert found.changes == ()
    assert found.unconfirmed


def test_runs_of_another_kind_have_a_level_of_their_own() -> None:
    """What a model gets wrong in one programme and not in another is no change; a step in both is."""
    kind = ["check", "capture"] * (DAYS // 2)
    value = noise(3) + 30.0 * (np.arange(DAYS) % 2)
    assert changes(series(value, kind), ALPHA).changes == ()
    value[30:] += 8.0
    assert [each.begins for each in changes(series(value, kind), ALPHA).changes] == [30]


def test_places_change_in_any_direction() -> None:
    """Three components that scatter alike are tested together."""
    value = noise(4, DAYS, 3)
    value[20:] += [0.0, -8.0, 4.0]
    (found,) = changes(series(value), ALPHA).changes
    assert found.begins == 20
    assert np.allclose(found.amount, [0, -8, 4], atol=4 * found.sd)


def test_readings_that_never_differ_are_no_evidence_against_a_small_step() -> None:
    """A sensor that reads the same every day may read its last digit otherwise: its own sd says how much that is."""
    value = np.zeros(DAYS)
    value[40:] += 0.2
    assert changes(series(value, sd=1.0), ALPHA).changes == ()
    value[40:] += 20.0
    assert len(changes(series(value, sd=1.0), ALPHA).changes) == 1


@pytest.mark.parametrize("wander", range(len(WANDERS)))
def test_sums_are_least_squares_under_each_way_to_wander(wander: int) -> None:
    """The likelihood and the size of a step are what generalised least squares says of one moment."""
    n, now, begin = 20, 15, 9
    kind = ["check", "capture", "capture", "check"] * 5
    runs = series(noise(7, n), kind)
    share, days = WANDERS[wander]
    part = np.arange(now + 1)
    alike = share * np.exp(-np.abs(part[:, None] - part) / days) + (1 - share) * np.eye(now + 1)
    levels = np.array([[name == "check", name == "capture"] for name in kind[: now + 1]], float)
    y, known = runs.value[: now + 1, 0], np.linalg.inv(alike)
    with_step = np.column_stack([levels, part >= begin])

    def fitted(columns: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
        gram = columns.T @ known @ columns
        found = np.linalg.solve(gram, columns.T @ known @ y)
        left = y - columns @ found
        return found, float(left @ known @ left), gram

    _, left, gram = fitted(levels)
    likely = -0.5 * (np.linalg.slogdet(alike)[1] + np.linalg.slogdet(gram)[1] + (now + 1 - 2) * np.log(left))
    moments = Moments(runs, False, wander)
    assert moments.unchanged[now] == pytest.approx(likely)
    found, left, gram = fitted(with_step)
    amount, sd = moments.amount(0, begin, now)
    assert amount[0] == pytest.approx(found[2])
    assert sd == pytest.approx(np.sqrt(left / (now + 1 - 3) * np.linalg.inv(gram)[2, 2]))


def test_few_runs_say_nothing() -> None:
    """No run, one, two and three are no history."""
    for n in range(4):
        assert changes(series(100.0 * noise(5, n)), ALPHA).changes == ()
