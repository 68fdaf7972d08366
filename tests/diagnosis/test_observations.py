"""Observations: independent numbers of unit noise, whatever the holds are like and what was mistaken or not seen."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from labrig.diagnosis._directions import directions
from labrig.diagnosis._floor import Floor
from labrig.diagnosis._observations import Observations, observe
from labrig.diagnosis._problem import prepared
from labrig.effects import rows_of

LONG_S = (3.0, 5.0, 10.0, 20.0, 30.0)
ROW, CAPTURE = 0.3, 0.4


def observed(lab: Any, values: np.ndarray, **known: float) -> Observations:
    """What a lab measured, as observations; with the floor given where it is `known`."""
    ready = prepared(rows_of(lab.dataset(values)), lab.model())
    floor = ready.floor
    if known:
        each = {name: np.full(len(floor.mean), size) for name, size in known.items()}
        floor = Floor(
            each["mean"],
            each["within"],
            "given",
            {},
            np.zeros(len(each["mean"]), dtype=int),
            np.zeros((len(each["mean"]), 0)),
            np.full(len(each["mean"]), np.inf),
        )
    return observe(ready.context, ready.residual, floor)


def test_noise_becomes_white(make_lab) -> None:
    """Of noise of captures and of rows, the covariance of the observations is exactly diagonal, of contrasts one."""
    lab = make_lab(captures=20, rows_s=(3.0, 4.0, 5.0), long_s=LONG_S)
    mean = np.hypot(CAPTURE, ROW / np.sqrt(3))
    seen = observed(lab, lab.predict(lab.u) + lab.noise(), mean=mean, within=ROW)
    T = seen.whiten.toarray()
    same = seen.index[:, None] == seen.index
    made = T @ (ROW**2 * np.eye(len(same)) + CAPTURE**2 * same) @ T.T / mean**2
    n = seen.n_captures
    assert made - np.diag(np.diag(made)) == pytest.approx(0.0, abs=1e-12)
    assert np.diag(made)[n:] == pytest.approx(1.0)
    short = np.bincount(seen.index) == 3
    assert np.diag(made)[:n][short] == pytest.approx(1.0)
    assert (np.diag(made)[:n][~short] < 1.0).all()  # means of more rows have less
    assert seen.values == pytest.approx(T @ (seen.context.residual / mean))


def test_drawn_noise_has_unit_variance_and_no_correlation(make_lab) -> None:
    """As estimated from the data themselves, means and contrasts have a variance near one and none in common."""
    lab = make_lab(captures=300, rows_s=(3.0, 3.5, 4.0))
    seen = observed(lab, lab.predict(lab.u) + lab.noise(row=0.2, capture=0.2))
    n = seen.n_captures
    assert (seen.values[:n] ** 2).mean() == pytest.approx(1.0, abs=0.12)
    assert (seen.values[n:] ** 2).mean() == pytest.approx(1.0, abs=0.06)
    first, second = seen.values[n::2].ravel(), seen.values[n + 1 :: 2].ravel()
    assert abs(np.corrcoef(first, second)[0, 1]) < 4 / np.sqrt(first.size)
    assert abs(np.corrcoef(first, seen.values[:n].ravel())[0, 1]) < 4 / np.sqrt(first.size)


def test_rows_of_a_long_record_say_nearly_the_same(make_lab) -> None:
    """However many rows a hold has, it counts as twelve: its contrasts together weigh no more."""
    lab = make_lab(
        chambers=1, force=True, captures=1, rows_s=tuple(np.arange(1.0, 200.0, 0.2)), repeats=False
    )
    seen = observed(lab, lab.predict(lab.u) + lab.noise(), mean=1.0, within=ROW)
    rows = seen.whiten.shape[1]
    assert rows > 24
    T = seen.whiten.toarray()[1:]
    assert len(T) == rows - 1
    assert ROW**2 * np.trace(T @ T.T) == pytest.approx(12 * (rows - 1) / rows)


@pytest.mark.parametrize("settings", [{"markers": 12}, {"markers": 4}, {"force": True, "chambers": 1}])
def test_mistaken_rows_inside_holds_leave_the_noise_as_it_is(make_lab, settings: dict[str, Any]) -> None:
    """Single rows that are off by ten to thirty times their noise do not pass for noise: chi-square stays near one."""
    lab = make_lab(captures=150, rows_s=(3.0, 3.5, 4.0, 4.5), **settings)
    values = lab.predict(lab.u) + lab.noise(row=0.1, capture=0.1)
    bad = lab.random.random(values.shape) < 0.005
    size = lab.random.uniform(1.0, 3.0, values.shape) * lab.random.choice([-1.0, 1.0], values.shape)
    seen = observed(lab, values + np.where(bad, size, 0.0))
    contrasts = seen.values[seen.n_captures :]
    assert (contrasts**2).mean() == pytest.approx(1.0, abs=0.15)


def test_what_there_is_to_explain(make_lab) -> None:
    """Three floors of an offset are three floors to explain, beside noise or without; noise alone is nothing."""
    lab = make_lab(captures=60, rows_s=(3.0, 3.5, 4.0))
    noise = lab.noise(row=0.1, capture=0.1)
    mean = float(np.hypot(0.1, 0.1 / np.sqrt(3)))
    for size in (0.0, 3.0):
        values = lab.predict(lab.u) + size * mean + noise
        assert observed(lab, values, mean=mean, within=0.1).to_explain == pytest.approx(size, abs=0.3)


@pytest.mark.parametrize("markers", [6, 12])
def test_what_was_never_seen_says_nothing(make_lab, markers: int) -> None:
    """A marker out of sight in every capture is no marker without error: no direction has any of it."""
    lab = make_lab(captures=30, markers=markers)
    values = lab.predict(1.1 * lab.u) + lab.noise()
    whole = observed(lab, values)
    values[:, :, 3:6] = np.nan
    seen = observed(lab, values)
    assert seen.seen.sum() == 3 * markers - 3
    V, spread = directions(seen, [])
    assert V.shape[1] == len(spread) <= 3 * markers - 3
    assert V[~seen.seen] == pytest.approx(0.0, abs=1e-6)
    assert np.abs(V.T @ V - np.eye(V.shape[1])).max() < 1e-5
    assert seen.to_explain == pytest.approx(whole.to_explain, rel=0.3)


@pytest.mark.parametrize("share", [0.1, 0.4])
def test_rows_out_of_sight_are_no_mistakes(make_lab, share: float) -> None:
    """Where single rows were not seen, what stands in for them differs from their hold by no more than noise does."""
    lab = make_lab(captures=100, markers=6, rows_s=(3.0, 3.5, 4.0, 4.5))
    values = lab.predict(1.1 * lab.u) + lab.noise(row=0.05, capture=0.3)
    values[lab.random.random(values.shape) < share] = np.nan
    seen = observed(lab, values)
    assert (seen.values[seen.n_captures :] ** 2).mean() < 1.1


def test_captures_in_any_order(make_lab) -> None:
    """Rows of one capture need not follow each other: observations are those of the sorted rows."""
    lab = make_lab(captures=20, long_s=LONG_S)
    ready = prepared(rows_of(lab.dataset(lab.predict(lab.u) + lab.noise())), lab.model())
    seen = observe(ready.context, ready.residual, ready.floor)
    order = np.argsort(np.random.default_rng(0).random(len(seen.index)) + 0.0)
    order = order[np.argsort(ready.context.rows.hold_s[order], kind="stable")]
    mixed = replace(ready.context.rows, capture=ready.context.rows.capture[order])
    again = observe(replace(ready.context, rows=mixed), ready.residual[order], ready.floor)
    assert again.values == pytest.approx(seen.values)
    assert (again.capture == seen.capture).all()


def test_what_stays_as_it_is_is_nothing_within_holds(make_lab) -> None:
    """Rows that are the same all through a hold are captures' means, and exactly nothing beside; any others are what
    the weights make of them.
    """
    lab = make_lab(captures=20, rows_s=(3.0, 4.0, 5.0), long_s=LONG_S)
    own = observed(lab, lab.predict(lab.u) + lab.noise())
    still = np.random.default_rng(1).normal(size=(own.n_captures, 3))
    seen = own.of_rows(still[own.index].astype(np.float32), own.whiten.astype(np.float32))
    assert seen[: own.n_captures] == pytest.approx(still, rel=1e-6)
    assert not seen[own.n_captures :].any()
    rows = np.random.default_rng(2).normal(size=(len(own.index), 3))
    assert own.of_rows(rows) == pytest.approx(own.whiten @ rows)
