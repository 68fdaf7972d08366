"""A target and the surface that comes near to it, as two figures in space that are looked at from the same side."""

from typing import TYPE_CHECKING, Any

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.view._figures import Figure
from labrig.view._shape_figures import NOTHING, histogram, plain_mesh, points_in_space, signed_map
from labrig.view._space import camera, scene_layout

if TYPE_CHECKING:
    from labrig.ik import Placed

_LEAST_MM = 0.5
_MOST_POINTS = 4000
_MARGIN = 0.03


def target_figures(placed: "Placed", most_triangles: int) -> dict[str, Any]:
    """`target`, `surface` in colours of its signed distances, how these are `spread`, and `top_mm` of the colours.

    A target of more triangles than `most_triangles` is drawn coarser.
    """
    known = np.abs(placed.signed_mm[np.isfinite(placed.signed_mm)])
    top = max(_LEAST_MM, float(np.quantile(known, 0.98))) if len(known) else 1.0
    surface = signed_map(placed.surface_mm, placed.triangles, placed.signed_mm, top)
    vertices, triangles = placed.target.vertices_mm, placed.target.triangles
    if placed.target.is_cloud:
        drawn = points_in_space(vertices[:: -(-len(vertices) // _MOST_POINTS)])
    else:
        drawn = plain_mesh(*coarser(vertices, triangles, most_triangles), NOTHING)
    target: Figure = {"data": [drawn], "layout": scene_layout({}, False)}
    _together([target, surface], np.concatenate([vertices, placed.surface_mm]), camera(placed.surface_mm))
    return {
        "target": target,
        "surface": surface,
        "spread": histogram([("predicted", placed.signed_mm)], 1.3 * top),
        "top_mm": round(top, 3),
    }


def coarser(vertices_mm: Floats, triangles: Ints, most: int) -> tuple[Floats, Ints]:
    """The same surface of about `most` triangles or fewer: vertices (V, 3) in one cell of a grid become their mean."""
    if len(triangles) <= most:
        return vertices_mm, triangles
    corners = vertices_mm[triangles]
    area = (
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
        / 2
    )
    cell = max(np.sqrt(2.0 * area / most), 1e-9)
    _, number, count = np.unique(
        np.floor(vertices_mm / cell), axis=0, return_inverse=True, return_counts=True
    )
    number = number.reshape(-1)
    sums = np.stack([np.bincount(number, vertices_mm[:, axis]) for axis in range(3)], axis=1)
    moved = number[triangles]
    whole = (moved != np.roll(moved, 1, axis=1)).all(axis=1)
    return sums / count[:, None], moved[whole]


def _together(figures: list[Figure], points_mm: Floats, seen_from: Figure) -> None:
    """The same ranges and the same camera for all."""
    low, high = points_mm.min(axis=0), points_mm.max(axis=0)
    margin = _MARGIN * float((high - low).max())
    for figure in figures:
        scene = figure["layout"]["scene"]
        scene["camera"] = seen_from
        for name, least, most in zip("xyz", low, high, strict=True):
            axis = scene[f"{name}axis"]
            scene[f"{name}axis"] = {**axis, "range": [float(least) - margin, float(most) + margin]}
