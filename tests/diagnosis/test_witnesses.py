"""What bears out an entry that looks mistaken, and what does not."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis._outliers import _clean, clean
from labrig.diagnosis._witnesses import Moments, _at_one_place, _leant
from labrig.effects import rows_of
from tests.naming import verdict_of

ROWS_S = (1.6, 3.0, 3.5, 4.0)


def gone_of(lab: Any, values: np.ndarray) -> np.ndarray:
    """Which entries (n, T, K) are taken for mistakes."""
    cleaned, _ = clean(lab.model().context(rows_of(lab.dataset(values))))
    return np.isnan(cleaned).reshape(values.shape)


def late(lab: Any, rate_kpa_s: float) -> np.ndarray:
    """Pressures of the rows (n, T, C) behind a small valve, which fills and vents at one rate at most."""
    before = np.concatenate([np.zeros((1, lab.chambers)), lab.commanded[:-1]])[:, None]
    way = before - lab.u
    return lab.u + np.sign(way) * np.maximum(np.abs(way) - rate_kpa_s * lab.hold_s[:, :, None], 0.0)


@pytest.mark.parametrize("settings", [{"markers": 1}, {"markers": 10}, {"force": True, "chambers": 1}])
def test_what_only_the_largest_steps_show_stays(make_lab, settings: dict[str, Any]) -> None:
    """A valve that is too slow for the largest steps shows in a few first rows only: they are no mistakes."""
    lab = make_lab(captures=240, rows_s=ROWS_S, **settings)
    u = late(lab, rate_kpa_s=20.0)
    effect = lab.predict(u) - lab.predict(lab.u)
    shown = np.abs(effect).max(axis=2) > 1.0
    assert not shown[:, 1:].any()
    assert 0.02 < shown[:, 0].mean() < 0.6
    gone = gone_of(lab, lab.predict(u) + lab.noise(row=0.03, capture=0.05))
    assert np.sum(effect[gone] ** 2) < 0.2 * np.sum(effect**2)


def test_a_stop_that_one_marker_meets_stays(make_lab) -> None:
    """What one marker does whenever one chamber is nearly full is borne out by where it comes."""
    lab = make_lab(captures=120, markers=12, rows_s=ROWS_S)
    values = lab.predict(lab.u) + lab.noise()
    met = lab.commanded[:, 1] > 0.92 * 60.0
    assert 4 <= met.sum() <= 20
    values[met, :, 17] -= 6.0
    assert gone_of(lab, values)[met, :, 17].mean() < 0.1


def test_mistakes_that_come_anywhere_go(make_lab) -> None:
    """Markers that are mistaken for a row or a hold, at moments that chance picks, go with all their axes."""
    lab = make_lab(captures=120, markers=12, rows_s=ROWS_S)
    values = lab.predict(lab.u) + lab.noise()
    wrong = np.zeros(values.shape, dtype=bool)
    for _ in range(40):
        capture, marker = lab.random.integers(120), lab.random.integers(12)
        rows = slice(None) if lab.random.random() < 0.5 else int(lab.random.integers(4))
        wrong[capture, rows, 3 * marker : 3 * marker + 3] = True
    values += np.where(wrong, 8.0 * np.sign(lab.random.normal(size=values.shape)), 0.0)
    gone = gone_of(lab, values)
    assert gone[wrong].mean() > 0.97
    assert gone[~wrong].mean() < 0.003


def test_mistakes_seldom_seem_to_have_a_place() -> None:
    """Of campaigns whose mistakes come anywhere, rows and whole holds, hardly one has any that its place bears out."""
    believed = 0
    for seed in range(100):
        random = np.random.default_rng(seed)
        capture = np.repeat(np.arange(200), 4)
        kpa = random.random((200, 4))
        step = np.diff(kpa, axis=0, prepend=0.0)
        late = np.tile(np.log1p(ROWS_S), 200)
        place = (kpa @ random.random((4, 30)))[capture]
        slopes, owner = np.zeros((800, 30, 4)), np.arange(30) // 3
        at = Moments(kpa[capture], step[capture], late, slopes, place, owner, np.zeros_like(owner), capture)
        wrong = (random.random((800, 10)) < 0.005) | (random.random((200, 10)) < 0.005)[capture]
        believed += bool(_at_one_place(np.repeat(wrong, 3, axis=1), at).any())
    assert believed <= 4


@pytest.mark.parametrize("markers", [4, 5, 6])
@pytest.mark.parametrize("seed", [1, 2])
def test_one_marker_of_few_that_is_off_for_a_hold_goes(make_lab, markers: int, seed: int) -> None:
    """Few markers follow a wild one, but those of the captures before and after do not."""
    lab = make_lab(captures=85, markers=markers, rows_s=ROWS_S, seed=seed)
    values = lab.predict(lab.u) + lab.noise(row=0.05, capture=0.06)
    values[30, :, 9:12] += (-4.7, 3.4, -6.1)
    gone = gone_of(lab, values)
    assert gone[30, :, 9:12].all()
    assert gone.sum() <= 12 + 0.005 * gone.size


def test_what_comes_again_at_the_same_pressure_stays(make_lab) -> None:
    """A wall that snaps through at one pressure, in the middle of the range, shows in a few captures: no mistakes."""
    lab = make_lab(captures=120, force=True, chambers=1, rows_s=ROWS_S)
    values = lab.predict(lab.u) + lab.noise()
    snapped = np.abs(lab.commanded[:, 0] - 31.0) < 1.8
    assert 3 <= snapped.sum() <= 8
    values[snapped] += 5.0
    assert not gone_of(lab, values)[snapped].any()


def test_a_valve_that_only_large_steps_show_is_a_delay(make_lab) -> None:
    """A valve that opens and closes softly, and takes the longer the larger the step, is named by a few first rows."""
    lab = make_lab(captures=120, force=True, chambers=2, rows_s=(1.2, 2.0, 3.0, 4.0))
    before = np.concatenate([np.zeros((1, 2)), lab.commanded[:-1]])[:, None]
    way = np.abs(before - lab.u)
    gone = np.clip(lab.hold_s[:, :, None] / np.maximum(way / 24.0, 1e-9), 0.0, 1.0)
    u = before + (lab.u - before) * gone**2 * (3 - 2 * gone)
    dataset = lab.dataset(lab.predict(u) + lab.noise(row=0.05, capture=0.05))
    found = verdict_of(dataset, lab.model())
    assert (found.verdict, found.effects) == ("identified", ("delay",))


@pytest.mark.parametrize("seed", range(3))
def test_a_wall_that_two_chambers_meet_together_stays(seed: int) -> None:
    """What stops a tip where it is farthest out, and a force beside it has, comes at no one pressure: no mistakes."""
    random = np.random.default_rng(seed)
    kpa = random.random((90, 2))
    bend, aside = 1.0 * kpa[:, 0], 0.8 * kpa[:, 1]
    turn = np.hypot(bend, aside) + 1e-9
    place = np.zeros((90, 10))
    for m, s in enumerate((0.4, 0.7, 1.0)):
        away = 100.0 * (1 - np.cos(s * turn)) / turn**2
        place[:, 3 * m : 3 * m + 3] = np.stack([away * bend, away * aside, np.sin(s * turn) / turn], axis=1)
    place[:, 9] = 2.7 * kpa[:, 0] + 1.1 * kpa[:, 1]
    beyond = np.maximum(place[:, 6] - np.quantile(place[:, 6], 0.8), 0.0)
    residual = random.normal(size=(90, 10)) * np.r_[np.full(9, 0.15), 0.01]
    residual[:, [0, 3, 6]] -= np.outer(beyond, [0.12, 0.5, 0.85])
    residual[:, 9] += 0.15 * beyond
    step = np.diff(kpa, axis=0, prepend=0.0)
    owner, index = np.append(np.arange(9) // 3, 3), np.arange(90)
    unit = np.append(np.zeros(9, dtype=int), 1)
    at = Moments(kpa, step, np.zeros(90), np.zeros((90, 10, 2)), place, owner, unit, index)
    cleaned, _ = _clean(residual, at)
    gone = np.isnan(cleaned).any(axis=1)
    assert gone[beyond > 0].sum() <= 2
    assert gone[beyond == 0].sum() <= 2


@pytest.mark.parametrize("seed", range(3))
def test_what_comes_again_at_a_set_point_stays(make_lab, seed: int) -> None:
    """One marker that is far off in both of two captures of one set-point meets something there; in one, it may be
    mistaken.
    """
    lab = make_lab(captures=60, markers=12, rows_s=ROWS_S, repeats=False, seed=seed)
    lab.commanded[41] = lab.commanded[8]
    lab.commanded[50] = lab.commanded[20]
    values = lab.predict(lab.u) + lab.noise()
    values[[8, 41], :, 17] -= 6.0
    values[20, :, 17] -= 6.0
    gone = gone_of(lab, values)
    assert not gone[[8, 41], :, 17].any()
    assert gone[20, :, 17].all()


def test_the_most_of_what_its_neighbours_are_off_by_stays(make_lab) -> None:
    """A marker that stops at a wall is held back the more the farther out it would be: the farthest are no mistakes."""
    kept = []
    for seed in range(6):
        lab = make_lab(captures=80, markers=12, rows_s=ROWS_S, reach_mm=30.0, repeats=False, seed=seed)
        values = lab.predict(lab.u) + lab.noise(row=0.03, capture=0.05)
        out = values[:, 0, 17].copy()
        held = 2 * np.maximum(out - np.quantile(out, 0.9), 0.0)
        values[:, :, 17] -= held[:, None]
        kept.append(1 - gone_of(lab, values)[held > 0.3 * held.max(), :, 17].mean())
    assert np.mean(kept) > 0.5


def in_a_row(values: list[float]) -> tuple[np.ndarray, Moments]:
    """One sensor's errors in captures of ever more pressure, which it follows; and what is known of them."""
    n = len(values)
    along = np.linspace(0, 1, n)[:, None]
    one, none = np.zeros(1, dtype=np.int64), np.zeros((n, 1))
    slopes = np.ones((n, 1, 1))
    at = Moments(along, none, np.zeros(n), slopes, along, one, one, np.arange(n))
    return np.array(values)[:, None], at


@pytest.mark.parametrize(
    ("near", "stays"),
    [([1.0] * 8, True), ([0.2] * 8, False), ([8.0] + [0.0] * 7, False), ([-1.0] * 8, False)],
    ids=["as its neighbours", "much farther than they", "as one of them", "the other way"],
)
def test_the_farthest_is_told_by_its_neighbours(near: list[float], stays: bool) -> None:
    """They are off by a quarter as much or more, most of them, and the same way."""
    values, at = in_a_row([0.0] * 20 + near + [3.5])
    far = np.arange(len(values))[:, None] == len(values) - 1
    assert _leant(values, far, at)[-1, 0] == stays


def test_mistakes_do_not_bear_each_other_out() -> None:
    """Neighbours that are far themselves are no witnesses."""
    values, at = in_a_row([0.0] * 20 + [9.0] * 9)
    assert not _leant(values, values > 5.0, at).any()


@pytest.mark.parametrize("comes_again", [True, False])
def test_what_swings_comes_again_at_the_same_set_point_and_time(make_lab, comes_again: bool) -> None:
    """A marker that still swings at the first rows of short holds is far beyond what is usual there: where the
    set-point comes twice it stays, and what one of the two alone has is a mistake.
    """
    rows_s = (1.0, 1.2, 1.4, 1.6, 1.8)
    lab = make_lab(captures=20, chambers=9, markers=30, rows_s=rows_s, repeats=False)
    lab.commanded = np.zeros((20, 9))
    for i in range(18):
        lab.commanded[i, i % 9] = 30.0
    values = lab.predict(lab.u) + lab.noise(row=0.03, capture=0.05)
    where = (3, 12) if comes_again else (3,)
    values[list(where), :, 17] += 4.0 * np.exp(-(np.array(rows_s) - 1.0) / 0.1)
    assert gone_of(lab, values)[3, 0, 17] != comes_again
