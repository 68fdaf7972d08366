"""Where the names of markers and of chambers stand on a surface in space, so that a person can read them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.view._fields import Skin
from labrig.view._outlines import Outline
from labrig.view._space import camera_axes, front

_PROUD = 0.008  # of the surface's size, by which markers and lines stand out of it
_ABOVE = 5  # how many times as far names do
_LETTER, _TALL = (
    0.025,
    0.055,
)  # of that size, half the room that a letter of a name takes, and a name's height
_FROM = 0.06  # the middle of a name from what it names: above a marker, below the middle of a chamber
_AWAY = np.arange(0.0, 0.21, 0.02)  # how far from its middle the name of a chamber is looked for a place
_WAYS = np.linspace(0, 2 * np.pi, 16, endpoint=False)


@dataclass(frozen=True)
class NamePlaces:
    """How far the names of M markers and of C chambers are drawn off these, mm, (M, 3) and (C, 3); and which of them
    lie beside the surface on the screen, as a picture begins.
    """

    of_markers: Floats
    of_chambers: Floats
    markers_beside: NDArray[np.bool_]
    chambers_beside: NDArray[np.bool_]


def proud(places_mm: Floats) -> Floats:
    """How far (3,) markers and lines are drawn off the skin, mm, so that it does not hide them."""
    return _PROUD * float(np.ptp(places_mm, axis=0).max()) * front(places_mm)


def name_places(
    names: Sequence[str], rest_mm: Floats, skin: Skin | None, outlines: Sequence[Outline]
) -> NamePlaces:
    """Where names stand of markers at rest (M, 3), and of the chambers with these outlines.

    A name is flat to who looks at it, and the skin is not: where it rises within the name's own room, the name comes
    towards the camera by as much, which does not move it on the screen. The name of a chamber goes aside where a
    marker has its own.
    """
    off = _ABOVE * proud(rest_mm)
    middles = np.array([o.middle for o in outlines]).reshape(-1, len(rest_mm)) @ rest_mm
    count, every = len(names), np.concatenate([rest_mm, middles]) + off
    moved = np.zeros((len(every), 3))
    if skin is None:
        nowhere = np.zeros(len(every), dtype=bool)
        return NamePlaces(off + moved[:count], off + moved[count:], nowhere[:count], nowhere[count:])
    size, axes = float(np.ptp(rest_mm, axis=0).max()), np.stack(camera_axes(rest_mm))
    seen, shown = skin.vertices(rest_mm) @ axes.T / size, every @ axes.T / size
    room = np.array([_LETTER * len(name) for name in [*names, *(o.name for o in outlines)]])
    below = np.zeros((len(every), 2))
    below[:, 1] = [_FROM] * count + [-_FROM] * len(outlines)
    for n in range(count, len(every)):
        shown[n, :2] += _aside(n, shown[:, :2] + below, room, seen[:, :2], skin.triangles)
    beside = np.zeros(len(every), dtype=bool)
    for n, at in enumerate(shown):
        centre = at[:2] + below[n]
        within = (np.abs(seen[:, :2] - centre) <= [room[n], _FROM]).all(axis=1)
        at[2] += max(seen[within, 2].max(initial=-np.inf) + _PROUD - at[2], 0.0)
        beside[n] = not _covered(centre, seen[:, :2], skin.triangles)
    moved = size * shown @ axes - every + off
    return NamePlaces(moved[:count], moved[count:], beside[:count], beside[count:])


def _aside(n: int, at: Floats, room: Floats, seen: Floats, triangles: NDArray[np.int64]) -> Floats:
    """The shortest way (2,) for the middle of name `n` to where it covers no name before it, and is on the skin yet."""
    apart = np.stack([room[:n] + room[n], np.full(n, _TALL)], axis=1)
    for way in (_AWAY[:, None, None] * np.stack([np.cos(_WAYS), np.sin(_WAYS)], axis=1)).reshape(-1, 2):
        free = (np.abs(at[:n] - at[n] - way) >= apart).any(axis=1).all()
        if free and _covered(at[n] + way, seen, triangles):
            return way
    return np.zeros(2)


def _covered(point: Floats, seen: Floats, triangles: NDArray[np.int64]) -> bool:
    """Whether a point (2,) of the screen lies on one of the triangles (T, 3) of what is seen there, (V, 2)."""
    corner = seen[triangles] - point
    turn = [_cross(corner[:, k], corner[:, (k + 1) % 3]) for k in range(3)]
    return bool((np.all([t >= 0 for t in turn], axis=0) | np.all([t <= 0 for t in turn], axis=0)).any())


def _cross(a: Floats, b: Floats) -> Floats:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
