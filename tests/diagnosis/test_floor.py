"""The noise floor: known noise is found, whatever else the residuals hold."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d

from labrig.diagnosis import _problem, compare, diagnose, prepared
from labrig.diagnosis._floor import noise_floor
from labrig.effects import capture_means, rows_of
from labrig.effects._spectrum import bulk_edge, bulk_noise
from labrig.model import Model, base_context, build_base
from tests.laws import orifice, power_law, sliding


def floor_of(lab: Any, values: np.ndarray, lost: int = 0) -> Any:
    """The floor of what a lab's own base leaves."""
    model = lab.model()
    rows = rows_of(lab.dataset(values))
    context = base_context(build_base(model.file, model.folder, rows), rows)
    return noise_floor(context, context.residual, lost)


def test_white_noise_is_found(make_lab) -> None:
    """Noise of captures and of rows come back apart, for every observable."""
    lab = make_lab(captures=100, rows_s=(3.0, 3.5, 4.0, 4.5))
    floor = floor_of(lab, lab.predict(lab.u) + lab.noise(row=0.2, capture=0.3))
    assert floor.mean == pytest.approx(np.full(18, np.hypot(0.3, 0.2 / 2)), rel=0.15)
    assert floor.within == pytest.approx(np.full(18, 0.2), rel=0.25)
    assert floor.row == pytest.approx(np.full(18, np.hypot(0.3, 0.2)), rel=0.15)
    assert floor.repeats["mm"]["same history"] == pytest.approx(0.316, rel=0.4)
    assert floor.repeats["mm"]["within a capture"] == pytest.approx(0.2, rel=0.25)
    assert floor.repeats["mm"]["early against late"] is not None


@pytest.mark.parametrize("rows", [1, 2, 3, 6])
def test_the_noise_of_a_row_is_counted_once(make_lab, rows: int) -> None:
    """What a capture's mean has of the noise of its rows is not added to it again."""
    lab = make_lab(captures=200, rows_s=tuple(3.0 + 0.5 * np.arange(rows)))
    floor = floor_of(lab, lab.predict(lab.u) + lab.noise(row=0.2, capture=0.05))
    assert np.sqrt(np.mean(floor.row**2)) == pytest.approx(np.hypot(0.2, 0.05), rel=0.06)


@pytest.mark.parametrize("rows", [2, 3, 4])
def test_noise_within_holds_is_not_taken_too_small(make_lab, rows: int) -> None:
    """However many rows a hold has, steps from one hold to the next do not pass for steps within it."""
    lab = make_lab(captures=300, rows_s=tuple(3.0 + 0.5 * np.arange(rows)))
    floor = floor_of(lab, lab.predict(lab.u) + lab.noise(row=0.2, capture=0.3))
    assert floor.within[0] == pytest.approx(0.2, rel=0.035)


@pytest.mark.parametrize("law", [orifice, power_law, sliding])
@pytest.mark.parametrize("rows_s", [(3.0, 3.5), (1.0, 3.0, 8.0), (1.0, 2.0, 4.0, 9.0)])
@pytest.mark.parametrize("force", [False, True])
def test_what_changes_along_a_hold_is_no_noise(make_lab, law, rows_s, force: bool) -> None:
    """Two rows, or three that lie ever farther apart, say the noise within holds beside a leak of ten floors too."""
    lab = make_lab(captures=100, rows_s=rows_s, force=force)
    u = law(lab)
    u = lab.u + (u - lab.u) * 10 * np.hypot(0.05, 0.1) / np.sqrt(
        np.mean((lab.predict(u) - lab.predict(lab.u)) ** 2)
    )
    assert floor_of(lab, lab.predict(u) + lab.noise()).within[0] == pytest.approx(0.05, rel=0.3)


def test_an_effect_does_not_lift_the_floor(make_lab) -> None:
    """Residuals of ten floors that depend on the pressures leave the floor where it is."""
    lab = make_lab(captures=100)
    floor = floor_of(lab, lab.predict(lab.u * 1.1) + lab.noise())
    assert floor.mean[0] == pytest.approx(0.104, rel=0.2)


def test_history_and_drift_are_no_noise(make_lab) -> None:
    """Repeats from elsewhere, and early against late, are listed but do not make the floor."""
    lab = make_lab(captures=100)
    before = np.concatenate([np.zeros((1, 3)), lab.commanded[:-1]])[:, None]
    late = np.linspace(0, 2, 100)[:, None, None]
    floor = floor_of(lab, lab.predict(lab.u + 0.1 * (before - lab.u)) + late + lab.noise())
    assert floor.mean[0] == pytest.approx(0.104, rel=0.35)
    assert floor.repeats["mm"]["early against late"] > 5 * floor.mean[0]
    assert "repeats" in floor.how or "spectrum" in floor.how


def test_without_repeats_the_spectrum_says_it(make_lab) -> None:
    """The bulk of the singular values is the noise, and it is said that nothing was repeated."""
    lab = make_lab(captures=60, repeats=False)
    floor = floor_of(lab, lab.predict(lab.u * 1.1) + lab.noise())
    assert floor.how == "the bulk of the residuals' spectrum (no same-history repeats)"
    assert floor.mean[0] == pytest.approx(0.104, rel=0.25)
    assert floor.repeats["mm"]["same history"] is None


def test_repeats_are_recognised_without_labels(make_lab) -> None:
    """Equal set-points with equal predecessors count as repeats though nobody called them so."""
    lab = make_lab(captures=60)
    lab.label = [""] * 60
    floor = floor_of(lab, lab.predict(lab.u) + lab.noise())
    assert floor.repeats["mm"]["same history"] == pytest.approx(0.104, rel=0.6)


def test_one_force_with_few_captures(make_lab) -> None:
    """A single observable has no spectrum: repeats say it, and without them the noise within a hold."""
    lab = make_lab(chambers=1, force=True, captures=400)
    floor = floor_of(lab, lab.predict(lab.u) + lab.noise(row=0.2, capture=0.3))
    assert floor.how == "repeats with the same history"
    assert floor.mean[0] == pytest.approx(np.hypot(0.3, 0.2 / np.sqrt(3)), rel=0.25)
    few = make_lab(chambers=1, force=True, captures=8, repeats=False)
    floor = floor_of(few, few.predict(few.u) + few.noise(row=0.2, capture=0.0))
    assert floor.how == "the noise within a capture (no same-history repeats)"
    assert floor.mean[0] == pytest.approx(0.2, rel=0.6)


def test_a_continuous_record_is_judged_by_its_neighbours(make_lab) -> None:
    """Single rows of one observable: second differences, which a smooth course does not move."""
    lab = make_lab(chambers=1, force=True, captures=200, rows_s=(3.0,), repeats=False)
    lab.commanded = lab.random.uniform(0, 60, (200, 1))
    smooth = 5 * np.sin(np.arange(200) / 30)[:, None, None]
    floor = floor_of(lab, lab.predict(lab.u) + smooth + lab.noise(row=0.2, capture=0.0))
    assert floor.how == "differences between neighbouring captures (no same-history repeats)"
    assert floor.mean[0] == pytest.approx(0.2, rel=0.2)


def test_no_noise_at_all_is_no_zero(make_lab) -> None:
    """Exact data have a tiny floor, so that nothing is divided by zero."""
    lab = make_lab(captures=20, repeats=False)
    floor = floor_of(lab, lab.predict(lab.u * 1.1))
    assert (floor.mean > 0).all()
    assert (floor.mean < 1e-2).all()


@pytest.mark.parametrize(("n", "K", "rank"), [(60, 102, 5), (150, 30, 3), (40, 12, 0)])
def test_the_bulk_of_a_spectrum(n: int, K: int, rank: int) -> None:
    """Noise under a signal of low rank is found to a tenth, with a tenth of the entries missing too."""
    rng = np.random.default_rng(0)
    noise = 0.3 * rng.normal(size=(n, K))
    matrix = noise + 20 * rng.normal(size=(n, rank)) @ rng.normal(size=(rank, K))
    assert bulk_noise(matrix) == pytest.approx(0.3, rel=0.1)
    assert np.linalg.norm(noise, 2) < 0.3 * bulk_edge(n, K)
    matrix[rng.random((n, K)) < 0.1] = np.nan
    assert bulk_noise(matrix) == pytest.approx(0.3, rel=0.2)


def test_lost_degrees_of_freedom_are_allowed_for() -> None:
    """A fit of ten regressors takes their share of the noise; told of it, the estimate stays."""
    rng = np.random.default_rng(0)
    X, noise = rng.normal(size=(40, 10)), 0.3 * rng.normal(size=(40, 60))
    left = noise - X @ np.linalg.lstsq(X, noise, rcond=None)[0]
    assert bulk_noise(left, 10) == pytest.approx(0.3, rel=0.1)
    assert bulk_noise(left, 0) < 0.25


def test_what_was_never_seen_changes_no_noise() -> None:
    """Columns and rows of which nothing was seen are as if they were not there; of nothing at all nothing is said."""
    matrix = 0.3 * np.random.default_rng(0).normal(size=(40, 18))
    more = np.pad(matrix, ((0, 7), (0, 12)), constant_values=np.nan)
    assert bulk_noise(more) == bulk_noise(matrix)
    assert np.isnan(bulk_noise(np.full((40, 9), np.nan)))


def test_a_small_matrix_says_nothing() -> None:
    """Fewer than six rows or columns have no bulk."""
    assert np.isnan(bulk_noise(np.ones((40, 5))))
    assert np.isnan(bulk_noise(np.ones((5, 40))))


def test_means_of_captures_skip_what_was_not_seen() -> None:
    """The mean is over the rows that have a value; NaN where none has."""
    values = np.array([[1.0, np.nan], [3.0, np.nan], [5.0, 2.0], [np.nan, 4.0]])
    means, captures = capture_means(values, np.array([0, 0, 7, 7]))
    assert captures.tolist() == [0, 7]
    assert means == pytest.approx(np.array([[2.0, np.nan], [5.0, 3.0]]), nan_ok=True)


@pytest.mark.parametrize("step", [0.5, 2.0])
def test_a_coarse_sensor_hides_nothing(make_lab, step) -> None:
    """Where repeats are alike to the last digit, the floor is what rounding to the recorded steps leaves."""
    lab = make_lab(chambers=2, captures=60, seed=1, force=True)
    values = lab.predict(lab.u) + 0.001 * lab.random.normal(size=(60, 3, 1))
    found = diagnose(lab.dataset(step * np.round(values / step)), lab.model())
    assert found.summary["verdict"] == "nothing_missing"
    assert found.summary["floor"]["how"].startswith("the steps in which it was recorded")
    assert found.summary["error"]["floor"] == pytest.approx(step / np.sqrt(12), rel=0.25)


@pytest.mark.parametrize("most", [480, 1200, 3000])
def test_the_floor_of_a_stream_does_not_hang_on_how_it_was_thinned(
    make_lab, monkeypatch: pytest.MonkeyPatch, most: int
) -> None:
    """A long record of slow strokes has the noise of its rows as floor, however few of them are worked on."""
    monkeypatch.setattr(_problem, "MOST_ROWS", most)
    lab = make_lab(chambers=2, force=True, captures=3000, rows_s=(0.05,), repeats=False)
    t = np.arange(len(lab.commanded))[:, None]

    def strokes(at: np.ndarray) -> np.ndarray:
        return 30 + 28 * np.sin(2 * np.pi * at / np.array([60.7, 37.0 * np.sqrt(2)]))

    lab.commanded[:] = strokes(t)
    lab.label[:] = [""] * len(t)
    lagging = strokes(t - 3)[:, None]
    noise = np.random.default_rng(3).normal(0, 0.1, (len(t), 1, 1))
    ready = prepared(rows_of(lab.dataset(lab.predict(lagging) + noise)), lab.model())
    assert ready.floor.mean[0] == pytest.approx(0.1, rel=0.2)
    assert ready.residual.std() > 5 * ready.floor.mean[0]


def test_a_stroke_up_is_no_repeat_of_the_stroke_down(make_lab) -> None:
    """A stream whose pressures come again on the way back: the floor is its noise, not the width of the loop."""
    lab = make_lab(chambers=1, force=True, captures=1200, rows_s=(0.05,), repeats=False)

    def strokes(at: np.ndarray) -> np.ndarray:
        return 60 * np.abs((at / 60) % 2 - 1)

    t = np.arange(1200.0)[:, None]
    lab.commanded[:] = strokes(t)
    lab.label[:] = [""] * len(t)
    noise = np.random.default_rng(3).normal(0, 0.1, (len(t), 1, 1))
    ready = prepared(rows_of(lab.dataset(lab.predict(strokes(t - 4)[:, None]) + noise)), lab.model())
    assert ready.floor.mean[0] == pytest.approx(0.1, rel=0.2)


def test_one_pair_of_repeats_may_be_alike_by_chance(make_lab) -> None:
    """Two captures that hardly differ do not make the floor of sixty."""
    lab = make_lab(captures=60, markers=4, repeats=False)
    lab.commanded[2:4] = lab.commanded[:2]
    lab.label[1] = lab.label[3] = "twice"
    noise = lab.noise(row=0.05, capture=0.1)
    noise[3] = noise[1] + 0.001 * np.sign(noise[1])
    floor = floor_of(lab, lab.predict(lab.u) + noise)
    assert floor.mean == pytest.approx(np.full(12, 0.104), rel=0.15)


def each(white: np.ndarray) -> np.ndarray:
    """A sensor as fast as the log."""
    return white


def one_for_five(white: np.ndarray) -> np.ndarray:
    """A sensor whose value stands until its next one."""
    return np.repeat(white[::5], 5, axis=0)


def mean_of_nine(white: np.ndarray) -> np.ndarray:
    """A sensor that smooths."""
    return 3 * uniform_filter1d(white, 9, axis=0)


@pytest.mark.parametrize("sensor", [each, one_for_five, mean_of_nine])
def test_a_sensor_that_is_slower_than_the_log_has_its_own_noise(
    make_lab, sensor: Callable[[np.ndarray], np.ndarray]
) -> None:
    """A stream whose neighbours differ by less than its noise, or not at all: the floor is the noise."""
    lab = make_lab(chambers=2, markers=4, captures=2000, rows_s=(0.05,), repeats=False)
    random = np.random.default_rng(3)
    lab.commanded[:] = np.repeat(random.uniform(0, 60, (40, 2)).round(1), 50, axis=0)
    lab.label[:] = [""] * 2000
    noise = sensor(random.normal(0, 0.1, (2000, 1, 12)))
    ready = prepared(rows_of(lab.dataset(0.97 * lab.predict(lab.u) + noise)), lab.model())
    assert ready.floor.mean == pytest.approx(np.full(12, 0.1), rel=0.1)


def test_the_repeats_of_a_result_are_in_its_unit(make_lab) -> None:
    """A force that stands before the markers does not lend them its newtons: repeats differ by what they do in mm."""
    lab = make_lab(chambers=2, captures=40)
    values = lab.predict(lab.u) + lab.noise()
    run = lab.dataset(values)
    alone = compare(run, lab.model()).summary["floor"]["repeats"]["same history"]
    force = 1000.0 * lab.random.normal(size=(*values.shape[:2], 1))
    axes = [f"{m}.{a}" for m in run["marker"].values for a in "xyz"]
    run = run.drop_vars(["position_mm", "rest_mm"]).assign(
        observed=(("capture", "time", "observable"), np.concatenate([force, values], axis=2))
    )
    run = run.assign_coords(
        observable=["force", *axes],
        unit=("observable", ["N", *["mm"] * len(axes)]),
        marker_of=("observable", ["", *(name[:-2] for name in axes)]),
        axis_of=("observable", ["", *(name[-1] for name in axes)]),
    )
    model = Model.of(lambda u: np.column_stack([np.zeros(len(u)), lab.predict(u[:, None])[:, 0]]))
    summary = compare(run, model).summary
    assert summary["units"] == "mm"
    assert summary["floor"]["repeats"]["same history"] == pytest.approx(alone, rel=0.1)
