"""A base that is wrong in form in few numbers: what else is there keeps its name, and no name goes with the base."""

from typing import Any

import numpy as np

from labrig.diagnosis._motions import motions
from labrig.effects import by_marker, to_rows
from tests.effects.test_family import context_of, followed
from tests.naming import calls_of, verdict_of


def gone(lab: Any) -> np.ndarray:
    """How far the base says that each marker has gone, (n, T, M, 3)."""
    return (lab.predict(lab.u) - lab.rest).reshape(*lab.hold_s.shape, -1, 3)


def another_way(lab: Any) -> np.ndarray:
    """All markers go 8 degrees beside the way of the base, turned exactly (Rodrigues), each by as much as it goes."""
    axis, turn = np.array([0.6, 0.0, 0.8]), np.deg2rad(8.0)
    way = gone(lab)
    along = (way @ axis)[..., None] * axis
    return along + np.cos(turn) * (way - along) + np.sin(turn) * np.cross(axis, way) - way


def test_what_else_is_there_keeps_its_name(make_lab) -> None:
    """Beside a base whose motions go another way a loop (Bouc-Wen) is the only name; the rest is the base's."""
    lab = make_lab(chambers=2, captures=60)
    values = lab.predict(lab.looped(4.0)) + another_way(lab).reshape(*lab.hold_s.shape, -1)
    found = verdict_of(lab.dataset(values + lab.noise()), lab.model())
    assert (*found.effects, *found.rivals) == ("hysteresis",)
    assert found.carried_by == "how the base itself moves"


def test_what_chambers_have_of_each_other_may_be_the_base_s(make_lab) -> None:
    """Of a base whose chambers lack what each gets of the next one coupling is not sure, nor is anything else, beside a
    loop (Bouc-Wen), which is possible at least.
    """
    lab = make_lab(chambers=2, captures=80, markers=8)
    got = 0.15 * np.tanh(1.3 * np.roll(lab.u, 1, axis=2) / lab.u.max()) * lab.u.max()
    values = lab.predict(lab.looped(4.0)) + lab.predict(lab.u + got) - lab.predict(lab.u)
    calls = calls_of(lab.dataset(values + lab.noise()), lab.model())
    assert calls.pop("hysteresis") != "not it"
    assert "sure" not in calls.values()


def test_markers_that_sit_elsewhere_have_the_motion_of_places_beside(make_lab) -> None:
    """Markers in a row that sit 5 mm further along it than the base has them move as lines between them say."""
    lab = make_lab(captures=40, markers=12)
    context = context_of(lab, lab.predict(lab.u))
    at, way = lab.rest_mm[:, 0], by_marker(context, context.displacement)
    order = np.argsort(at)
    there = np.stack(
        [[np.interp(at + 5.0, at[order], row[order]) for row in axis] for axis in np.moveaxis(way, 2, 0)],
        axis=2,
    )
    (space,) = (s for s in motions(context) if s.key == "how all moves")
    assert followed(context, space, to_rows(context, there - way)) > 0.8
