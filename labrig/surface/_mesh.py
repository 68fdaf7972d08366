"""Surfaces as triangles or as points: read from any export of a scanner, cleaned, with normals and borders."""

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats, Ints

NEIGHBOURS = 20
"""Points whose plane gives a cloud its normals."""
RAMP, _RAMP_SHARE = (2, 6), 0.057
"""Edges from the border on which pairs count in full: at least, at most, and times the root of the vertices' number."""
_MM_SIZES, _M_SIZES = (30.0, 5000.0), (0.03, 5.0)
_DEBRIS = 0.02
_BORDER_OFFSET = 0.28
"""How far a point is from the middle of its neighbours, as a share of their reach: 0.42 at a straight border."""
_FAR = 3.0


@dataclass(frozen=True)
class Mesh:
    """A surface: vertices (V, 3), mm, and triangles (T, 3) of their indices; T = 0 for a cloud.

    A mesh's normals point to the side from which its triangles run counter-clockwise. A cloud's normals are
    turned away from its middle, which is right for anything that is round.
    """

    vertices_mm: Floats
    triangles: Ints

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
    def border(self) -> NDArray[np.bool_]:
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
    def _cloud(self) -> tuple[Floats, NDArray[np.bool_], float]:
        """Normals, border and spacing of a cloud, from each point's nearest neighbours."""
        from scipy.spatial import KDTree

        points = self.vertices_mm
        distance, near = KDTree(points).query(points, k=min(NEIGHBOURS, len(points)))
        around = points[near] - points[near].mean(axis=1, keepdims=True)
        normal = np.linalg.eigh(np.einsum("pki,pkj->pij", around, around))[1][:, :, 0]
        outwards = np.einsum("pi,pi->p", normal, points - _middle(points))
        normal = np.where(outwards[:, None] < 0, -normal, normal)
        # at a border all neighbours lie on one side
        offset = np.linalg.norm((points[near] - points[:, None]).mean(axis=1), axis=1)
        return normal, offset > _BORDER_OFFSET * distance.max(axis=1), float(np.median(distance[:, 1]))

    def moved(self, rotation: ArrayLike, translation_mm: ArrayLike) -> "Mesh":
        """The same surface after `rotation` (3, 3) and then `translation_mm` (3,)."""
        return Mesh(self.vertices_mm @ np.asarray(rotation).T + np.asarray(translation_mm), self.triangles)


def _middle(points: Floats) -> Floats:
    """A point inside: the mean, moved back by the depth of the open side of a shell."""
    mean = points.mean(axis=0)
    axes = np.linalg.eigh(np.cov((points - mean).T))[1]
    thin = axes[:, 0]
    depth = (points - mean) @ thin
    side = np.sign(np.mean(depth**3)) or 1.0  # a shell's rim is the tail of its depth
    return mean + side * np.ptp(depth) * thin


def read_mesh(path: str | Path, unit: str | None = None) -> Mesh:
    """Read an OBJ, PLY, STL or XYZ file as Artec Studio and others export it.

    `unit` (mm, cm, m, inch) is that of the file; left out, it is what a PLY says of itself (`comment unit mm`),
    or mm or m, whichever makes a size that a person's surface can have. Raises `LabrigError`, in one line, for a
    file that is missing, damaged, of another kind, or of no clear size.
    """
    from labrig_drivers._artec_files import MM_PER_UNIT, ScanFileError, parse, read_set, scan_set

    path = Path(path)
    if unit is not None and unit not in MM_PER_UNIT:
        raise LabrigError(f"unit {unit!r}: choose one of {', '.join(MM_PER_UNIT)}")
    try:
        data, _ = read_set(scan_set(path))
        geometry = parse(data, path.name)
    except ScanFileError as error:
        raise LabrigError(f"{path.parent / str(error)}") from None
    except OSError as error:
        raise LabrigError(f"cannot read {path}: {error.strerror or error}") from None
    size = float(np.linalg.norm(np.ptp(geometry.vertices, axis=0)))
    unit = unit or _declared_unit(data) or _likely_unit(size, path)
    return clean(geometry.vertices * MM_PER_UNIT[unit], geometry.triangles, str(path))


def _declared_unit(data: bytes) -> str | None:
    found = re.search(rb"^comment unit (mm|cm|m|inch)\s*$", data[:4096], re.MULTILINE)
    return found[1].decode() if found else None


def _likely_unit(size: float, path: Path) -> str:
    for unit, (low, high) in (("mm", _MM_SIZES), ("m", _M_SIZES)):
        if low <= size <= high:
            return unit
    raise LabrigError(
        f"{path} is {size:.3g} across, in mm or in m no size for a surface: say its unit (--unit)"
    )


def clean(vertices_mm: ArrayLike, triangles: ArrayLike, name: str = "mesh") -> Mesh:
    """Weld seams, drop what has no area, and drop loose pieces that are small beside the largest one.

    Raises `LabrigError` when nothing is left that could be a surface.
    """
    from labrig_drivers._artec_files import weld

    vertices, corners = np.asarray(vertices_mm, float), np.asarray(triangles, np.int64).reshape(-1, 3)
    if len(corners) == 0:
        return _clean_cloud(vertices, name)
    welded = weld(vertices, corners)
    vertices, corners = _without_debris(welded.vertices, welded.triangles)
    if len(corners) < 8:
        raise LabrigError(f"{name}: has {len(corners)} triangles with an area, which is no surface")
    return Mesh(vertices, corners)


def _without_debris(vertices: Floats, triangles: Ints) -> tuple[Floats, Ints]:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if len(triangles) == 0:
        return vertices, triangles
    edges = np.concatenate([triangles[:, :2], triangles[:, 1:]])
    graph = coo_array((np.ones(len(edges), bool), (edges[:, 0], edges[:, 1])), shape=(len(vertices),) * 2)
    _, piece = connected_components(graph, directed=False)
    size = np.bincount(piece[triangles[:, 0]], minlength=piece.max() + 1)
    kept = triangles[size[piece[triangles[:, 0]]] >= _DEBRIS * size.max()]
    used, renumbered = np.unique(kept, return_inverse=True)
    return vertices[used], renumbered.reshape(-1, 3).astype(np.int64)


def _clean_cloud(points: Floats, name: str) -> Mesh:
    """Drop points that stand far away from their neighbours."""
    from scipy.spatial import KDTree

    points = np.unique(points, axis=0)
    if len(points) < NEIGHBOURS:
        raise LabrigError(f"{name}: has {len(points)} different points, which is no surface")
    distance = KDTree(points).query(points, k=9)[0][:, 1:].mean(axis=1)
    return Mesh(points[distance <= _FAR * np.median(distance)], np.zeros((0, 3), np.int64))
