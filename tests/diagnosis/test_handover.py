"""Markers that other cameras take over: no effect of the library, and said to come from a place in space."""

from typing import Any

import numpy as np

from labrig.diagnosis._handover import handovers
from labrig.effects import rows_of
from tests.naming import verdict_of


def seen_by_two(lab: Any) -> np.ndarray:
    """What is nearer to a camera above than 485 mm is seen by it alone, which was turned by 2 mrad and moved."""
    where = lab.predict(lab.u)
    points = where.reshape(*where.shape[:-1], -1, 3)
    camera = lab.rest_mm.mean(axis=0) + np.array([40.0, 0.0, 500.0])
    away = points - camera
    own = np.linalg.norm(away, axis=-1, keepdims=True) < 485.0
    assert 0.1 < own.mean() < 0.6
    elsewhere = np.cross([0.002, -0.001, 0.001], away) + np.array([0.3, -0.2, 0.5])
    return (points + own * elsewhere).reshape(where.shape)


def test_other_cameras_have_no_name(make_lab) -> None:
    """A step of all markers that pass a border in space is unknown, not a frame, and what carries it is said."""
    lab = make_lab(chambers=2, markers=10, captures=60)
    found = verdict_of(lab.dataset(seen_by_two(lab) + lab.noise()), lab.model())
    assert (found.verdict, found.effects) == ("unknown", ())
    assert found.carried_by == "a plane in space"


def test_what_differs_on_two_sides_is_no_plane_unless_it_is_crossed(make_lab) -> None:
    """Two halves of a body that were glued together askew, by an arctangent, are a shape: no marker passes the seam."""
    lab = make_lab(chambers=2, markers=12, captures=60)
    beside = lab.rest_mm[:, 0] - lab.rest_mm[:, 0].mean()
    off = np.arctan(beside / 2.0)[:, None] * [0.3, -0.2, 0.5]
    where = lab.predict(lab.u) + (1 - 0.002 * lab.u.mean(axis=-1, keepdims=True)) * off.ravel()
    planes = []
    for values in (where, seen_by_two(lab)):
        rows = rows_of(lab.dataset(values + lab.noise()))
        planes.append(len(list(handovers(lab.model().context(rows)))))
    assert planes == [0, 3]
