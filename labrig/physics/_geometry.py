"""Where things are: the resting surface, the soft patches of its chambers, and its markers.

A surface is a map from (u, v) in the unit square to mm: x across, y outwards (to the front), z up. A chamber
is a soft rectangular patch of the square with a dome-shaped profile that spills over to its neighbours.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats


@dataclass(frozen=True)
class Patch:
    """One chamber: its edges in (u, v), and the law of its membrane at the middle of the patch.

    `gain_mm_per_kpa` is the compliance at rest; `limit_mm` the deflection at which the cubic (geometric)
    stiffening of the membrane equals its linear stiffness.
    """

    u0: float
    u1: float
    v0: float
    v1: float
    gain_mm_per_kpa: float
    limit_mm: float


@dataclass(frozen=True)
class Geometry:
    """A named surface: its rest map `(u, v) -> (..., 3)` mm, patches, and markers in (u, v), shape (M, 2)."""

    name: str
    rest: Callable[[Floats, Floats], Floats]
    patches: tuple[Patch, ...]
    markers_uv: Floats
    edge: float  # width of a patch's soft edge, in (u, v)
    tangential: float  # second-order tangential displacement, dimensionless


def _mannequin(u: Floats, v: Floats) -> Floats:
    """Front of a torso at half scale: a doubly curved half shell, 420 mm high."""
    angle = (u - 0.5) * np.deg2rad(140.0)
    girth = 1.0 - 0.16 * np.exp(-(((v - 0.35) / 0.2) ** 2)) + 0.05 * np.sin(np.pi * v)
    side = np.exp(-(((u - 0.33) / 0.12) ** 2)) + np.exp(-(((u - 0.67) / 0.12) ** 2))
    bust = 14.0 * np.exp(-(((v - 0.72) / 0.12) ** 2)) * side
    return np.stack([150.0 * girth * np.sin(angle), 95.0 * girth * np.cos(angle) + bust, 420.0 * v], axis=-1)


def _flat(u: Floats, v: Floats) -> Floats:
    """A flat upright sheet of 200 mm x 200 mm, facing y."""
    return np.stack([200.0 * (u - 0.5), np.zeros_like(u), 200.0 * v], axis=-1)


def spread_points(count: int, margin: float) -> Floats:
    """`count` well-spread points of the unit square, `margin` away from its border; shape (count, 2)."""
    plastic = 1.32471795724474602596
    index = np.arange(1, count + 1)[:, None]
    points = (0.5 + index * np.array([1.0 / plastic, 1.0 / plastic**2])) % 1.0
    return np.asarray(margin + (1.0 - 2.0 * margin) * points, dtype=float)


def grid_points(columns: int, rows: int, margin: float) -> Floats:
    """A regular grid inside the unit square, `margin` away from its border, u fastest; (columns * rows, 2)."""
    u, v = (margin + (1.0 - 2.0 * margin) * (np.arange(n) + 0.5) / n for n in (columns, rows))
    return np.stack(np.meshgrid(u, v, indexing="xy"), axis=-1).reshape(-1, 2)


_MANNEQUIN_PATCHES = (
    Patch(0.06, 0.335, 0.66, 0.93, 1.05, 62.0),
    Patch(0.365, 0.635, 0.66, 0.93, 0.95, 58.0),
    Patch(0.665, 0.94, 0.66, 0.93, 1.05, 62.0),
    Patch(0.22, 0.78, 0.30, 0.80, 0.70, 70.0),  # the chamber that lies over the middle of the others
    Patch(0.06, 0.485, 0.37, 0.63, 1.15, 66.0),
    Patch(0.515, 0.94, 0.37, 0.63, 1.15, 66.0),
    Patch(0.06, 0.335, 0.07, 0.34, 1.00, 60.0),
    Patch(0.365, 0.635, 0.07, 0.34, 0.90, 56.0),
    Patch(0.665, 0.94, 0.07, 0.34, 1.00, 60.0),
)

_MEMBRANE_PATCHES = (
    Patch(0.06, 0.48, 0.06, 0.48, 0.80, 48.0),
    Patch(0.52, 0.94, 0.06, 0.48, 0.75, 45.0),
    Patch(0.06, 0.48, 0.52, 0.94, 0.85, 50.0),
    Patch(0.52, 0.94, 0.52, 0.94, 0.78, 46.0),
)

GEOMETRIES = {
    "mannequin": Geometry("mannequin", _mannequin, _MANNEQUIN_PATCHES, spread_points(34, 0.08), 0.075, 0.2),
    "membrane": Geometry("membrane", _flat, _MEMBRANE_PATCHES, grid_points(4, 4, 0.0), 0.11, 0.2),
}


def _step(x: Floats, width: float) -> tuple[Floats, Floats]:
    """A soft step and its slope."""
    t = np.tanh(x / width)
    return t, (1.0 - t * t) / width


def _ridge(x: Floats, low: float, high: float, width: float) -> tuple[Floats, Floats]:
    """One inside [low, high], zero outside, soft edges of `width`; value and slope."""
    rise, rise_slope = _step(x - low, width)
    fall, fall_slope = _step(x - high, width)
    return 0.5 * (rise - fall), 0.5 * (rise_slope - fall_slope)


def profiles(geometry: Geometry, u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
    """How far each chamber moves each point per mm of its own deflection, and the slopes of that.

    Returns value, d/du, d/dv, each of shape (P, C). 85 % of a profile is the patch's own dome; 15 % spreads
    over twice the distance, to the neighbours.
    """
    value = np.zeros((u.size, len(geometry.patches)))
    slope_u, slope_v = np.zeros_like(value), np.zeros_like(value)
    for share, width in ((0.85, geometry.edge), (0.15, 2.5 * geometry.edge)):
        for c, patch in enumerate(geometry.patches):
            across, across_slope = _ridge(u, patch.u0, patch.u1, width)
            up, up_slope = _ridge(v, patch.v0, patch.v1, width)
            value[:, c] += share * across * up
            slope_u[:, c] += share * across_slope * up
            slope_v[:, c] += share * across * up_slope
    return value, slope_u, slope_v


def tangents(geometry: Geometry, u: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
    """Tangents d/du and d/dv (mm, not normalised) and the outward unit normal; each (P, 3)."""
    step = 1e-5
    along_u = (geometry.rest(u + step, v) - geometry.rest(u - step, v)) / (2.0 * step)
    along_v = (geometry.rest(u, v + step) - geometry.rest(u, v - step)) / (2.0 * step)
    normal = np.cross(along_v, along_u)
    return along_u, along_v, normal / np.linalg.norm(normal, axis=-1, keepdims=True)
