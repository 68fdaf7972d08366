"""Where cameras hand over: beyond a plane in space others see a marker, and put it a little elsewhere.

An optical measurement is as good as the calibration of those cameras that see a place, and that differs over the
volume (A. M. Aurand, J. S. Dufour, W. S. Marras, J. Biomechanics 58 (2017) 237-240).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from labrig._linalg import svd
from labrig.arrays import Floats
from labrig.effects import NORMALS, Context, Places, Space, acting, by_marker, field, motion_scale, to_rows

_LEVELS = (0.2, 0.35, 0.5, 0.65, 0.8)
"""Quantiles of how far the markers are along a normal at which planes are looked for: a grid."""
_BEST = 3
"""Planes, each with another normal, that are kept."""
_BY_CHANCE = 0.01
"""How often noise alone is asked for a plane."""
_SOFT = 0.05
"""Half the width of the step, share of the way along the normal: a grid."""


@dataclass(frozen=True)
class _Plane:
    """A plane through `normal` * `at_mm`, which markers pass within `soft_mm` on either side."""

    normal: Floats
    at_mm: float
    soft_mm: float

    def past(self, here: Floats, nearer_mm: float = 0.0) -> Floats:
        """From -1 before it to 1 behind it, (n, M), of places (n, M, 3)."""
        return np.tanh((here @ self.normal - self.at_mm + nearer_mm) / self.soft_mm)


def handovers(context: Context) -> Iterator[Space]:
    """Steps (F, K) of all markers that pass a plane: those that the residuals speak for most, and what is near them."""
    rows = context.rows
    if (rows.axis >= 0).sum() < 3 or rows.rest_mm is None or not np.isfinite(rows.rest_mm).all():
        return
    places = Places(context)
    planes = list(_planes(places.here))
    gains = _gains(planes, places)
    least = _by_chance(len(planes), places)
    best = sorted((i for i in range(len(planes)) if gains[i] > least), key=lambda i: -gains[i])
    chosen: dict[tuple[float, ...], _Plane] = {}
    for i in best:
        if len(chosen) < _BEST:
            chosen.setdefault(tuple(planes[i].normal), planes[i])
    size = by_marker(context, np.broadcast_to(motion_scale(context), context.base.shape))
    for plane in chosen.values():
        features = [
            field(f"{name} along {letter}", to_rows(context, shape[..., None] * size * np.eye(3)[a]), weight)
            for name, shape, weight in _shapes(plane, places.here)
            for a, letter in enumerate("xyz")
        ]
        yield Space("a plane in space", "handover", acting(features), scanned=len(planes))


def _planes(here: Floats) -> Iterator[_Plane]:
    """All that are looked at: across directions that differ, where the markers pass that go far along them."""
    for normal in NORMALS:
        if tuple(normal) < tuple(-normal):  # the same planes, from behind
            continue
        height = here @ normal
        way = np.ptp(height, axis=0)
        far = height[:, way >= 0.5 * way.max()]
        soft = _SOFT * float(np.ptp(far))
        if soft > 0:
            for at in np.quantile(far, _LEVELS):
                yield _Plane(normal, float(at), soft)


def _gains(planes: list[_Plane], places: Places) -> list[float]:
    """How much of the captures' residuals one shift beyond each plane takes, beside a place of each marker's own."""
    here, left = places.here[places.first], places.left - places.left.mean(axis=0)
    out = []
    for plane in planes:
        past = plane.past(here)
        past = past - past.mean(axis=0)
        said = np.einsum("nm,nma->a", past, left)
        out.append(float(said @ said) / max(float((past**2).sum()), 1e-9))
    return out


def _by_chance(count: int, places: Places) -> float:
    """What none of so many planes takes by chance: what does not change where markers pass is a shape, whatever its
    sides.
    """
    left = places.left - places.left.mean(axis=0)
    noise = float(np.median(left**2) / chdtri(1, 0.5))
    return noise * float(chdtri(3, _BY_CHANCE / max(count, 1)))


def _shapes(plane: _Plane, here: Floats) -> Iterator[tuple[str, Floats, float]]:
    """Name, (F, M) and weight: the plane, one before and one behind it, and what it does when it is tilted."""
    yield "past", plane.past(here), 1.0
    yield "earlier", plane.past(here, 4 * plane.soft_mm), 0.3
    yield "later", plane.past(here, -4 * plane.soft_mm), 0.3
    near = 1 - (0.5 * (plane.past(here, 2 * plane.soft_mm) + plane.past(here, -2 * plane.soft_mm))) ** 2
    for j, way in enumerate(svd(np.eye(3) - np.outer(plane.normal, plane.normal))[2][:2]):
        side = (here - here.mean(axis=(0, 1))) @ way
        yield f"tilted {j}", near * side / max(float(np.sqrt((side**2).mean())), 1e-12), 0.3
