"""Mistaken values: what is dropped before anything is estimated, and what only looks like a mistake."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig.diagnosis import prepared, rows_from
from labrig.diagnosis._outliers import clean
from labrig.effects import rows_of
from labrig.model import Model
from tests.sensors import model_of_both, two_sensors

LONG_S = (3.0, 5.0, 10.0, 30.0)
FINGER = ((20.0, 0.6), (55.0, 4.0), (90.0, 9.0))
"""Where the markers of a finger are, mm, and how far each goes for each bar."""


def cleaned_of(lab: Any, values: np.ndarray) -> tuple[np.ndarray, int]:
    """What is left of a lab's residual, and how many values were dropped."""
    return clean(lab.model().context(rows_of(lab.dataset(values))))


def test_outliers_go_and_a_slip_stays(make_lab) -> None:
    """A marker mistaken for a capture or a frame is dropped; one that moves and stays off is not."""
    lab = make_lab(captures=40, markers=12)
    values = lab.predict(lab.u) + lab.noise()
    bad = [(5, 0, 7), (11, 1, 3), (23, 2, 30)]
    for capture, row, k in bad:
        values[capture, row, k] += 25.0
    values[17, :, 12:15] += 30.0
    values[25:, :, 21:24] += 4.0
    cleaned, dropped = cleaned_of(lab, values)
    gone = np.isnan(cleaned).reshape(40, 3, 36)
    assert all(gone[entry] for entry in bad)
    assert gone[17, :, 12:15].all()
    assert gone[25:, :, 21:24].mean() < 0.5
    elsewhere = np.delete(gone, [21, 22, 23], axis=2).sum()
    assert elsewhere <= 3 + 9 + 0.01 * gone.size
    assert dropped == gone.sum()


def test_a_large_effect_is_no_outlier(make_lab) -> None:
    """A sharp kink of one chamber, and a jump between sessions, are left as they are."""
    lab = make_lab(captures=40, markers=12, sessions=2)
    u = lab.u
    u[:, :, 0] -= 0.7 * np.maximum(u[:, :, 0] - 45, 0)
    values = lab.predict(u) + lab.noise()
    values[20:] += 3.0
    _, dropped = cleaned_of(lab, values)
    assert dropped <= 0.005 * values.size


def test_a_body_that_is_bent_in_a_few_captures_is_no_mistake(make_lab) -> None:
    """Where four of twelve markers are far at once, along one axis, it is the body; two at once are dropped."""
    lab = make_lab(captures=60, markers=12)
    values = lab.predict(lab.u) + lab.noise()
    bent, wrong = (9, 31, 47), 20
    for capture in bent:
        values[capture, :, 2 : 2 + 3 * 4 : 3] -= np.array([8.0, 14.0, 19.0, 12.0])
    values[wrong, :, [2, 20]] += 15.0
    cleaned, _ = cleaned_of(lab, values)
    gone = np.isnan(cleaned).reshape(60, 3, 36)
    assert gone[list(bent)].mean() < 0.05
    assert gone[wrong][:, [2, 20]].all()


def test_two_mistakes_in_a_row_of_a_few_observables_go(make_lab) -> None:
    """Neighbours that are mistaken themselves do not make a mistake believed, be they rows or whole captures."""
    lab = make_lab(captures=40, markers=1)
    values = lab.predict(lab.u) + lab.noise()
    values[5, 1, 0] += 25.0
    values[6, 0, 0] += 30.0
    values[20:22, :, 1] -= 28.0
    cleaned, dropped = cleaned_of(lab, values)
    gone = np.isnan(cleaned).reshape(40, 3, 3)
    assert gone[5, 1, 0]
    assert gone[6, 0, 0]
    assert gone[20:22, :, 1].all()
    assert dropped <= 3 * 8 + 0.01 * gone.size


@pytest.mark.parametrize("seed", range(3))
def test_what_is_small_in_its_unit_is_not_compared_with_the_rest(make_lab, seed: int) -> None:
    """A tip with the parts of its quaternion, and two markers that stand still: nothing of their noise is mistaken,
    and one frame that is still is.
    """
    lab = make_lab(captures=50, markers=3, rows_s=(3.0, 4.0, 5.0, 6.0), repeats=False, seed=seed)
    lab.reach[3:] = 0.0
    random = np.random.default_rng(seed)
    places = lab.predict(lab.u) + random.normal(size=(50, 4, 9)) * np.repeat([0.35, 0.1, 0.1], 3)
    places[20, 2, 3:6] += 5.0
    turned = 0.3 * lab.u[..., [0, 1, 2, 0]] / 60.0
    run = lab.dataset(places)
    run["observed"] = (("capture", "time", "observable"), turned + 0.002 * random.normal(size=turned.shape))
    ways = [f"q{w}" for w in "xyzw"]
    run = run.assign_coords(observable=ways, unit=("observable", ["1"] * 4))
    run = run.assign_coords(marker_of=("observable", [""] * 4), axis_of=("observable", [""] * 4))
    model = Model.of(lambda u: np.hstack([lab.predict(u), 0.3 * u[:, [0, 1, 2, 0]] / 60.0]))
    cleaned, _ = clean(model.context(rows_of(run)))
    gone = np.isnan(cleaned).reshape(50, 4, 13)
    assert gone[20, 2, 3:6].all()
    assert gone.sum() <= 3 + 0.001 * gone.size


@pytest.mark.parametrize("seed", [0, 2, 5])
def test_a_finger_beside_a_room_that_warms_has_no_mistakes(tmp_path: Path, seed: int) -> None:
    """Three markers with even noise, a fitted parabola, creep of two time constants, and a thermometer without noise:
    none of it is left out, though a few directions follow all but one marker.
    """
    random = np.random.default_rng(seed)
    fast = slow = 0.0
    rows = []
    for bar in np.concatenate([random.permutation(np.arange(7) * 0.4) for _ in range(7)]):
        for _ in range(10):
            for _ in range(4):
                fast, slow = fast + 0.2 * (0.1 * bar - fast), slow + 0.02 * (0.12 * bar - slow)
            q = bar + fast + slow
            places = [(at - 0.02 * (g * q) ** 2, 0.1 * g * q, g * q - 0.01 * g * q**2) for at, g in FINGER]
            rows.append([2.0 * len(rows), bar, *np.ravel(places), 21 + 0.001 * len(rows)])
    values = np.array(rows)
    values[:, 2:11] += random.normal(0, 0.03, (len(rows), 9))
    names = [f"{m} {x} [mm]" for m in ("base", "mid", "tip") for x in "xyz"]
    values[:, 11] = values[:, 11].round(2)
    frame = pd.DataFrame(values.round(3), columns=["t [s]", "p_set [bar]", *names, "Raumtemp"])
    (tmp_path / "map.yaml").write_text("base: {kind: static, degree: 2}\n")
    run = labrig.import_table(frame, tmp_path / "run")
    ready = prepared(rows_from(run), Model.load(tmp_path / "map.yaml"))
    assert ready.dropped == 0


def test_what_others_at_the_same_pressures_say_is_believed(make_lab) -> None:
    """A limit that a few captures meet, one here and one there, is no mistake of those captures; one halfway is."""
    lab = make_lab(captures=60, markers=1)
    seldom = np.arange(60) % 12 == 5
    lab.commanded[:, 0] = np.where(seldom, 58.0, np.minimum(lab.commanded[:, 0], 40.0))
    values = lab.predict(lab.u) + lab.noise()
    values[seldom] -= 9.0
    cleaned, _ = cleaned_of(lab, values)
    assert not np.isnan(cleaned).reshape(60, 3, 3)[seldom].any()
    halfway = int(np.argsort(lab.predict(lab.u)[:, 0, 2])[30])
    values[halfway] -= 9.0
    cleaned, _ = cleaned_of(lab, values)
    assert np.isnan(cleaned).reshape(60, 3, 3)[halfway].all()


def test_what_other_long_holds_say_is_believed(make_lab) -> None:
    """What is far off late in every long hold, and nowhere else, is no mistake of those rows."""
    lab = make_lab(captures=60, markers=1, long_s=LONG_S)
    values = lab.predict(lab.u) + lab.noise()
    late = np.isfinite(lab.hold_s) & (lab.hold_s >= 30.0)
    values[late] -= 9.0
    cleaned, _ = cleaned_of(lab, values)
    assert not np.isnan(cleaned)[lab.hold_s[np.isfinite(lab.hold_s)] >= 30.0].any()


@pytest.mark.parametrize("settings", [{"markers": 1}, {"markers": 12}, {"force": True, "chambers": 1}])
def test_what_comes_by_and_by_in_one_hold_stays(make_lab, settings: dict[str, Any]) -> None:
    """What sinks step by step along the only hold that is held is no mistake, though nothing else is ever so far off;
    what is off by as much from its first row on is one, and what comes so far at once, from one row to the next.
    """
    lab = make_lab(captures=60, long_s=(3.0, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0), **settings)
    values = lab.predict(lab.u) + lab.noise()
    held = np.flatnonzero(np.isfinite(lab.hold_s).sum(axis=1) > np.isfinite(lab.hold_s).sum(axis=1).min())
    rows = np.isfinite(lab.hold_s)
    sinks, jumps, late = held[1], held[-1], held[3]
    share = -np.expm1(-np.nan_to_num(lab.hold_s[sinks] - 3.0) / 100.0)
    values[sinks, :, 0] -= 9.0 * share
    values[jumps, :, 0] -= 9.0
    values[late, 4:, 0] -= 9.0
    cleaned, _ = cleaned_of(lab, values)
    gone = np.isnan(cleaned[:, 0])
    owner = np.repeat(np.arange(60), rows.sum(axis=1))
    assert not gone[owner == sinks].any()
    assert gone[owner == jumps].all()
    assert gone[owner == late][4:].all()


@pytest.mark.parametrize("settings", [{"markers": 12}, {"markers": 4}, {"force": True, "chambers": 1}])
def test_single_rows_inside_a_hold_go(make_lab, settings: dict[str, Any]) -> None:
    """A row that is off by little more than captures differ, but by much more than rows of its hold, is dropped."""
    lab = make_lab(captures=60, rows_s=(3.0, 3.5, 4.0, 4.5), **settings)
    values = lab.predict(lab.u) + lab.noise(row=0.05, capture=0.2)
    bad = [(5, 0, 0), (20, 2, -1), (41, 3, 0), (50, 1, -1)]
    for capture, row, k in bad:
        values[capture, row, k] += 1.0
    cleaned, dropped = cleaned_of(lab, values)
    gone = np.isnan(cleaned).reshape(60, 4, -1)
    assert all(gone[entry] for entry in bad)
    assert dropped <= 3 * 4 + 0.001 * gone.size


def test_what_changes_along_a_hold_stays(make_lab) -> None:
    """Neither what fades after a step, nor what escapes over a long hold, is a mistake of its first or last row."""
    lab = make_lab(
        captures=40, markers=6, rows_s=(1.0, 1.5, 2.0, 4.0), long_s=(1.0, 2.0, 5.0, 10.0, 30.0, 60.0)
    )
    lab.commanded[:, 2] = np.repeat(lab.commanded[::8, 2], 8)  # one chamber hardly ever moves
    before = np.concatenate([np.zeros((1, 3)), lab.commanded[:-1]])[:, None]
    t = lab.hold_s[:, :, None]
    u = (lab.u + (before - lab.u) * np.exp(-t / 0.5)) * np.exp(-t / 400.0)
    cleaned, dropped = cleaned_of(lab, lab.predict(u) + lab.noise())
    assert dropped <= 0.002 * cleaned.size


@pytest.mark.parametrize("rows_s", [(3.0,), (3.0, 3.5)])
def test_two_rows_cannot_tell_which_of_them_is_wrong(make_lab, rows_s: tuple[float, ...]) -> None:
    """In a hold of one row or two nothing is dropped for what its rows differ by."""
    lab = make_lab(captures=40, markers=6, rows_s=rows_s)
    values = lab.predict(lab.u) + lab.noise(row=0.02, capture=0.2)
    values[7, -1, 4] += 0.8
    assert cleaned_of(lab, values)[1] == 0


@pytest.mark.parametrize("seed", range(3))
def test_what_most_sensors_see_for_a_whole_capture_is_no_mistake(make_lab, seed: int) -> None:
    """A force and an angle that stop at once are a wall; of two that are far one alone, or for a row, is mistaken."""
    lab = make_lab(force=True, chambers=2, captures=40, seed=seed)
    first, second = (lab.predict(lab.u) + lab.noise() for _ in range(2))
    met = [6, 17, 31]
    for one in (first, second):
        one[met] -= 9.0
        one[24, 1] += 9.0
    first[12] += 9.0
    context = model_of_both(lab).context(rows_of(two_sensors(lab, first, second)))
    gone = np.isnan(clean(context)[0]).reshape(40, 3, 2)
    assert not gone[met].any()
    assert gone[24, 1].all()
    assert gone[12, :, 0].all()
    assert not gone[12, :, 1].any()


@pytest.mark.parametrize("markers", [6, 9])
def test_noise_of_a_few_markers_is_no_mistake(make_lab, markers: int) -> None:
    """Of twenty tables of noise alone nothing is left out; of one whose marker jumped once, that is."""
    for seed in range(20):
        lab = make_lab(chambers=3, markers=markers, captures=20, seed=seed)
        values = lab.predict(lab.u) + lab.noise(row=0.01, capture=0.1)
        assert prepared(rows_from(lab.dataset(values)), lab.model()).dropped == 0
    values[7, :, 3:6] += 1.5
    ready = prepared(rows_from(lab.dataset(values)), lab.model())
    gone = np.isnan(ready.residual).any(axis=1)
    assert set(ready.context.rows.capture[gone].tolist()) == {7}
    assert np.isnan(ready.residual[gone][:, 3:6]).all()
