"""Noise that is another for each axis, marker or sensor: found as such, and no alarm."""

import numpy as np
import pytest

from labrig.diagnosis import diagnose, prepared, rows_from
from labrig.diagnosis._uneven import _from_most, profile, profile_of_means, spread
from tests.laws import orifice, power_law
from tests.naming import verdict_of

KINDS = ("a deep axis", "a marker at the edge", "each another")


def by(kind: str, markers: int) -> np.ndarray:
    """How much more noise each coordinate has than it would have, (K,)."""
    out = np.ones((markers, 3))
    if kind == "a deep axis":
        out[:, 2] = 4.0
    elif kind == "a marker at the edge":
        out[1] = 5.0
    else:
        out *= np.exp(np.random.default_rng(5).normal(0, 0.5, markers))[:, None]
    return out.ravel()


def test_uneven_noise_is_no_effect(make_lab) -> None:
    """Five times the noise of one marker, and nothing is missing."""
    lab = make_lab(captures=60, markers=8, rows_s=(3.0, 3.5))
    values = lab.predict(lab.u) + lab.noise() * by("a marker at the edge", 8)
    assert verdict_of(lab.dataset(values), lab.model()).verdict == "nothing_missing"


def test_of_two_markers_the_noisier_one_has_more(make_lab) -> None:
    """A tip beside a fixed marker that is hardly noisy: what is usual is the lesser, and nothing is missing."""
    lab = make_lab(captures=50, markers=2, rows_s=(3.0, 4.0, 5.0, 6.0), repeats=False)
    noise = lab.random.normal(size=(50, 4, 6)) * np.repeat([0.35, 0.1], 3)
    assert verdict_of(lab.dataset(lab.predict(lab.u) + noise), lab.model()).verdict == "nothing_missing"


def test_single_rows_may_be_uneven_by_axis(make_lab) -> None:
    """Where there is one row a set-point, and no repeats, each axis' spectrum says its noise."""
    lab = make_lab(chambers=2, captures=60, markers=8, rows_s=(3.0,), repeats=False)
    values = lab.predict(lab.u) + lab.noise() * by("a deep axis", 8)
    assert verdict_of(lab.dataset(values), lab.model()).verdict == "nothing_missing"


def test_an_effect_beside_uneven_noise_has_its_name(make_lab) -> None:
    """Creep is named as it is beside even noise."""
    lab = make_lab(chambers=2, captures=60, markers=8, rows_s=(1.0, 3.0, 8.0))
    values = lab.predict(power_law(lab)) + lab.noise() * by("each another", 8)
    assert verdict_of(lab.dataset(values), lab.model()).effects == ("creep",)


@pytest.mark.parametrize("trembles", [True, False])
def test_what_does_not_repeat_is_said_to_tremble(make_lab, few_effects, trembles: bool) -> None:
    """A frame that is elsewhere in each capture differs between repeats, too; an error of each set-point does not."""
    few_effects("frame", "rest_shape", "drift", "creep")
    lab = make_lab(chambers=2, captures=60, markers=8)
    random = np.random.default_rng(4)
    shifts = random.normal(size=(60, 3))
    if not trembles:
        for i in range(14, 59, 10):
            shifts[i], shifts[i + 1] = shifts[4], shifts[5]
    values = lab.predict(lab.u) + lab.noise() + 0.5 * np.tile(shifts, 8)[:, None]
    summary = diagnose(lab.dataset(values), lab.model()).summary
    assert summary["verdict"] == ("nothing_missing" if trembles else "unknown")
    said = [
        line for line in summary["warnings"] if "all markers move together from capture to capture" in line
    ]
    assert len(said) == int(trembles)


@pytest.mark.parametrize("kind", [*KINDS, "even"])
def test_the_floor_is_as_uneven_as_the_noise(make_lab, kind: str) -> None:
    """Of means and within holds each coordinate's own noise comes back; even noise stays even."""
    lab = make_lab(captures=100, markers=8, rows_s=(3.0, 3.5, 4.0), seed=3)
    more = np.ones(24) if kind == "even" else by(kind, 8)
    values = lab.predict(orifice(lab)) + lab.noise() * more
    floor = prepared(rows_from(lab.dataset(values)), lab.model()).floor
    most = np.maximum(more, np.median(more))  # of what has less noise than most no less is asked
    assert floor.within / (0.05 * most) == pytest.approx(np.ones(24), abs=0.25)
    mean = floor.mean / (np.hypot(0.1, 0.05 / np.sqrt(3)) * most)
    assert mean == pytest.approx(np.ones(24), abs=0.4)
    if kind == "even":
        assert floor.mean.max() < 1.2 * floor.mean.min()
        assert floor.within.max() < 1.2 * floor.within.min()


def test_chance_is_no_unevenness() -> None:
    """Of forty columns of the same noise none is taken for another; of one that has five times as much, that one is."""
    values = np.random.default_rng(0).normal(size=(60, 40))
    alone = [np.arange(40)]
    assert profile(values, 60, alone) == pytest.approx(np.ones(40), abs=0.1)
    values[:, 7] *= 5
    found = profile(values, 60, alone)
    assert found[7] == pytest.approx(5.0, rel=0.3)
    assert np.delete(found, 7) == pytest.approx(np.ones(39), abs=0.1)


def test_what_is_known_badly_is_pulled_to_most() -> None:
    """The same distance counts in full where it is known well, hardly where it is not, and not at all if unknown."""
    log = np.array([0.0, 0.0, 0.0, 1.5, 1.5, np.nan])
    variance = np.array([0.01, 0.01, 0.01, 0.01, 2.0, 0.01])
    off = _from_most(log, variance)
    assert off[:3] == pytest.approx(np.zeros(3), abs=0.02)
    assert off[3] == pytest.approx(1.5, rel=0.05)
    assert 0 < off[4] < 1.0
    assert off[5] == 0.0
    assert _from_most(np.array([1.0, np.nan]), np.ones(2)).tolist() == [0.0, 0.0]


def test_noise_of_rows_is_uneven_where_that_of_means_is_not() -> None:
    """Repeats say how much of what is uneven within holds is in the captures' means as well: here nothing."""
    random = np.random.default_rng(1)
    within = np.repeat([1.0, 4.0], [16, 8])
    alone = [np.arange(24) % 3, np.arange(24)]
    even = profile_of_means(np.zeros((60, 24)), random.normal(size=(10, 24)), within, alone)
    assert even == pytest.approx(np.ones(24) * np.median(even), rel=0.3)
    same = profile_of_means(np.zeros((60, 24)), random.normal(size=(10, 24)) * within, within, alone)
    assert same / same[0] == pytest.approx(within, rel=0.35)


def test_the_spread_is_that_of_most() -> None:
    """A tenth of the values far out, or unseen, does not move it; of none there is none."""
    values = np.random.default_rng(2).normal(size=5000)
    values[:300], values[300:600] = 100.0, np.nan
    assert spread(values) == pytest.approx(1.0, rel=0.12)
    assert spread(np.full(3, np.nan)) == 0.0


@pytest.mark.parametrize("repeats", [True, False])
def test_what_repeats_differ_by_is_said_where_it_is_more_than_noise(
    make_lab, few_effects, repeats: bool
) -> None:
    """A body that breathes anew in each capture is nothing that was recorded, and its repeats say so; one that breathes
    by its set-point, in no way that anything holds, repeats.
    """
    few_effects("frame", "rest_shape", "drift", "creep")
    lab = make_lab(chambers=2, captures=60, markers=8)
    random = np.random.default_rng(4)
    breath = random.normal(size=60)
    if repeats:
        for i in range(14, 59, 10):
            breath[i], breath[i + 1] = breath[4], breath[5]
    away = (lab.rest_mm - lab.rest_mm.mean(axis=0)).ravel() * np.where(np.arange(24) // 3 % 2, 1, -1)
    values = lab.predict(lab.u) + lab.noise() + 0.02 * breath[:, None, None] * away
    summary = diagnose(lab.dataset(values), lab.model()).summary
    assert summary["verdict"] == "unknown"
    said = [line for line in summary["warnings"] if "does not repeat, so look at what trembles" in line]
    assert len(said) == int(not repeats)
