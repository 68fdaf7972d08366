"""Where a surface may meet something: limits in space, found by a scan of the residuals where there are many."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats, Ints
from labrig.effects._context import FEW_OBSERVABLES, Context
from labrig.effects._end_stops import end_stops
from labrig.effects._family import Feature, Space, acting, field, motion_scale, one_way
from labrig.effects._rows import Rows

LEVELS = (0.3, 0.45, 0.6, 0.75, 0.85, 0.92)
"""Shares of the way at which planes are looked for."""
_BEST = 3
_NEIGHBOURS = 9
_AS_FAR = 1e-6
"""Share of the farthest travel by which heights must differ for a plane to stand between them; numerical."""
_SHALLOW = 0.2
"""Sine of the angle between way and plane below which a marker is taken to slide along it, not to meet it."""


def _normals() -> Floats:
    """Directions (42, 3) spread evenly over the sphere: the corners of a twice divided icosahedron."""
    golden = (1 + np.sqrt(5)) / 2
    corners = [np.roll([0.0, s, t * golden], j) for j in range(3) for s in (1, -1) for t in (1, -1)]
    points = np.array(corners) / np.sqrt(1 + golden**2)
    middles = [a + b for i, a in enumerate(points) for b in points[:i] if a @ b > 0.4]
    out = np.array([*points, *middles])
    return out / np.linalg.norm(out, axis=1, keepdims=True)


NORMALS = _normals()
"""The directions (42, 3) in which planes are looked for."""


def obstacles(context: Context) -> Iterator[Space]:
    """Ends of the body's main motions; of the markers' travel; planes and posts in the way of markers."""
    if float(context.travel.max()) <= 0:
        return
    yield from end_stops(context)
    rows = context.rows
    if (rows.axis >= 0).sum() < 3 or not (rows.marker >= 0).any():
        return
    places = Places(context)
    far = float(context.yardstick("farthest travel", context.travel.max))
    for share in (0.3, 0.5, 0.7, 0.85):
        past = np.maximum(places.length - share * far, 0)
        stop = field("stop", to_rows(context, -past[..., None] * places.way))
        yield one_way(Space(f"travel {share}", "contact travel", acting([stop])))
    yield from places.cages()
    yield from places.planes()
    yield from places.posts()


@dataclass(frozen=True)
class _Facing:
    """Markers that go one way: which (F, M), how far they are along it (F, M), from the lowest to the highest, mm."""

    met: NDArray[np.bool_]
    height: Floats
    low: float
    high: float

    def past(self, level: float, rows: Ints | slice = slice(None)) -> Floats:
        """How far they go behind a plane at this share of the way, (rows, M)."""
        plane = self.low + level * (self.high - self.low)
        return np.where(self.met[rows], np.maximum(self.height[rows] - plane, 0.0), 0.0)


class Places:
    """Markers' predicted ways, and what of the residual stands against them, by capture."""

    def __init__(self, context: Context) -> None:
        self.context = context
        rows = context.rows
        self.move = by_marker(context, context.displacement)
        self.length = np.linalg.norm(self.move, axis=2)
        self.way = self.move / np.maximum(self.length, 1e-9)[..., None]
        rest = rows.rest_mm
        self.here = self.move + (rest[None] if rest is not None and np.isfinite(rest).all() else 0.0)
        self.first = rows.first
        count = np.bincount(np.searchsorted(rows.capture[rows.first], rows.capture))
        sums = np.add.reduceat(by_marker(context, np.nan_to_num(context.residual)), self.first, axis=0)
        self.left = sums / count[:, None, None]

    def facing(self, normal: Floats) -> _Facing | None:
        """What lies before planes across `normal`; None where hardly any marker goes that way, or all as far."""
        height = self.here @ normal
        met = self.move @ normal > 0.1 * float(self.length.max())
        if met.mean() < 0.01:
            return None
        low, high = np.percentile(height[met], (5, 100))
        if high - low < _AS_FAR * self.length.max():
            return None
        return _Facing(met, height, float(low), float(high))

    def best_planes(self) -> list[tuple[int, _Facing, float]]:
        """The planes that the residuals speak for most: number of the normal, what lies before it, level of the way."""
        found = []
        for i, normal in enumerate(NORMALS):
            if (facing := self.facing(normal)) is None:
                continue
            against = -(self.left @ normal)
            for level in LEVELS:
                past = facing.past(level, self.first)
                if past.max() > 0:
                    gain = max(float((past * against).sum()), 0.0) / np.sqrt((past**2).sum())
                    found.append((gain, i, level, facing))
        chosen: dict[int, tuple[int, _Facing, float]] = {}
        for _, i, level, facing in sorted(found, key=lambda one: one[:3], reverse=True):
            if i not in chosen and len(chosen) < _BEST:
                chosen[i] = (i, facing, level)
        return list(chosen.values())

    def planes(self) -> Iterator[Space]:
        """The planes that the residuals speak for most, with what is near them: soft, tilted, nearer, held fast."""
        for i, facing, level in self.best_planes():
            features = acting(self._plane(NORMALS[i], facing, level))
            key, places = f"plane {i} {level}", len(NORMALS) * len(LEVELS)
            yield Space(key, "contact plane", features, scanned=places, along=features[0])
            if felt := self._felt(facing.past(level)):
                own = (*features[:3], *felt)
                yield Space(f"{key}, felt", "contact plane, felt", own, scanned=places, along=features[0])

    def _felt(self, past: Floats) -> tuple[Feature, ...]:
        """What few sensors beside the markers have of them going behind a plane by `past` (F, M), each in its measure:
        the force at a tip that presses on a wall.
        """
        depth, scale = past.sum(axis=1), motion_scale(self.context)
        return tuple(
            field(f"felt by {n}", depth[:, None] / max(float(depth.max()), 1e-12) * own * scale)
            for n, own in enumerate(beside_markers(self.context.rows))
        )

    def _plane(self, normal: Floats, facing: _Facing, level: float) -> list[Feature]:
        context = self.context
        out = []
        for name, at, weight in (
            ("back", level, 1.0),
            ("sooner", level - 0.1, 0.3),
            ("later", level + 0.07, 0.3),
        ):
            out.append(field(name, to_rows(context, -facing.past(at)[..., None] * normal), weight))
        past = facing.past(level)
        climb = self.way @ normal
        slip = self.way - climb[..., None] * normal
        stuck = np.where(climb > _SHALLOW, past / np.maximum(climb, _SHALLOW), 0.0)
        out.append(field("held fast", to_rows(context, -stuck[..., None] * slip), 0.3))
        met = (past > 0) * past.max()
        out.append(field("nearer", to_rows(context, -met[..., None] * normal), 0.1))
        across = np.linalg.svd(normal[None])[2][1:]
        beside = np.stack([(self.here - self.here.mean(axis=(0, 1))) @ t for t in across], axis=2)
        beside /= np.abs(beside).max() + 1e-12
        for j in (0, 1):
            out.append(
                field(f"tilted {j}", to_rows(context, -(met * beside[:, :, j])[..., None] * normal), 0.2)
            )
            turned = -(past * beside[:, :, j])[..., None] * normal
            out.append(field(f"uneven {j}", to_rows(context, turned), 0.3))
        return out

    def cages(self) -> Iterator[Space]:
        """A ball or a tube around the middle of the markers at rest, which they do not leave."""
        away = self.here - (self.here - self.move).mean(axis=(0, 1))
        for share in (0.5, 0.7, 0.85, 0.95):
            out = []
            for name, shape in (
                ("ball", np.ones(3)),
                *((f"tube {'xyz'[a]}", 1 - np.eye(3)[a]) for a in range(3)),
            ):
                radial = away * shape
                far = np.linalg.norm(radial, axis=2)
                least, most = self.context.yardstick(f"{name} around", partial(_ends_of, far))
                wide = most - (most - least) * (1 - share)
                past = np.maximum(far - wide, 0.0) / np.maximum(far, 1e-9)
                out.append(field(name, to_rows(self.context, -past[..., None] * radial)))
            yield one_way(Space(f"cage {share}", "contact cage", acting(out)))

    def posts(self) -> Iterator[Space]:
        """Some markers near each other are stopped, each at a share of its own farthest way."""
        top = self.length.max(axis=0)
        far = np.maximum(top, 1e-9)
        way = self.way[self.first]
        against = -np.einsum("cmj,cmj->cm", self.left, way)
        gain = np.zeros(len(top))
        for level in (0.4, 0.6, 0.8):
            past = np.maximum(self.length[self.first] - level * far, 0.0)
            size = np.sqrt((past**2).sum(axis=0))
            gain = np.maximum(gain, np.maximum((past * against).sum(axis=0), 0.0) / np.maximum(size, 1e-9))
        gain[top < 0.2 * top.max()] = 0.0
        middle = self.here.mean(axis=0)
        chosen: list[int] = []
        for m in np.argsort(-gain):
            if gain[m] <= 0 or len(chosen) == 2:
                break
            chosen.append(int(m))
        for m in chosen:
            near = np.argsort(np.linalg.norm(middle - middle[m], axis=1))[:_NEIGHBOURS]
            ahead = self.way[np.argmax(self.length[:, m]), m]
            out = []
            for level in (0.35, 0.55, 0.75, 0.9):
                for n in near:
                    along = self.move[:, n] @ ahead
                    stopped = np.maximum(along - level * max(along.max(), 1e-9), 0.0)
                    alone = np.zeros_like(self.move)
                    alone[:, n] = -stopped[:, None] * ahead
                    out.append(field(f"neighbour {n} {level}", to_rows(self.context, alone)))
            key = f"post before {self.context.rows.markers[m]}"
            yield one_way(Space(key, "contact post", acting(out), scanned=len(top)))


def _ends_of(values: Floats) -> Floats:
    return np.array([values.min(), values.max()])


def beside_markers(rows: Rows) -> Floats:
    """Each of few sensors that were seen and are no marker's, (n, K), 1 or 0; none where there are no markers."""
    alone = np.flatnonzero((rows.marker < 0) & np.isfinite(rows.values).any(axis=0))
    few = (rows.marker >= 0).any() and len(alone) <= FEW_OBSERVABLES
    return np.eye(len(rows.marker))[alone if few else alone[:0]]


def by_marker(context: Context, values: Floats) -> Floats:
    """Values (F, K) as (F, M, 3), zero along axes that are not seen."""
    rows = context.rows
    own = np.flatnonzero((rows.marker >= 0) & (rows.axis >= 0))
    out = np.zeros((len(values), len(rows.markers), 3))
    out[:, rows.marker[own], rows.axis[own]] = values[:, own]
    return out


def to_rows(context: Context, values: Floats) -> Floats:
    """The reverse of `by_marker`."""
    rows = context.rows
    own = np.flatnonzero((rows.marker >= 0) & (rows.axis >= 0))
    out = np.zeros((len(values), len(rows.marker)))
    out[:, own] = values[:, rows.marker[own], rows.axis[own]]
    return out
