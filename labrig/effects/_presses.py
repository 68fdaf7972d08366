"""Planes that press on a body as a whole: what is pushed back pushes its chambers back, and all that these move."""

from collections.abc import Iterator

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.effects._context import Context
from labrig.effects._family import Space, acting, pressure
from labrig.effects._fields import centre_of
from labrig.effects._obstacles import LEVELS, NORMALS, Places, to_rows
from labrig.effects._planes import TURNS_RAD, Plane, near
from labrig.effects._plates import pushing

_CAPTURES, _BEST = 100, 2
"""On how many captures planes are looked for, and how many are asked about: numerical, they bound the time."""
_MET = 0.1
"""Share of the farthest way that a marker has to go towards a plane to meet it."""


def presses(context: Context) -> Iterator[Space]:
    """The planes that the residuals speak for most, if the body gives way as its chambers do; soft, and a bit aslant.

    With the pressures q and slopes J a push f of the plane on the markers is J' f on the chambers (virtual work; C.
    Lanczos, The Variational Principles of Mechanics, 4th ed., Dover 1986, ch. 3), so all markers go back by J J' f.
    """
    if not _may_press(context):
        return
    search, push = _Search(context), pushing(context)
    for i, (plane, way) in enumerate(search.best()):
        features = [
            pressure(name, push(to_rows(context, -past[..., None] * plane.normal)), weight)
            for name, past, weight in _soft(plane, way, search.places)
        ]
        if np.any(features[0].values):
            key, scanned = f"pressed {i}", len(NORMALS) * len(LEVELS) * (2 * len(TURNS_RAD) + 1)
            yield Space(key, "contact presses", acting(features), scanned=scanned, along=features[0])


def pressing(context: Context) -> list[Plane]:
    """The same planes, from the middle of the markers at rest."""
    centre = centre_of(context)
    found = _Search(context).best() if _may_press(context) else []
    return [Plane(plane.normal, plane.distance_mm - float(centre @ plane.normal)) for plane, _ in found]


def _may_press(context: Context) -> bool:
    """Whether there are markers that move, and several chambers to push back: of one all markers do as it does."""
    rows = context.rows
    several = len(rows.chambers) > 1 and (rows.axis >= 0).sum() >= 3 and bool((rows.marker >= 0).any())
    return several and float(context.travel.max()) > 0


def _soft(plane: Plane, way: float, places: Places) -> Iterator[tuple[str, Floats, float]]:
    """How far markers go behind a plane (F, M), sooner and later by a share of the `way` to it, by Hertz' power, and by
    where they meet it.
    """
    for name, share, weight in (("back", 0.0, 1.0), ("sooner", -0.08, 0.3), ("later", 0.06, 0.3)):
        yield name, _past(Plane(plane.normal, plane.distance_mm + share * way), places, slice(None)), weight
    past = _past(plane, places, slice(None))
    yield "soft", past**1.5 / np.sqrt(max(float(past.max()), 1e-12)), 0.3
    for j, across in enumerate(np.linalg.svd(plane.normal[None])[2][1:]):
        beside = (places.here - places.here.mean(axis=(0, 1))) @ across
        yield f"uneven {j}", past * beside / max(float(np.abs(beside).max()), 1e-12), 0.3


def _past(plane: Plane, places: Places, rows: slice | Ints) -> Floats:
    """How far markers that go towards a plane, so far from the origin of `places`, are behind it, (rows, M)."""
    met = places.move[rows] @ plane.normal > _MET * float(places.length.max())
    return np.where(met, np.maximum(places.here[rows] @ plane.normal - plane.distance_mm, 0.0), 0.0)


class _Search:
    """Looks for planes by what of the residuals they would explain through the chambers."""

    def __init__(self, context: Context) -> None:
        self.context, self.places = context, Places(context)
        # in an order of their pressures: the same, whatever came first
        order = np.lexsort(context.rows.actuation[self.places.first].T)
        some = order[:: max(1, len(order) // _CAPTURES)]
        self.rows = self.places.first[some]
        self.slopes = context.jacobian[self.rows] * context.span
        self.left = to_rows(context, self.places.left[some])

    def gain(self, plane: Plane) -> float:
        """How much of the residuals it would take, in units of its own size."""
        past = _past(plane, self.places, self.rows)
        if not past.any():
            return 0.0
        change = to_rows(self.context, -past[..., None] * plane.normal)
        moved = (self.slopes @ (self.slopes.transpose(0, 2, 1) @ change[..., None]))[..., 0]
        size = float(np.sqrt((moved**2).sum()))
        return max(float((moved * self.left).sum()), 0.0) / size if size > 0 else 0.0

    def best(self) -> list[tuple[Plane, float]]:
        """The planes that explain most, each turned and moved to where it explains most, with the way up to it."""
        found = []
        for normal in NORMALS:
            facing = self.places.facing(normal)
            if facing is None:
                continue
            way = facing.high - facing.low
            plane = max((Plane(normal, facing.low + level * way) for level in LEVELS), key=self.gain)
            found.append((self.gain(plane), plane, way))
        found.sort(key=lambda one: -one[0])
        return [(self._nearby(plane, way), way) for gain, plane, way in found[:_BEST] if gain > 0]

    def _nearby(self, plane: Plane, way: float) -> Plane:
        for turn in TURNS_RAD:
            plane = max([plane, *near(plane, turn, way * turn / 2)], key=self.gain)
        return plane
