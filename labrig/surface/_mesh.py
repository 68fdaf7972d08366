"""Surfaces as triangles or as points, with normals and borders."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from labrig.arrays import Bools, Floats, Ints
from labrig.surface._aside import call

RAMP, _RAMP_SHARE = (2, 6), 0.057
"""Edges from the border on which pairs count in full: at least, at most, and times the root of the vertices' number."""


@dataclass(frozen=True)
class Mesh:
    """A surface: vertices (V, 3), mm, and triangles (T, 3) of their indices; T = 0 for a cloud.

    A mesh's normals point to the side from which its triangles run counter-clockwise. A cloud's normals are
    turned away from its middle, which is right for anything that is round. `notes` say what cleaning did to it.
    """

    vertices_mm: Floats
    triangles: Ints
    notes: tuple[str, ...] = ()

    @property
    def is_cloud(self) -> bool:
        """Whether there are points only."""
        return len(self.triangles) == 0

    @cached_property
    def normals(self) -> Floats:
        """Unit normals at the vertices, (V, 3); zero where a vertex belongs to no triangle."""
        if self.is_cloud:
            return self._cloud[0]
        from labrig.surface._kernels import vertex_normals

        return vertex_normals(self.vertices_mm, self.triangles)

    @cached_property
    def border(self) -> Bools:
        """Which vertices lie on a border or at a hole, (V,)."""
        if self.is_cloud:
            return self._cloud[1]
        from labrig.surface._kernels import border_vertices

        return border_vertices(len(self.vertices_mm), self.triangles)

    @cached_property
    def inwardness(self) -> Floats:
        """How far each vertex is from the border, (V,): 0 on it, 1 from some edges on; a cloud has only these two.

        The finer the mesh, the more edges, so that the ramp is about as wide on any scan of a surface.
        """
        if self.is_cloud:
            return (~self.border).astype(np.float64)
        from labrig.surface._kernels import rings_from_border

        edges = int(np.clip(round(_RAMP_SHARE * np.sqrt(len(self.vertices_mm))), *RAMP))
        return np.asarray(
            rings_from_border(self.border, self.triangles, *self.around, edges) / edges, np.float64
        )

    @cached_property
    def around(self) -> tuple[Ints, Ints]:
        """Which triangles each vertex belongs to: `around[1][around[0][v] : around[0][v + 1]]`."""
        from labrig.surface._kernels import triangles_around

        return triangles_around(len(self.vertices_mm), self.triangles)

    @cached_property
    def inward_slope(self) -> Floats:
        """How `inwardness` rises along the surface, (V, 3), 1/mm; zero for a cloud."""
        if self.is_cloud:
            return np.zeros_like(self.vertices_mm)
        from labrig.surface._kernels import slope_along

        return slope_along(self.vertices_mm, self.triangles, self.inwardness)

    @cached_property
    def spacing_mm(self) -> float:
        """The typical distance between neighbouring points, from area and count."""
        if self.is_cloud:
            return self._cloud[2]
        corners = self.vertices_mm[self.triangles]
        area = np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        ).sum()
        return float(np.sqrt(area / 2.0 / max(len(self.vertices_mm), 1)))

    @cached_property
    def _cloud(self) -> tuple[Floats, Bools, float]:
        """Normals, border and spacing of a cloud, from each point's nearest neighbours, by Open3D."""
        normals, border, spacing_mm = call("cloud_frame", self.vertices_mm)
        return normals, border, spacing_mm

    def moved(self, rotation: ArrayLike, translation_mm: ArrayLike) -> "Mesh":
        """The same surface after `rotation` (3, 3) and then `translation_mm` (3,)."""
        return Mesh(
            self.vertices_mm @ np.asarray(rotation).T + np.asarray(translation_mm), self.triangles, self.notes
        )

    def turned(self) -> "Mesh":
        """The same surface with its inside out; a cloud stays as it is."""
        return Mesh(self.vertices_mm, np.ascontiguousarray(self.triangles[:, ::-1]), self.notes)

    def without(self, vertices: Bools) -> "Mesh":
        """The same surface without some of its vertices (V,), and the triangles that have one of them."""
        number = np.cumsum(~vertices) - 1
        kept = self.triangles[~vertices[self.triangles].any(axis=1)]
        return Mesh(self.vertices_mm[~vertices], number[kept], self.notes)
