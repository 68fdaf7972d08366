"""Planes that press on a body as a whole: what is pushed back pushes its chambers back, and all that these move."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.effects._context import Context
from labrig.effects._family import Space, acting, pressure
from labrig.effects._obstacles import LEVELS, NORMALS, Places, to_rows
from labrig.effects._plates import pushing

_CAPTURES, _BEST = 100, 2
"""On how many captures planes are looked for, and how many are asked about: numerical, they bound the time."""
_MET = 0.1
"""Share of the farthest way that a marker has to go towards a plane to meet it."""
_TURNS_RAD, _ROUNDS = (0.3, 0.15, 0.07), 4
"""By how much a plane is turned, and by what part of the way it is moved, to see whether it stands better so; and how
often at each of these."""


@dataclass(frozen=True)
class _Plane:
    """A plane across `normal` (3,), at `height` along it, and how far the way up to it is, `way`; in places' units."""

    normal: Floats
    height: float
    way: float

    def moved(self, turn: Floats, share: float) -> "_Plane":
        """Turned by a small vector (3,), and moved by a share of the way."""
        normal = self.normal + turn
        return replace(self, normal=normal / np.linalg.norm(normal), height=self.height + share * self.way)


def presses(context: Context) -> Iterator[Space]:
    """The planes that the residuals speak for most, if the body gives way as its chambers do; soft, and a bit aslant.

    With the pressures q and slopes J a push f of the plane on the markers is J' f on the chambers (virtual work; C.
    Lanczos, The Variational Principles of Mechanics, 4th ed., Dover 1986, ch. 3), so all markers go back by J J' f.
    """
    rows = context.rows
    if len(rows.chambers) < 2 or (rows.axis >= 0).sum() < 3 or not (rows.marker >= 0).any():
        return
    if float(context.travel.max()) <= 0:
        return
    search, push = _Search(context), pushing(context)
    for i, plane in enumerate(search.best()):
        features = [
            pressure(name, push(to_rows(context, -past[..., None] * plane.normal)), weight)
            for name, past, weight in _soft(plane, search.places)
        ]
        if np.any(features[0].values):
            key, scanned = f"pressed {i}", len(NORMALS) * len(LEVELS) * (2 * len(_TURNS_RAD) + 1)
            yield Space(key, "contact presses", acting(features), scanned=scanned, along=features[0])


def _soft(plane: _Plane, places: Places) -> Iterator[tuple[str, Floats, float]]:
    """How far markers go behind a plane (F, M), sooner and later, by Hertz' power, and by where they meet it."""
    for name, share, weight in (("back", 0.0, 1.0), ("sooner", -0.08, 0.3), ("later", 0.06, 0.3)):
        yield name, _past(plane.moved(np.zeros(3), share), places, slice(None)), weight
    past = _past(plane, places, slice(None))
    yield "soft", past**1.5 / np.sqrt(max(float(past.max()), 1e-12)), 0.3
    across = np.linalg.svd(plane.normal[None])[2][1:]
    for j, way in enumerate(across):
        beside = (places.here - places.here.mean(axis=(0, 1))) @ way
        yield f"uneven {j}", past * beside / max(float(np.abs(beside).max()), 1e-12), 0.3


def _past(plane: _Plane, places: Places, rows: slice | Ints) -> Floats:
    """How far markers that go towards a plane are behind it, (rows, M)."""
    met = places.move[rows] @ plane.normal > _MET * float(places.length.max())
    return np.where(met, np.maximum(places.here[rows] @ plane.normal - plane.height, 0.0), 0.0)


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

    def gain(self, plane: _Plane) -> float:
        """How much of the residuals it would take, in units of its own size."""
        past = _past(plane, self.places, self.rows)
        if not past.any():
            return 0.0
        change = to_rows(self.context, -past[..., None] * plane.normal)
        moved = (self.slopes @ (self.slopes.transpose(0, 2, 1) @ change[..., None]))[..., 0]
        size = float(np.sqrt((moved**2).sum()))
        return max(float((moved * self.left).sum()), 0.0) / size if size > 0 else 0.0

    def best(self) -> list[_Plane]:
        """The planes that explain most, each turned and moved to where it explains most."""
        found = []
        for normal in NORMALS:
            facing = self.places.facing(normal)
            if facing is None:
                continue
            way = facing.high - facing.low
            each = [_Plane(normal, facing.low + level * way, way) for level in LEVELS]
            gains = [self.gain(plane) for plane in each]
            found.append((max(gains), each[int(np.argmax(gains))]))
        found.sort(key=lambda one: -one[0])
        return [self._nearby(plane, gain) for gain, plane in found[:_BEST] if gain > 0]

    def _nearby(self, plane: _Plane, gain: float) -> _Plane:
        for step in _TURNS_RAD:
            for _ in range(_ROUNDS):
                across = np.linalg.svd(plane.normal[None])[2][1:]
                turns = [(sign * step * way, 0.0) for way in across for sign in (1.0, -1.0)]
                tried = [
                    plane.moved(*each) for each in (*turns, (np.zeros(3), step / 3), (np.zeros(3), -step / 3))
                ]
                gains = [self.gain(one) for one in tried]
                if max(gains) <= gain:
                    break
                gain, plane = max(gains), tried[int(np.argmax(gains))]
        return plane
