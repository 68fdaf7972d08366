"""A plane that markers run against: where it stands by the residuals, and by how much it stops them."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.effects._context import Context
from labrig.effects._effect import Term
from labrig.effects._fields import centre_of
from labrig.effects._obstacles import NORMALS, Places, beside_markers, by_marker, to_rows

NORMAL = ("normal_x", "normal_y", "normal_z")
"""The parameters of a plane's direction, a vector of length 1."""
TURNS_RAD = (0.3, 0.15, 0.07)
"""By how much a plane that was found is turned, to see whether it stands better so: half-way to the next, and less."""


@dataclass(frozen=True)
class Plane:
    """A plane across `normal` (3,), of length 1, `distance_mm` along it from the middle of the markers at rest."""

    normal: Floats
    distance_mm: float

    @property
    def shape(self) -> dict[str, float]:
        """Its parameters by name."""
        each = zip(NORMAL, self.normal.tolist(), strict=True)
        return {**dict(each), "distance": self.distance_mm}


def planes(
    context: Context, looked_for: Callable[[Context], list[Plane]] | None = None
) -> Iterator[tuple[Plane, Floats]]:
    """Planes, and how far each marker would go behind them as a change against it (F, K): that of a saved effect, else
    those that the residuals speak for most, if each marker is stopped by itself, or those that are `looked_for`. None
    where nobody knows the places of the markers at rest.
    """
    rest = context.rows.rest_mm
    if rest is None or not np.isfinite(rest).all() or not (context.rows.axis >= 0).any():
        return
    saved = [context.pinned[name] for name in NORMAL if name in context.pinned]
    if len(saved) == 3:
        found = [Plane(np.array(saved), context.pinned.get("distance", 0.0))]
    elif context.pinned or context.saved:  # another form is asked for
        return
    else:
        found = (looked_for or _found)(context)
    for plane in found:
        back = -_behind(context, plane)[..., None] * plane.normal
        yield plane, to_rows(context, back)


def felt_beside(context: Context, plane: Plane, back: Floats) -> Term | None:
    """What few sensors beside the markers have of them going behind a plane, each in its own measure; `back` (F, K) as
    from `planes`. None where there are no such sensors.
    """
    which = beside_markers(context.rows)
    if not len(which):
        return None
    depth_mm = -(by_marker(context, back) @ plane.normal).sum(axis=1)
    names = tuple(context.rows.observables[k] for k in which.argmax(axis=1))
    return Term.field("felt", depth_mm[:, None, None] * which.T, names)


def _behind(context: Context, plane: Plane, rows: Ints | slice = slice(None)) -> Floats:
    """How far each marker goes behind a plane (rows, M); one that is behind it at rest, how far from there."""
    assert context.rows.rest_mm is not None
    start = (context.rows.rest_mm - centre_of(context)) @ plane.normal
    height = start + by_marker(context, context.displacement[rows]) @ plane.normal
    return np.maximum(height - np.maximum(plane.distance_mm, start), 0.0)


def _found(context: Context) -> list[Plane]:
    """The planes that the residuals of the captures speak for most, each turned and moved to where it explains most."""
    if float(context.travel.max()) <= 0:
        return []
    places = Places(context)
    centre = centre_of(context)

    def gain(plane: Plane) -> float:
        past = _behind(context, plane, places.first)
        against = -(places.left @ plane.normal)
        size = float(np.sqrt((past**2).sum()))
        return max(float((past * against).sum()), 0.0) / size if size > 0 else 0.0

    out = []
    for i, facing, level in places.best_planes():
        way = facing.high - facing.low
        plane = Plane(NORMALS[i], facing.low + level * way - float(centre @ NORMALS[i]))
        for turn in TURNS_RAD:
            plane = max([plane, *near(plane, turn, way * turn / 2)], key=gain)
        if gain(plane) > 0:
            out.append(plane)
    return out


def near(plane: Plane, turn_rad: float, step_mm: float) -> Iterator[Plane]:
    """The same plane turned to eight sides or not, nearer, farther or neither."""
    one, two = np.linalg.svd(plane.normal[None])[2][1:]
    angles = np.arange(8) * np.pi / 4
    ways = [np.zeros(3), *(np.cos(a) * one + np.sin(a) * two for a in angles)]
    for way in ways:
        normal = plane.normal + np.tan(turn_rad) * np.where(np.abs(way) < 1e-9, 0.0, way)
        for step in (-step_mm, 0.0, step_mm):
            yield Plane(normal / np.linalg.norm(normal), plane.distance_mm + step)
