"""How far points are from a surface, with a sign: positive outside, negative inside."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from labrig.arrays import Floats
from labrig.surface._mesh import Mesh
from labrig.surface._nearest import Nearest

_CANDIDATES = 6
"""Nearest vertices whose triangles are tried; the nearest triangle of an even mesh is always among them."""


@dataclass(frozen=True)
class Distances:
    """Signed distances of P points, mm (P,), their feet on the surface (P, 3), and which points lie beyond it.

    Beyond: the foot is on the surface's border, so the point has nothing opposite (it is outside of a partial target,
    or over a hole); its distance says little.
    """

    signed_mm: Floats
    feet_mm: Floats
    beyond: NDArray[np.bool_]

    @property
    def within(self) -> Floats:
        """The distances of the points that do have the surface opposite."""
        return self.signed_mm[~self.beyond]

    def summary(self) -> dict[str, float]:
        """Mean, 95 % and maximum of the absolute distance, mm, the signed mean, and the share that is not beyond."""
        absolute = np.abs(self.within)
        if not len(absolute):
            return dict.fromkeys(("mean_mm", "p95_mm", "max_mm", "signed_mm"), float("nan")) | {"share": 0.0}
        return {
            "mean_mm": float(absolute.mean()),
            "p95_mm": float(np.quantile(absolute, 0.95)),
            "max_mm": float(absolute.max()),
            "signed_mm": float(self.within.mean()),
            "share": float(len(absolute) / len(self.signed_mm)),
        }


def distances(points_mm: ArrayLike, surface: Mesh, nearest: Nearest | None = None) -> Distances:
    """Distances of points (P, 3) from a mesh (exact, to its triangles) or from a cloud (to its tangent planes).

    `nearest`: a tree over the surface's vertices, if there is one already.
    """
    points = np.ascontiguousarray(points_mm, dtype=np.float64)
    tree = nearest or Nearest(surface.vertices_mm)
    if surface.is_cloud:
        index, _ = tree.one(points)
        offset = points - surface.vertices_mm[index]
        normal = surface.normals[index]
        height = np.einsum("pi,pi->p", offset, normal)
        return Distances(height, points - height[:, None] * normal, surface.border[index])
    from labrig.surface._kernels import closest_points

    feet, signed, beyond = closest_points(
        points,
        tree.several(points, _CANDIDATES),
        np.ascontiguousarray(surface.vertices_mm),
        np.ascontiguousarray(surface.triangles),
        *surface.around,
        surface.normals,
        surface.border,
    )
    return Distances(signed, feet, beyond)
