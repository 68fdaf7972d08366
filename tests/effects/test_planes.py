"""A plane in space: found by what it stops, with where it stands and which way it faces in the model's own units."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from labrig._errors import LabrigError
from labrig.diagnosis import diagnose
from labrig.effects import rows_of
from labrig.effects._planes import Plane, planes
from labrig.effects._presses import pressing
from labrig.effects._registry import shipped
from labrig.model import EffectEntry, Value
from labrig.model._model import find_variant
from tests.conftest import HIGH_KPA
from tests.effects.test_family import context_of

NORMAL = np.array([0.6, 0.0, 0.8])
FROM_MIDDLE_MM = 22.0


ROUND_MM = 500.0


def behind_glass(lab: Any) -> np.ndarray:
    """Markers push against a large ball, nearly flat, that gives way softly: they keep a root of how deep they are."""
    where, middle = lab.predict(lab.u), lab.rest_mm.mean(axis=0) + (FROM_MIDDLE_MM + ROUND_MM) * NORMAL
    points = where.reshape(*where.shape[:-1], -1, 3)
    away = points - middle
    far = np.linalg.norm(away, axis=-1, keepdims=True)
    deep = np.maximum(ROUND_MM - far, 0.0)
    assert (np.linalg.norm(lab.rest_mm - middle, axis=-1) > ROUND_MM).all()
    return (points + (deep - 0.6 * np.sqrt(deep)) * (deep > 0.36) * away / far).reshape(where.shape)


@pytest.fixture
def lab(make_lab) -> Any:
    """Ten markers on three chambers, of which a part reaches the plate."""
    return make_lab(markers=10, captures=60)


def test_where_it_stands(lab, few_effects) -> None:
    """A plate that a campaign ran against is named as contact with a plane, its direction to 5 degrees, its distance
    to 1 mm, and most of the error on another programme is gone with it.
    """
    few_effects("contact", "tension", "stiffening", "coupling", "regulator", "frame", "gravity")
    result = diagnose(lab.dataset(behind_glass(lab) + lab.noise()), lab.model())
    assert [*result.summary["effects"], *result.summary["rivals"]] == ["contact"]
    assert result.improved is not None
    (entry,) = result.improved.file.effects
    value = {name: float(np.asarray(own.value)) for name, own in entry.parameters.items()}
    assert entry.form == "plane"
    normal = np.array([value[f"normal_{a}"] for a in "xyz"])
    assert np.degrees(np.arccos(normal @ NORMAL)) < 5
    assert value["distance"] == pytest.approx(FROM_MIDDLE_MM, abs=1)
    assert value["stopped"] == pytest.approx(0.8, abs=0.1)
    assert entry.parameters["distance"].unit == "mm"
    assert entry.fitted_on is not None
    assert entry.fitted_on.centre_mm == pytest.approx(lab.rest_mm.mean(axis=0))
    fresh = replace(lab, seed=7)
    rows = rows_of(fresh.dataset(behind_glass(fresh)))
    before, after = (
        np.sqrt(np.mean((model.context(rows).base - rows.values) ** 2))
        for model in (lab.model(), result.improved)
    )
    assert after < 0.1 * before


def test_a_plate_that_is_not_reached_changes_nothing(lab) -> None:
    """What stands farther away than any marker goes is no error; what markers are behind at rest holds them there."""
    context = context_of(lab)
    for distance, moved in ((1000.0, False), (-1000.0, True)):
        ((_, back),) = planes(context.pin(Plane(NORMAL, distance).shape))
        assert bool(back.any()) is moved
    points = context.displacement.reshape(len(back), -1, 3) @ NORMAL
    assert back.reshape(len(back), -1, 3) @ NORMAL == pytest.approx(-np.maximum(points, 0.0))


def test_where_nobody_knows_the_places_at_rest(lab) -> None:
    """No plane is looked for, and a model that has one says what is lacking."""
    context = context_of(lab)
    unknown = replace(context, rows=replace(context.rows, rest_mm=None))
    assert not list(planes(unknown))
    values = {"stopped": Value(value=1.0)} | {k: Value(value=v) for k, v in Plane(NORMAL, 14.0).shape.items()}
    entry = EffectEntry(name="contact", form="plane", parameters=values)
    with pytest.raises(LabrigError, match="the places of the markers at rest"):
        find_variant(unknown, shipped()["contact"], entry)


def under_glass(lab: Any, kpa_mm: float = 0.3) -> np.ndarray:
    """Bubbles that blow against a plate, each a whole: what presses a marker down presses down all that its bubbles
    move, until their pressure is in balance with the plate's (Hertz: a force by the way to 3/2).
    """
    up = (
        lab.reach.reshape(-1, 3, lab.chambers).transpose(0, 2, 1) @ NORMAL / HIGH_KPA
    )  # mm/kPa of each marker
    taken = np.zeros_like(lab.u)
    start = (lab.rest_mm - lab.rest_mm.mean(axis=0)) @ NORMAL
    for _ in range(200):  # damped: a stiff plate
        moved = (lab.predict(lab.u - taken) - lab.rest).reshape(*lab.u.shape[:-1], -1, 3) @ NORMAL
        force = np.maximum(start + moved - FROM_MIDDLE_MM, 0.0) ** 1.5
        taken += 0.05 * (kpa_mm * force @ up - taken)
    return lab.predict(lab.u - taken)


def test_a_body_gives_way_as_a_whole(make_lab) -> None:
    """Where a plate presses on a body whose walls bend in wide bulges, markers beside those that meet it are pressed
    down, too: it is contact, by what the plate does to the chambers, and no coupling between these.
    """
    lab = make_lab(markers=12, captures=60, chambers=4)
    result = diagnose(lab.dataset(under_glass(lab) + lab.noise()), lab.model())
    assert [*result.summary["effects"], *result.summary["rivals"]][:1] == ["contact"]
    assert (
        next(c for c in result.summary["effects_considered"] if c["effect"] == "coupling")["call"] == "not it"
    )
    (own,) = [each for each in result.summary["ranking"] if each["effect"] == "contact"]
    assert own["form"] == "plane, chambers"
    assert own["parameters"]["push"]["unit"] == "kPa**2/mm**2"
    fresh = replace(lab, seed=7)
    rows = rows_of(fresh.dataset(under_glass(fresh)))
    assert result.improved is not None
    before, after = (
        np.sqrt(np.mean((model.context(rows).base - rows.values) ** 2))
        for model in (lab.model(), result.improved)
    )
    assert after < 0.3 * before


def test_where_a_body_as_a_whole_is_pressed(make_lab) -> None:
    """The plane that presses is found by what it does through the chambers, to 8 degrees and 2 mm; as one that stops
    each marker by itself it would be taken for one that stands far nearer.
    """
    lab = make_lab(markers=12, captures=60, chambers=4)
    context = context_of(lab, under_glass(lab) + lab.noise())

    def near(plane: Plane) -> bool:
        turned = np.degrees(np.arccos(plane.normal @ NORMAL))
        return bool(turned < 8 and abs(plane.distance_mm - FROM_MIDDLE_MM) < 2)

    assert any(near(plane) for plane in pressing(context))
    assert not any(near(plane) for plane, _ in planes(context))


def heights(lab: Any, values: np.ndarray) -> Any:
    """A campaign of heights (n, T, K), mm, of which nobody said where they are."""
    names = [f"h{k}" for k in range(values.shape[2])]
    data = lab.dataset(values[..., :1])
    values = np.where(np.isfinite(data["observed"].values), values, np.nan)
    none = [""] * len(names)
    of = {"observable": names} | dict.fromkeys(("marker_of", "axis_of"), ("observable", none))
    of["unit"] = ("observable", ["mm"] * len(names))
    data = data.drop_vars(["observed", "observable", "unit", "marker_of", "axis_of"])
    return data.assign(observed=(("capture", "time", "observable"), values)).assign_coords(of)


def test_many_heights_under_a_plate(make_lab) -> None:
    """Heights of bubbles that share a plate are contact, too, though nothing says where each of them is."""
    lab = make_lab(force=True, chambers=4)
    at = np.linspace(0, 3, 12)
    lab.reach = 20.0 * np.exp(-(((at[:, None] - np.arange(4)) / 0.7) ** 2))
    lab.rest, taken = np.zeros(12), np.zeros_like(lab.u)
    for _ in range(200):
        force = np.maximum(lab.predict(lab.u - taken) - 17.0, 0.0) ** 1.5
        taken += 0.05 * (0.3 * force @ lab.reach / HIGH_KPA - taken)
    result = diagnose(heights(lab, lab.predict(lab.u - taken) + lab.noise()), lab.model())
    assert [*result.summary["effects"], *result.summary["rivals"]][:1] == ["contact"]
    assert (
        next(c for c in result.summary["effects_considered"] if c["effect"] == "coupling")["call"] == "not it"
    )
