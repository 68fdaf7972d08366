"""Measurements in other units than the model, or of a rig that does not move: a person is asked, and only then."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig import LabrigError
from labrig.diagnosis import compare, diagnose, prepared
from labrig.diagnosis._pressures_off import pressures_off
from labrig.diagnosis._unnamed import unnamed
from labrig.effects import rows_of
from labrig.model import Model
from tests.conftest import Lab
from tests.naming import verdict_of


def said(lab: Lab, values: np.ndarray, noise: float = 1.0) -> list[str]:
    """The warnings of a comparison that are about units."""
    return said_of(compare(lab.dataset(values + noise * lab.noise()), lab.model()))


def said_of(result: Any) -> list[str]:
    """The same of one that was made."""
    return [line for line in result.summary["warnings"] if "units" in line]


@pytest.mark.parametrize(("scale", "words"), [(1e-3, "1/1000 as far"), (25.4, "25 times as far")])
def test_metres_for_millimetres(tmp_path: Path, scale: float, words: str) -> None:
    """What moves as the model says, but not as far, or farther, is said with how far, and what to check."""
    lab = Lab(tmp_path)
    (line,) = said(lab, scale * lab.predict(lab.u), scale)
    assert line == (
        f"what is measured in mm changes {words} as the model says: check the units of both and of the "
        "pressures, and whether these arrive"
    )


@pytest.mark.parametrize(("scale", "words"), [(np.pi / 180, "1/57 as far"), (10.0, "10 times as far")])
def test_one_file_in_another_unit(tmp_path: Path, scale: float, words: str) -> None:
    """Of three days one was read in radians, or as tenths: nothing is named, and the day is."""
    lab = Lab(tmp_path, sessions=3)
    values = lab.predict(lab.u) + lab.noise()
    values[lab.session == 1] *= scale
    run = lab.dataset(values)
    with pytest.raises(LabrigError) as caught:
        diagnose(run, lab.model())
    line = (
        f"in session s1 what is measured in mm changes {words} as the model says, and in others it does not: check the "
        "units of its file, of the pressures, too"
    )
    assert str(caught.value) == f"nothing can be diagnosed: {line}"
    assert line in compare(run, lab.model()).summary["warnings"]


def test_two_captures_say_nothing_of_their_unit(tmp_path: Path) -> None:
    """A day with two set-points side by side: that noise makes more of them than the model is no other unit."""
    lab = Lab(tmp_path, captures=42, force=True, sessions=3, repeats=False)
    lab.session[:] = np.repeat([0, 1, 2], [20, 2, 20])
    lab.commanded[20], lab.commanded[21] = 30.0, 30.05
    values = lab.predict(lab.u) + lab.noise()
    values[20], values[21] = lab.predict(lab.u)[20] - 0.5, lab.predict(lab.u)[21] + 0.5
    assert said_of(compare(lab.dataset(values), lab.model())) == []


def test_a_day_on_which_half_of_the_way_was_gone_is_physics(tmp_path: Path) -> None:
    """What another day does otherwise, as rigs do, is no unit."""
    lab = Lab(tmp_path, sessions=2, force=True)
    values = lab.predict(lab.u) * np.where(lab.session == 1, 0.5, 1.0)[:, None, None] + lab.noise()
    assert said_of(compare(lab.dataset(values), lab.model())) == []


@pytest.mark.parametrize(("factor", "words"), [(10.0, "1/10 as far"), (100.0, "1/100 as far")])
def test_an_angle_of_which_a_model_says_many_turns(tmp_path: Path, factor: float, words: str) -> None:
    """A bend of 80 degrees that the model says in tenths of a degree is no bend and two turns."""
    lab = Lab(tmp_path, force=True)
    run = lab.dataset(lab.predict(lab.u) + lab.noise()).assign_coords(unit=("observable", ["deg"]))
    with pytest.raises(LabrigError, match=f"what is measured in deg changes {words} as the model says"):
        diagnose(run, Model.of(lambda u: factor * lab.predict(u)))


def test_a_rig_that_stands_still(tmp_path: Path) -> None:
    """Where chambers stay empty, or cameras show one picture for ever, only noise is left, and it is said."""
    lab = Lab(tmp_path)
    (line,) = said(lab, np.broadcast_to(lab.rest, lab.predict(lab.u).shape))
    assert line.endswith("and whether these arrive")


def test_a_sensor_that_is_stuck(tmp_path: Path) -> None:
    """The only one of a rig that says one number for ever is asked about by name, and no reason to end."""
    lab = Lab(tmp_path, markers=0, chambers=1, force=True)
    stuck = lab.dataset(np.ones_like(lab.predict(lab.u)))
    (line,) = compare(stuck, Model.of(lambda u: 0.1 * u[:, :1])).summary["warnings"]
    assert line == "force never changes, where the model says that it does: are the sensors connected?"


@pytest.mark.parametrize("displaced", ["the model", "the measurement"])
def test_displacements_for_positions(tmp_path: Path, displaced: str) -> None:
    """Where one of both counts from each marker's rest, it is said which, and no question is asked of units."""
    lab = Lab(tmp_path)
    values = lab.predict(lab.u) + lab.noise()
    if displaced == "the model":
        lab.rest = np.zeros_like(lab.rest)
    else:
        values = values - lab.rest
    warnings = compare(lab.dataset(values), lab.model()).summary["warnings"]
    (line,) = [line for line in warnings if "displacements" in line]
    other = "the measurement" if displaced == "the model" else "the model"
    assert line.endswith(
        f"{displaced} seems to give displacements, {other} positions, where both must give the same"
    )
    assert not [line for line in warnings if "units" in line]


@pytest.mark.parametrize("change", ["nothing", "a third softer", "something else"])
def test_what_is_physics_is_not_asked_about(tmp_path: Path, change: str) -> None:
    """A rig that is off as rigs are, or that does not follow the model at all, is nothing of units."""
    lab = Lab(tmp_path)
    moved = lab.predict(lab.u)
    changes: dict[str, Any] = {
        "nothing": lambda: moved,
        "a third softer": lambda: lab.rest + 1.5 * (moved - lab.rest),
        "something else": lambda: lab.rest + 20 * np.random.default_rng(0).normal(size=moved.shape),
    }
    assert said(lab, changes[change]()) == []


@pytest.mark.parametrize("scale", [1e-3, 25.4])
def test_nothing_is_diagnosed_in_two_units(tmp_path: Path, scale: float) -> None:
    """What follows the model in another unit is no effect: the diagnosis ends with the question, in one line."""
    lab = Lab(tmp_path)
    with pytest.raises(LabrigError, match=r"^nothing can be diagnosed: what is measured in mm changes"):
        diagnose(lab.dataset(scale * (lab.predict(lab.u) + lab.noise())), lab.model())


def test_nothing_is_diagnosed_of_displacements(tmp_path: Path) -> None:
    """A model of displacements beside measured positions would need a frame, a rest shape or both: it is refused."""
    lab = Lab(tmp_path)
    data = lab.dataset(lab.predict(lab.u) + lab.noise())
    lab.rest = np.zeros_like(lab.rest)
    with pytest.raises(
        LabrigError, match=r"the model seems to give displacements, the measurement positions"
    ):
        diagnose(data, lab.model())


def test_markers_that_start_side_by_side(tmp_path: Path) -> None:
    """Of markers that lie closer together than they move, places tell nothing of what they were counted from."""
    lab = Lab(tmp_path, chambers=1, markers=4)
    away = 0.3 * np.random.default_rng(1).normal(size=lab.rest.shape)
    assert verdict_of(lab.dataset(lab.predict(lab.u) + away + lab.noise()), lab.model()).verdict


@pytest.mark.parametrize("displaced", ["the model", "the measurement"])
def test_markers_that_move_farther_than_they_lie_apart(tmp_path: Path, displaced: str) -> None:
    """On a body that bends far, too, displacements are no positions."""
    lab = Lab(tmp_path, markers=8)
    lab.rest_mm = 0.1 * lab.rest_mm
    lab.rest = lab.rest_mm.reshape(lab.rest.shape)
    far = np.ptp(lab.predict(lab.u), axis=(0, 1)).max()
    assert far > np.ptp(lab.rest)  # the farthest moves farther than the body is long
    values = lab.predict(lab.u) + lab.noise()
    if displaced == "the model":
        lab.rest = np.zeros_like(lab.rest)
    else:
        values = values - lab.rest
    with pytest.raises(LabrigError, match=f"{displaced} seems to give displacements"):
        diagnose(lab.dataset(values), lab.model())


@pytest.mark.parametrize("step", ["Search.run", "gone", "answers_of"])
def test_numbers_too_far_apart_end_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    """Where a matrix is lost to rounding (from which size on, computers differ), a diagnosis says what to check."""

    def lost(*_: Any) -> Any:
        raise np.linalg.LinAlgError("Matrix is not positive definite")

    monkeypatch.setattr(f"labrig.diagnosis._diagnose.{step}", lost)
    lab = Lab(tmp_path)
    with pytest.raises(LabrigError) as caught:
        diagnose(lab.dataset(lab.predict(1.2 * lab.u) + lab.noise()), lab.model())
    assert str(caught.value).startswith("what is measured and what the model says are too far apart in size")
    assert str(caught.value).endswith("times the noise): check the units of both")


def test_a_chamber_that_moves_one_place_only(tmp_path: Path) -> None:
    """Of a single place that moves nothing can be said of where the chamber acts, and nothing divides by zero."""
    lab = Lab(tmp_path)
    lab.reach[:, 1:] = 0.0
    lab.reach[3:, 0] = 0.0
    context = lab.model().context(rows_of(lab.dataset(lab.predict(lab.u))))
    assert "lever" not in {space.spectrum for space in unnamed(context)}


@pytest.mark.parametrize(
    ("moves", "chambers"), [("far", 2), ("not at all", 2), ("hardly", 3), ("hardly", 2), ("hardly", 1)]
)
def test_a_constant_error_of_displacements_is_no_place_at_rest(
    tmp_path: Path, moves: str, chambers: int
) -> None:
    """Where model and measurement both count from rest, a shape that is off by some floors is asked about, not refused:
    also where the rig is held at one set-point all the time, or hardly moves.
    """
    lab = Lab(tmp_path, chambers=chambers, captures=40)
    lab.rest = np.zeros_like(lab.rest)
    if moves == "not at all":
        lab.commanded[:] = 0.5 * lab.commanded.max()
    elif moves == "hardly":
        lab.commanded *= 0.02
    wrong = np.random.default_rng(3).normal(size=lab.rest.shape)
    floors = (8 if moves == "far" else 2.5) * lab.noise().std() / wrong.std()
    found = verdict_of(lab.dataset(lab.predict(lab.u) + floors * wrong + lab.noise()), lab.model())
    assert found.verdict != "nothing_missing"


@pytest.mark.parametrize(("times", "words"), [(10.0, "1/10"), (0.1450377, "6.895 times")])
def test_pressures_in_another_unit_than_the_model_takes(tmp_path: Path, times: float, words: str) -> None:
    """A model that saturates moves by no more than twice as far with pressures ten times as large: it is not what
    moves too far that is asked about, but the pressures, and nothing is named.
    """
    lab = Lab(tmp_path)
    run = lab.dataset(lab.predict(lab.u) + lab.noise())
    run["commanded"] = run["commanded"] * times
    if "measured" in run:
        run["measured"] = run["measured"] * times
    with pytest.raises(LabrigError) as caught:
        diagnose(run, lab.model())
    assert f"if each pressure is taken {words}: check in which unit the model takes pressures" in str(
        caught.value
    )


def test_a_model_that_errs_by_all_it_moves_is_asked_once(tmp_path: Path) -> None:
    """A model that is wrong for another reason than its pressures' unit is said to be nothing of the kind."""
    lab = Lab(tmp_path)
    turned = lab.predict(lab.u[:, :, ::-1])
    assert not any("which unit" in line for line in said(lab, turned))


def test_a_simulator_is_not_asked_for_other_pressures(tmp_path: Path) -> None:
    """Its pressures are in kPa, and no shape of it is sought at a thousand times what a rig bears."""
    lab = Lab(tmp_path)
    run = lab.dataset(10 * lab.predict(lab.u))
    asked: list[np.ndarray] = []
    context = prepared(rows_of(run), lab.model()).context
    told = replace(context, elsewhere=lambda u: asked.append(u) or lab.predict(u))
    assert not list(pressures_off(replace(told, base_kind="simulator")))
    assert asked == []
    assert not list(pressures_off(told))
    assert len(asked) > 5
