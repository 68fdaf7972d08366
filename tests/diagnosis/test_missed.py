"""Single set-points that a chamber missed: said with their captures, and effects beside them keep their names."""

import numpy as np
import pytest

from labrig.diagnosis import diagnose, prepared, rows_from, versus
from labrig.diagnosis._missed import MISSED, missing
from labrig.model import Model
from tests.laws import bowed, limited, orifice, power_law, sliding, strut
from tests.naming import verdict_of
from tests.polynomials import fitted

LATE = [9, 23, 38, 51]


def seen(lab, law=None, vented: tuple[int, ...] = (), stayed: tuple[int, ...] = ()) -> np.ndarray:
    """What is measured where the first chamber is vented, or stays where it was, in these captures."""
    u = lab.u if law is None else law(lab)
    u[list(vented), :, 0] = 0.0
    for i in stayed:
        u[i, :, 0] = lab.commanded[i - 1, 0]
    return lab.predict(u) + lab.noise()


def found(lab, values: np.ndarray) -> tuple[list[int], set[int], bool] | None:
    """Captures, chambers, and whether they stayed where they were."""
    rows = rows_from(lab.dataset(values))
    out = missing(lab.model().predictor(rows).context(rows))
    return None if out is None else (out.capture.tolist(), set(out.chamber.tolist()), out.still)


@pytest.mark.parametrize("law", [None, power_law, sliding, orifice, bowed, limited, strut])
def test_a_chamber_that_stayed_empty_is_found(make_lab, law) -> None:
    """Beside whatever else is missing, the captures and the chamber are these."""
    lab = make_lab(markers=12, seed=41)
    lab.commanded[LATE, 0] = [30.0, 50.0, 45.0, 58.0]
    assert found(lab, seen(lab, law, vented=(*LATE,))) == (LATE, {0}, False)


@pytest.mark.parametrize("law", [None, power_law, orifice])
def test_a_chamber_that_stayed_where_it_was_is_found(make_lab, law) -> None:
    """A valve that did not switch: it has the pressure of before, and the next set-point again."""
    lab = make_lab(markers=12, seed=41)
    for i, (before, now) in zip(LATE, [(50.0, 10.0), (5.0, 40.0), (55.0, 20.0), (10.0, 55.0)], strict=True):
        lab.commanded[i - 1, 0], lab.commanded[i, 0] = before, now
    assert found(lab, seen(lab, law, stayed=(*LATE,))) == (LATE, {0}, True)


@pytest.mark.parametrize("law", [None, power_law, sliding, orifice, bowed, limited, strut])
def test_no_set_point_was_missed_where_none_was(make_lab, law) -> None:
    """No effect is taken for a chamber that does not follow."""
    for seed in range(5):
        lab = make_lab(markers=12, seed=seed)
        assert found(lab, seen(lab, law)) is None


def test_more_than_single_ones_are_an_effect(make_lab) -> None:
    """Where every fifth set-point is missed, or four in a row, nothing is said of single ones."""
    lab = make_lab(markers=12)
    lab.commanded[:, 0] = np.maximum(lab.commanded[:, 0], 30.0)
    assert found(lab, seen(lab, vented=(*range(0, 60, 5),))) is None
    assert found(lab, seen(lab, vented=(30, 31, 32, 33))) is None
    assert found(lab, seen(lab, vented=(30, 31))) == ([30, 31], {0}, False)


def test_the_cause_is_said_with_its_captures(make_lab) -> None:
    """With nothing else missing the verdict is unknown, in words that send somebody to the valve."""
    lab = make_lab(chambers=2, markers=8, seed=41)
    lab.commanded[LATE, 0] = [30.0, 50.0, 45.0, 58.0]
    summary = diagnose(lab.dataset(seen(lab, vented=(*LATE,))), lab.model()).summary
    assert (summary["verdict"], summary["carried_by"]) == ("unknown", MISSED)
    assert (
        "c1 was as good as vented in 4 captures (9, 23, 38, 51), whatever it was told: left out; look at its valve "
        "and its hose, and measure again"
    ) in summary["warnings"]


def test_an_effect_beside_it_has_its_name(make_lab) -> None:
    """Four captures that are ten times as far off as the rest do not hide what all captures have."""
    lab = make_lab(chambers=2, markers=8, seed=41)
    lab.commanded[LATE, 0] = [30.0, 50.0, 45.0, 58.0]
    found = verdict_of(lab.dataset(seen(lab, orifice, vented=(*LATE,))), lab.model())
    assert (found.verdict, found.effects) == ("identified", ("leak",))


def stairs(lab, times: int = 3) -> None:
    """Each chamber goes up and down by tenths of its range, one after the other."""
    levels = np.concatenate([np.arange(0, 61, 6), np.arange(54, 0, -6)]).astype(float)
    lab.commanded[:] = 0.0
    for i in range(min(times * len(levels), lab.captures)):
        lab.commanded[i, (i // len(levels)) % lab.chambers] = levels[i % len(levels)]


def test_what_is_so_at_all_of_the_lowest_pressures_is_a_law(make_lab) -> None:
    """A valve that cracks open at 8 kPa leaves the chamber empty below: at each of these set-points, so none is missed.

    So it is at the highest ones, where a supply gives no more.
    """
    for seed in range(4):
        lab = make_lab(markers=12, seed=seed)
        u = lab.u
        u[..., 0] = np.where(u[..., 0] < 8.0, 0.0, u[..., 0])
        assert found(lab, lab.predict(u) + lab.noise()) is None
    stairs(lab)
    u = lab.u
    for low, high in ((8.0, 60.0), (0.0, 55.0)):
        some = np.where((u < low) | (u > high), 0.0, u)
        assert found(lab, lab.predict(some) + lab.noise()) is None


def test_what_is_usual_makes_up_no_missed_set_point(make_lab) -> None:
    """Beside a dead zone of a step of the stairs, where every chamber is vented, nothing is off: nothing was missed."""
    lab = make_lab(markers=12)
    stairs(lab)
    u = lab.u
    u[..., 0] = np.maximum(u[..., 0] - 6.0, 0.0)
    assert found(lab, lab.predict(u) + lab.noise()) is None


def test_one_marker_that_is_off_says_nothing_of_a_chamber(make_lab) -> None:
    """Where each chamber moves a marker of its own, a marker that is as if its chamber were vented may be mistaken."""
    lab = make_lab(markers=12)
    lab.reach[:] = np.where(np.arange(36)[:, None] // 3 == 4 * np.arange(3), 20.0, 0.0)
    lab.commanded[LATE, 0] = [30.0, 50.0, 45.0, 58.0]
    assert found(lab, seen(lab, vented=(*LATE,))) is None


def test_markers_that_were_never_seen_hide_nothing(make_lab) -> None:
    """Two of twelve markers out of sight all the time: the captures are found all the same."""
    lab = make_lab(markers=12, seed=41)
    lab.commanded[LATE, 0] = [30.0, 50.0, 45.0, 58.0]
    values = seen(lab, vented=(*LATE,))
    values[:, :, 9:15] = np.nan
    assert found(lab, values) == (LATE, {0}, False)


def test_two_models_are_compared_over_the_same_captures(make_lab) -> None:
    """A model that knows the rig finds missed set-points, another does not: neither counts them."""
    lab = make_lab(markers=12, seed=41)
    lab.commanded[LATE, 0] = [30.0, 50.0, 45.0, 58.0]
    data = lab.dataset(seen(lab, vented=(*LATE,)))
    result = versus(data, lab.model(), fitted(lab, 1))
    assert result.summary["better"] == "model"
    assert sum(line.startswith("c1 was as good as vented") for line in result.summary["warnings"]) <= 1


def test_a_base_that_does_not_move_misses_nothing(make_lab) -> None:
    """Without slopes nobody can say what a chamber should do."""
    lab = make_lab(markers=12, seed=41)
    values = lab.predict(lab.u) + lab.noise()
    (lab.folder / "still.py").write_text(
        "import numpy as np\n\n\ndef predict(u):\n    return np.zeros((len(u), 36)) + np.arange(36)\n"
    )
    (lab.folder / "still.yaml").write_text("base: {kind: python, file: still.py, function: predict}\n")
    rows = prepared(rows_from(lab.dataset(values)), Model.load(lab.folder / "still.yaml")).context.rows
    assert rows.n_captures == len(np.unique(rows.capture)) == 60
