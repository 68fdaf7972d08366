"""A surface made ready to be asked for nearest points again and again."""

from functools import cached_property

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.surface._mesh import Mesh
from labrig.surface._nearest import Nearest

FEW = 400
"""Points for rough searches."""
_SPARSE = 1500
"""Vertices in the tree from which nearest ones are sought along the surface."""


class Target:
    """A surface made ready to be asked for nearest points again and again."""

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh

    @cached_property
    def nearest(self) -> Nearest:
        """A tree over all of its vertices."""
        return Nearest(self.mesh.vertices_mm)

    @cached_property
    def size_mm(self) -> float:
        """The diagonal of its bounding box."""
        low, high, _ = self._extent
        return float(np.linalg.norm(high - low))

    @property
    def middle_mm(self) -> Floats:
        """The mean of its vertices, (3,)."""
        return self._extent[2]

    @cached_property
    def _extent(self) -> tuple[Floats, Floats, Floats]:
        from labrig.surface._kernels import extent

        return extent(self.mesh.vertices_mm)

    @cached_property
    def few(self) -> tuple[Floats, Floats]:
        """Some of its points and their normals, (3, N) each, for rough searches."""
        count = len(self.mesh.vertices_mm)
        chosen = np.random.default_rng(0).permutation(count)[:FEW]
        points, normals = self.mesh.vertices_mm[chosen], self.mesh.normals[chosen]
        return np.ascontiguousarray(points.T), np.ascontiguousarray(normals.T)

    def near(self, points_mm: Floats, index: Ints | None = None) -> Ints:
        """The vertices nearest to points (P, 3), walking along the surface from some that are not far, `index` (P,).

        Without these it begins at vertices that a small tree gives. Much quicker than the whole tree; where the surface
        folds or ends, one on the other side may be missed.
        """
        mesh = self.mesh
        if mesh.is_cloud:
            return self.nearest.one(points_mm)[0]
        if index is None:
            stride, tree = self._sparse
            index = tree.one(points_mm)[0] * stride
        from labrig.surface._kernels import walk_to_nearest

        return walk_to_nearest(points_mm, index, mesh.vertices_mm, mesh.triangles, *mesh.around)

    @cached_property
    def _sparse(self) -> tuple[int, Nearest]:
        """A tree over every so many of its vertices."""
        stride = max(1, len(self.mesh.vertices_mm) // _SPARSE)
        return stride, Nearest(self.mesh.vertices_mm[::stride])
