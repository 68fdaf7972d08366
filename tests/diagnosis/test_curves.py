"""Beside a polynomial that was fitted to the run no curve of the set-points is surely an effect."""

import numpy as np
import pytest

from labrig.diagnosis import prepared, rows_from
from labrig.diagnosis._curves import curves, family_of, in_any_order
from labrig.diagnosis._diagnose import CUT_OFF
from labrig.effects import Context
from labrig.model import Model
from tests.laws import power_law, strut
from tests.naming import calls_of, verdict_of
from tests.polynomials import fitted

OF_SET_POINTS = {"regulator", "stiffening", "tension", "contact", "coupling"}
OF_MORE = {"creep", "leak", "delay", "hysteresis", "friction", "drift"}


def context_of(lab, values: np.ndarray, degree: int) -> Context:
    """A campaign beside a polynomial of so high a degree."""
    return prepared(rows_from(lab.dataset(values)), fitted(lab, degree)).context


def named_twice(lab, context: Context) -> set[str]:
    """Which effects have spaces that the map may lack as well."""
    effects = lab.model().library()
    named = family_of(effects, context)
    found = curves(named, effects, context)
    return {name for name, space in named if any(space is own for own in found)}


def test_what_a_cut_off_series_lacks_is_a_curve_of_the_set_points(make_lab) -> None:
    """Walls, sensors and obstacles go by the set-point alone; what remembers, or goes on in a hold, does not."""
    lab = make_lab(markers=12, captures=80, rows_s=(1.0, 3.0, 8.0), seed=1)
    both = named_twice(lab, context_of(lab, lab.predict(power_law(lab)) + lab.noise(), 2))
    assert both >= OF_SET_POINTS
    assert not both & OF_MORE


def test_what_is_found_on_a_run_is_found_in_any_order(make_lab) -> None:
    """Ends of motions, and places where something stands, are chosen on the run, and alike whatever came first.

    More than 100 captures, of which only some are looked at.
    """
    lab = make_lab(markers=12, captures=230, seed=3)
    context = context_of(lab, lab.predict(strut(lab)) + lab.noise(), 2)
    effects = lab.model().library()
    named = family_of({"contact": effects["contact"]}, context)
    found = [space.key for space in curves(named, {"contact": effects["contact"]}, context)]
    chosen = [space.key for _, space in named if space.key.startswith(("end of motion", "pushes"))]
    assert len(chosen) == 3
    assert set(chosen) <= set(found)


def test_a_straight_line_is_a_law(make_lab) -> None:
    """What is not proportional has a name: of a map of the first degree, as of a base of one's own, none is shared."""
    lab = make_lab()
    values = lab.predict(lab.u) + lab.noise()
    assert not named_twice(lab, context_of(lab, values, 1))
    assert not named_twice(lab, prepared(rows_from(lab.dataset(values)), lab.model()).context)


def test_another_order_has_the_same_captures(make_lab) -> None:
    """Each row comes back to its place with its own set-point, from rest and in a session of its own."""
    lab = make_lab(sessions=2)
    context = context_of(lab, lab.predict(lab.u) + lab.noise(), 2)
    alone, back = in_any_order(context)
    assert (alone.rows.actuation[back] == context.rows.actuation).all()
    assert (alone.rows.values[back] == context.rows.values).all()
    assert (alone.rows.event_actuation[alone.rows.event] == alone.rows.actuation).all()
    assert alone.event_deflection[alone.rows.event] == pytest.approx(alone.deflection)
    assert not alone.previous.any()
    assert (np.bincount(alone.rows.session) == 3).all()
    first = context.rows.capture[np.argsort(back)][::3]
    assert (first != np.arange(lab.captures)).mean() > 0.9


def test_no_curve_is_sure_beside_a_parabola(make_lab) -> None:
    """A rig that saturates beside an obstacle: a parabola lacks the next term, so no name is sure."""
    lab = make_lab(chambers=2, markers=8)
    found = verdict_of(lab.dataset(lab.predict(strut(lab)) + lab.noise()), fitted(lab, 2))
    assert (found.verdict, found.effects) == ("confounded", ())
    assert found.beside[CUT_OFF] > 0.1


def test_what_remembers_is_sure_beside_a_parabola(make_lab) -> None:
    """Creep is no curve of the set-points, whatever the map lacks."""
    lab = make_lab(chambers=2, captures=45)
    calls = calls_of(lab.dataset(lab.predict(power_law(lab)) + lab.noise()), fitted(lab, 2))
    assert [name for name, call in calls.items() if call == "sure"] == ["creep"]


def test_no_session_of_its_own_is_asked_of_each_capture(make_lab) -> None:
    """Each capture in a session of its own makes no motion of the frame for each: there would be no room for them."""
    lab = make_lab(markers=12)
    context = context_of(lab, lab.predict(lab.u) + lab.noise(), 2)
    alone, _ = in_any_order(context)
    effects = lab.model().library()
    most, own = (max(len(space.features) for _, space in family_of(effects, one)) for one in (alone, context))
    assert most <= own


@pytest.mark.parametrize("how", ["python", "table"])
def test_a_map_that_was_learnt_errs_by_any_curve(make_lab, how: str) -> None:
    """Where a person says that a function, or a table, was learnt, no curve of the set-points is surely an effect."""
    lab = make_lab(markers=12, captures=80, rows_s=(1.0, 3.0, 8.0), seed=1)
    rows = rows_from(lab.dataset(lab.predict(power_law(lab)) + lab.noise()))
    table = np.column_stack([lab.commanded, lab.predict(lab.commanded)])
    names = ",".join([*rows.chambers, *rows.observables])
    np.savetxt(lab.folder / "known.csv", table, delimiter=",", header=names, comments="")
    lab.model()
    path = lab.folder / "learnt.yaml"
    file = {"python": "base.py", "table": "known.csv"}[how]
    path.write_text(f"base: {{kind: {how}, file: {file}, learned: true}}\n")
    both = named_twice(lab, prepared(rows, Model.load(path)).context)
    assert both >= OF_SET_POINTS
    assert not both & OF_MORE


def learned(lab, **more) -> Context:
    """A campaign with a strut beside the lab's own map, which is said to be learnt."""
    model = lab.model()
    path = lab.folder / "model.yaml"
    said = ", ".join(f"{name}: {value}" for name, value in more.items())
    path.write_text(path.read_text().replace("function: predict", f"function: predict, {said}"))
    return prepared(
        rows_from(lab.dataset(lab.predict(strut(lab)) + lab.noise())), type(model).load(path)
    ).context


@pytest.mark.parametrize(
    ("said", "shared"),
    [
        ({"learned": "true"}, True),
        ({"learned": "true", "heldout_error": 0.05}, False),
        ({"heldout_error": 0.05}, False),
        ({"heldout_error": 50.0}, True),
        ({"learned": "false", "heldout_error": 50.0}, False),
    ],
)
def test_how_exact_a_map_is_may_be_said(make_lab, said: dict[str, object], shared: bool) -> None:
    """What is much larger than the error of a map on what it was not learned from is no curve that it lacks."""
    lab = make_lab()
    assert bool(named_twice(lab, learned(lab, **said))) is shared
