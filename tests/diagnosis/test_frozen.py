"""Markers that stand still to the last digit: their tracker repeats what it saw last, so they are left out there."""

import numpy as np
import pytest

from labrig.diagnosis import prepared, rows_from
from labrig.effects import Rows
from tests.laws import power_law
from tests.naming import verdict_of


def cleaned(lab, values: np.ndarray) -> Rows:
    """The rows that a diagnosis works on."""
    return prepared(rows_from(lab.dataset(values)), lab.model()).context.rows


def places(lab, values: np.ndarray) -> np.ndarray:
    """What is seen (n, T, K), by marker."""
    return values.reshape(*lab.hold_s.shape, -1, 3)


def left_out(lab, rows: Rows) -> dict[int, list[int]]:
    """The captures in which each marker was left out, by marker."""
    each = rows.values.reshape(-1, lab.markers, 3)
    gone = {m: np.unique(rows.capture[np.isnan(each[:, m]).all(axis=1)]).tolist() for m in range(lab.markers)}
    return {m: captures for m, captures in gone.items() if captures}


def test_a_marker_that_was_lost_for_good(make_lab) -> None:
    """From a capture on its place is repeated: what was seen first stays, all repetitions are left out."""
    lab = make_lab(markers=12)
    values = lab.predict(lab.u) + lab.noise()
    places(lab, values)[25:, :, 3] = places(lab, values)[25, 0, 3]
    rows = cleaned(lab, values)
    assert left_out(lab, rows) == {3: list(range(25, 60))}
    assert rows.warnings == (
        "m3 stands still to the last digit in 35 captures (25, 26, 27, 28, ...), as where a tracker repeats what it "
        "saw last: left out there",
    )


def test_a_marker_that_was_lost_for_good_and_was_seldom_seen_before(make_lab) -> None:
    """What the cameras did not see is no place that stayed as it was: of places in steps, too, repetitions go."""
    lab = make_lab(markers=12, rows_s=tuple(np.linspace(3.0, 4.0, 12)), long_s=())
    values = np.round(lab.predict(lab.u) + lab.noise(row=0.5), 1)
    places(lab, values)[np.arange(60) % 5 > 1, :, 3] = np.nan
    places(lab, values)[55:, :, 3] = places(lab, values)[55, 0, 3]
    rows = cleaned(lab, values)
    assert rows.warnings[-1].startswith(
        "m3 stands still to the last digit in 5 captures (55, 56, 57, 58, ...)"
    )


def test_a_marker_that_was_never_seen_to_move(make_lab) -> None:
    """One that has the same place in all rows is left out though a map was fitted to it, and it is said; one that
    trembles on the ground stays.
    """
    lab = make_lab(markers=4)
    lab.reach[:6] = 0.0
    values = np.round(lab.predict(lab.u) + lab.noise(), 2)  # what trembles comes again and again
    places(lab, values)[:, :, 1] = lab.rest_mm[1]
    rows = cleaned(lab, values)
    assert left_out(lab, rows) == {1: list(range(60))}
    (line,) = rows.warnings
    assert line.startswith("m1 stands still to the last digit in 60 captures")


def test_an_effect_beside_a_frozen_marker_has_its_name(make_lab) -> None:
    """A marker whose last place is repeated in single captures is no slip, and hides no creep."""
    lab = make_lab(chambers=2, markers=8, seed=41)
    values = lab.predict(power_law(lab)) + lab.noise()
    for i in range(10, 60, 5):
        places(lab, values)[i, :, 3] = places(lab, values)[i - 1, 0, 3]
    assert verdict_of(lab.dataset(values), lab.model()).effects == ("creep",)


@pytest.mark.parametrize("step_mm", [0.0, 0.02, 0.5])
def test_steps_are_not_taken_for_standing_still(make_lab, step_mm: float) -> None:
    """Coordinates that are recorded in steps, however coarse, are alike now and then in every marker."""
    lab = make_lab(markers=12)
    values = lab.predict(lab.u) + lab.noise()
    values = np.round(values / step_mm) * step_mm if step_mm else values
    assert cleaned(lab, values).warnings == ()


def test_what_has_no_noise_stands_still(make_lab) -> None:
    """Of a simulation without noise, whose rows of one hold are alike, nothing is left out."""
    lab = make_lab(markers=12)
    values = lab.predict(1.1 * lab.u)
    assert cleaned(lab, values).warnings == ()
    values[:, :, 9:30] = np.nan  # nor where most are out of sight
    (line,) = cleaned(lab, values).warnings
    assert line.startswith("m3, m4, m5, m6 and 3 more were never seen, in 60 captures: ")


def test_a_finger_that_rests_stands_still(make_lab) -> None:
    """Of a simulation without noise, of three fingers that move one after the other: what rests is not repeated."""
    lab = make_lab(markers=12, captures=64)
    lab.commanded[:] = 20.0 * np.stack(np.unravel_index(np.arange(64), (4, 4, 4)), axis=1)
    lab.reach[:] = np.where(np.arange(36)[:, None] // 12 == np.arange(3), lab.reach, 0.0)
    lab.hold_s[:, 1:] = np.nan
    assert not [line for line in cleaned(lab, lab.predict(lab.u)).warnings if "stands still" in line]


def test_a_marker_on_the_ground_may_stand_still(make_lab) -> None:
    """One that the model hardly moves, recorded in steps, is alike for long, and stays."""
    lab = make_lab(markers=12)
    lab.reach[:3] *= 1e-3
    values = lab.predict(lab.u) + lab.noise()
    places(lab, values)[:, :, 0] = np.round(lab.rest_mm[0]) + 0.5 * (np.arange(60) // 20 % 2)[:, None, None]
    rows = cleaned(lab, values)
    assert left_out(lab, rows) == {}
    assert not [line for line in rows.warnings if "stands still" in line]
