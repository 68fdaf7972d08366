"""A frame that shakes as one body from capture to capture is noise: no effect is made of it, and it is said."""

from dataclasses import replace

import numpy as np
import pytest

from labrig.diagnosis import diagnose, prepared, rows_from
from labrig.diagnosis._design import design_of, stilled
from labrig.diagnosis._diagnose import laid_out
from labrig.diagnosis._observations import Still, observe
from labrig.diagnosis._shaken import shaken
from tests.conftest import Lab
from tests.laws import power_law
from tests.naming import verdict_of

N = 60


def as_one_body(lab: Lab, shift_mm: np.ndarray, turn_rad: np.ndarray) -> np.ndarray:
    """How far the coordinates (n, 1, K) move with the frame, for shifts and turns (n, 3)."""
    away = lab.rest_mm - lab.rest_mm.mean(axis=0)
    return (shift_mm[:, None] + np.cross(turn_rad[:, None], away[None])).reshape(len(shift_mm), 1, -1)


def shaking(lab: Lab, seed: int) -> np.ndarray:
    """A mount that gives in all directions, anew for each capture."""
    random = np.random.default_rng(seed)
    return as_one_body(lab, random.normal(0, 0.3, (N, 3)), random.normal(0, 0.005, (N, 3)))


@pytest.fixture
def lab(make_lab, few_effects) -> Lab:
    """Twelve markers, and effects that move many of them."""
    few_effects("frame", "rest_shape", "gravity", "drift", "marker_slip", "creep", "regulator")
    return make_lab(chambers=2, markers=12, captures=N, rows_s=(3.0, 4.0))


def shakes_mm(lab: Lab, values: np.ndarray) -> float:
    """By how much the frame is said to shake, root mean square."""
    model = lab.model()
    ready, _, _ = laid_out(prepared(rows_from(lab.dataset(values)), model), model.library())
    return float(np.sqrt(np.mean(ready.floor.shakes**2)))


def test_a_shaking_frame_is_no_missing_effect_and_is_said(lab) -> None:
    """Where only the frame shakes, nothing is missing; a warning says by how much, and the floor has it."""
    moved = shaking(lab, 1)
    result = diagnose(lab.dataset(lab.predict(lab.u) + lab.noise() + moved), lab.model())
    assert result.summary["verdict"] == "nothing_missing"
    (line,) = [w for w in result.summary["warnings"] if "move together" in w]
    assert line.endswith("so look at the mounts of rig and cameras")
    size = float(np.sqrt(np.mean(moved**2)))
    assert float(line.split("by ")[1].split(" mm")[0]) == pytest.approx(size, rel=0.2)
    assert result.summary["error"]["floor"] == pytest.approx(np.hypot(size, 0.1), rel=0.3)


def test_an_effect_is_named_beside_a_shaking_frame(lab) -> None:
    """Creep is creep, whatever shakes."""
    found = verdict_of(lab.dataset(lab.predict(power_law(lab)) + lab.noise() + shaking(lab, 2)), lab.model())
    assert (found.verdict, found.effects) == ("identified", ("creep",))


def test_one_way_alone_may_shake(lab) -> None:
    """A table that shakes up and down is no other way less well measured."""
    shift = np.random.default_rng(3).normal(0, 0.4, (N, 3)) * [0, 0, 1]
    moved = as_one_body(lab, shift, np.zeros((N, 3)))
    model = lab.model()
    values = lab.predict(lab.u) + lab.noise() + moved
    ready, _, _ = laid_out(prepared(rows_from(lab.dataset(values)), model), model.library())
    by_axis = np.sqrt(np.square(ready.floor.shakes).reshape(-1, 3).mean(axis=0))
    assert by_axis[2] == pytest.approx(0.4, rel=0.25)
    assert by_axis[:2].max() < 0.1


@pytest.mark.parametrize(
    "how", ["moved once", "turns with the load", "creeps", "in its own way at each set-point"]
)
def test_what_follows_something_does_not_shake(lab, how) -> None:
    """A frame that was moved, turns with the load, creeps, or comes back with its set-point does not shake."""
    load = lab.commanded.mean(axis=1)[:, None] / lab.commanded.max()
    late = np.arange(N)[:, None] / N
    one = np.array([[0.5, -0.3, 0.4]])
    shift = {
        "moved once": one * (late > 0.4),
        "turns with the load": one * load,
        "creeps": one * np.sqrt(late),
        "in its own way at each set-point": np.array(
            [np.random.default_rng(int(1000 * np.abs(u).sum())).normal(0, 0.4, 3) for u in lab.commanded]
        ),
    }[how]
    values = lab.predict(lab.u) + lab.noise() + as_one_body(lab, shift, 0 * shift)
    assert shakes_mm(lab, values) < 0.05


def test_what_fills_gaps_does_not_shake(lab) -> None:
    """What stands where markers were out of sight says nothing of the frame, however far off it is."""
    model, gaps = lab.model(), np.arange(N) % 3 == 1
    values = lab.predict(lab.u) + lab.noise()
    values[gaps, :, :6] = np.nan
    values[0, 0, :6] = np.nan  # of this capture the other row was seen
    ready = prepared(rows_from(lab.dataset(values)), model)
    seen = observe(ready.context, ready.residual, ready.floor)
    assert (seen.whole == ~gaps).all()
    filled = seen.values.copy()
    filled[:N][gaps] += shaking(lab, 4)[gaps, 0] / 0.01
    for whole, shakes in ((seen.whole, False), (np.ones(N, dtype=bool), True)):
        design = design_of(replace(seen, values=filled, whole=whole), model.library(), None, None)
        assert bool(shaken(design).size) == shakes


@pytest.mark.parametrize(("shift_mm", "shakes"), [(0.03, False), (0.4, True)])
def test_what_shakes_little_more_than_its_noise_does_not_count(lab, shift_mm: float, shakes: bool) -> None:
    """Twelve markers tell of less than their noise, and laws are off by as much: from twice the noise on it is said."""
    shift = np.random.default_rng(4).normal(0, shift_mm, (N, 3)) * [0, 0, 1]
    values = lab.predict(lab.u) + lab.noise() + as_one_body(lab, shift, 0 * shift)
    assert (shakes_mm(lab, values) > 0) == shakes


def test_patterns_count_less_where_the_frame_shakes(lab) -> None:
    """What is expected of free patterns counts for as little as what is measured there, and elsewhere as before."""
    model = lab.model()
    values = lab.predict(lab.u) + lab.noise()
    _, seen, raw = laid_out(prepared(rows_from(lab.dataset(values)), model), model.library())
    still = Still.beside(raw.V @ np.random.default_rng(5).normal(size=(len(raw.spread), 2)))
    design = stilled(raw, replace(seen, still=still))
    expected = still.of(still.of((raw.V * raw.spread) @ raw.V.T).T)
    along = design.V.T @ expected @ design.V
    assert design.spread == pytest.approx(np.diag(along), rel=1e-3)
    assert design.counts[:2] == pytest.approx(still.less)
    assert (design.counts[2:] == 1).all()


def test_chambers_that_err_from_capture_to_capture_do_not_shake_the_frame(make_lab) -> None:
    """Regulators that come to another pressure each time move markers as chambers do, which is no frame's motion."""
    lab = make_lab(chambers=3, markers=12, captures=N, rows_s=(3.0, 4.0))
    off = np.random.default_rng(1).normal(0, 0.1, (N, 1, 3)) * lab.u.max()
    assert shakes_mm(lab, lab.predict(np.maximum(lab.u + off, 0)) + lab.noise()) < 0.05
