"""Markers that have each other's names in some captures: left out there, and named."""

import numpy as np
import pytest

from labrig import LabrigError
from labrig.diagnosis import diagnose, prepared, rows_from
from labrig.diagnosis._swapped import _exchanged
from tests.laws import power_law, strut
from tests.naming import verdict_of


def renamed(values: np.ndarray, captures: list[int], names: dict[int, int]) -> np.ndarray:
    """What is seen (n, T, K) where in these captures marker a has the name of b, for each a -> b."""
    out = values.copy().reshape(*values.shape[:2], -1, 3)
    there = out[captures].copy()
    for a, b in names.items():
        out[np.ix_(captures, range(out.shape[1]), [b])] = there[:, :, [a]]
    return out.reshape(values.shape)


def lost(lab, values: np.ndarray) -> tuple[dict[int, list[int]], tuple[str, ...]]:
    """The captures in which each marker was left out, by marker, and what is said."""
    context = prepared(rows_from(lab.dataset(values)), lab.model()).context
    rows = context.rows
    gone = {
        int(m): np.unique(rows.capture[np.isnan(rows.values[:, rows.marker == m]).any(axis=1)]).tolist()
        for m in np.unique(rows.marker)
    }
    return {m: captures for m, captures in gone.items() if captures}, rows.warnings


def test_two_markers_that_are_exchanged_are_left_out(make_lab) -> None:
    """In three captures two of twelve have each other's names: they are left out there, the others stay."""
    lab = make_lab(captures=30, markers=12)
    values = renamed(lab.predict(power_law(lab)) + lab.noise(), [4, 9, 20], {2: 7, 7: 2})
    gone, said = lost(lab, values)
    assert gone == {2: [4, 9, 20], 7: [4, 9, 20]}
    assert said == (
        "m2 and m7 have each other's names in 3 captures (4, 9, 20): left out there; label them again",
    )


def test_three_markers_may_go_round(make_lab) -> None:
    """Each has the name of the next."""
    lab = make_lab(captures=30, markers=12)
    gone, said = lost(lab, renamed(lab.predict(lab.u) + lab.noise(), [5], {1: 4, 4: 8, 8: 1}))
    assert gone == {1: [5], 4: [5], 8: [5]}
    assert said[0].startswith("m1, m4 and m8 have each other's names in 1 capture (5): ")


def test_names_that_are_always_wrong(make_lab) -> None:
    """Where two markers are exchanged from the first capture to the last, they are left out of all of them."""
    lab = make_lab(captures=30, markers=12)
    gone, said = lost(lab, renamed(lab.predict(lab.u) + lab.noise(), list(range(30)), {0: 6, 6: 0}))
    assert gone == {0: list(range(30)), 6: list(range(30))}
    assert said[0].startswith("m0 and m6 have each other's names in 30 captures (0, 1, 2, 3, ...): ")


def test_nothing_is_named_where_markers_have_others_names_nearly_always(make_lab) -> None:
    """Such names are those of the mapping or of the model, no slip of the cameras: they come before any effect."""
    lab = make_lab(captures=30, markers=12)
    values = renamed(lab.predict(power_law(lab)) + lab.noise(), list(range(20)), {0: 6, 6: 0})
    with pytest.raises(LabrigError) as caught:
        diagnose(lab.dataset(values), lab.model())
    assert str(caught.value) == (
        "nothing can be diagnosed: m0 and m6 have each other's names in 20 captures (0, 1, 2, 3, ...): let the mapping "
        "and the model name them alike"
    )


def test_names_that_are_all_wrong_leave_nothing_to_compare(make_lab) -> None:
    """Where every marker has another's name in every capture, that is said, and what to do."""
    lab = make_lab(captures=12, markers=12)
    back = {m: 11 - m for m in range(12)}
    values = renamed(lab.predict(lab.u) + lab.noise(), list(range(12)), back)
    with pytest.raises(LabrigError) as caught:
        diagnose(lab.dataset(values), lab.model())
    assert str(caught.value).startswith(
        "nothing is left of the run that could be compared: m0, m1, m2, m3 and "
    )
    assert str(caught.value).endswith("left out there; label them again")


@pytest.mark.parametrize("law", [None, power_law, strut])
def test_nobody_is_exchanged_by_noise_or_an_effect(make_lab, law) -> None:
    """Markers that are off, by little or by a fifth of what they move, keep their names; so do those close together."""
    lab = make_lab(captures=40, markers=12, reach_mm=60.0)
    lab.rest_mm[3] = lab.rest_mm[2] + 0.2
    lab.rest = lab.rest_mm.ravel()
    assert lost(lab, lab.predict(law(lab) if law else lab.u) + lab.noise()) == ({}, ())


def test_one_marker_that_is_elsewhere_is_not_exchanged(make_lab) -> None:
    """It is where another is expected, but that one is there, too: a reflection, for the cleaning to find."""
    lab = make_lab(captures=40, markers=12)
    values = (lab.predict(lab.u) + lab.noise()).reshape(40, -1, 12, 3)
    values[7, :, 2] = values[7, :, 9] + 0.1
    assert lost(lab, values.reshape(40, -1, 36)) == ({}, ())


def test_an_effect_beside_exchanged_markers_has_its_name(make_lab) -> None:
    """A tenth of the captures with exchanged markers, others each time, hide no creep."""
    lab = make_lab(chambers=2, captures=60, markers=12)
    values = lab.predict(power_law(lab)) + lab.noise()
    random = np.random.default_rng(50)
    for i in random.choice(60, 6, replace=False).tolist():
        a, b = random.choice(12, 2, replace=False).tolist()
        values = renamed(values, [i], {a: b, b: a})
    _, said = lost(lab, values)
    assert [line for line in said if "and others have each other's names in 6 captures" in line]
    assert verdict_of(lab.dataset(values), lab.model()).effects == ("creep",)


@pytest.mark.parametrize(("usual_mm", "found"), [(0.05, True), (1.0, False)])
def test_places_must_be_farther_apart_than_markers_are_off(usual_mm: float, found: bool) -> None:
    """Two markers 2 mm apart, exchanged in one row: told where they are off by little, not where by as much, too."""
    expected = np.tile(np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [50.0, 0.0, 0.0]]), (20, 1, 1))
    measured = expected + usual_mm * np.array([0.0, 1.0, 0.0])
    measured[7, :2] = expected[7, 1::-1]
    wanted = np.zeros((20, 3), dtype=bool)
    wanted[7, :2] = found
    assert (_exchanged(measured, expected)[0] == wanted).all()


def test_a_lost_marker_whose_name_another_took(make_lab) -> None:
    """Where m4 is out of sight in some captures and m5 goes by its name, m4 is left out there: that is m5's place."""
    lab = make_lab(captures=30, markers=12)
    values = lab.predict(lab.u) + lab.noise()
    values = renamed(values, [3, 8, 21], {5: 4})
    values.reshape(30, -1, 12, 3)[[3, 8, 21], :, 5] = np.nan
    gone, said = lost(lab, values)
    assert gone == {4: [3, 8, 21], 5: [3, 8, 21]}
    assert said == ("m4 has another's name in 3 captures (3, 8, 21): left out there; label them again",)


def test_names_that_moved_up_by_one(make_lab) -> None:
    """One marker was never seen, and all behind it have the name of the one before: none of those is what it says."""
    lab = make_lab(captures=30, markers=12)
    values = lab.predict(lab.u) + lab.noise()
    values = renamed(values, list(range(30)), {m + 1: m for m in range(7, 11)})
    values.reshape(30, -1, 12, 3)[:, :, 11] = np.nan
    gone, said = lost(lab, values)
    assert set(gone) == {7, 8, 9, 10, 11}
    assert said[0].startswith("m11 was never seen, in 30 captures: ")
    assert said[1].startswith(
        "m7, m8, m9 and m10 have the names of others in 30 captures (0, 1, 2, 3, ...): "
    )


def test_a_frame_that_moved_by_the_distance_of_two_markers(make_lab) -> None:
    """Each marker is where the next is expected, but the last is where none is: all keep their names."""
    lab = make_lab(captures=30, markers=6)
    lab.rest_mm[:] = 10.0 * np.arange(6)[:, None] * np.array([1.0, 0.0, 0.0])
    lab.rest = lab.rest_mm.ravel()
    values = (lab.predict(lab.u) + lab.noise()).reshape(30, -1, 6, 3) + np.array([10.0, 0.0, 0.0])
    assert lost(lab, values.reshape(30, -1, 18)) == ({}, ())


def test_markers_are_told_by_their_neighbours_where_the_model_is_far_off(make_lab) -> None:
    """Creep of a third of the way to the next marker, seen by all, hides no marker that has another's name."""
    lab = make_lab(captures=60, markers=12, chambers=3, seed=51)
    creeping = lab.predict(power_law(lab))
    assert np.abs(creeping - lab.predict(lab.u)).max() > np.linalg.norm(lab.rest_mm[4] - lab.rest_mm[5]) / 3
    values = creeping + lab.noise()
    taken = renamed(values, list(range(2, 60, 5)), {5: 4})
    taken.reshape(60, -1, 12, 3)[2::5, :, 5] = np.nan
    assert lost(lab, taken)[0] == {4: list(range(2, 60, 5)), 5: list(range(2, 60, 5))}
    assert lost(lab, values) == ({}, ())
