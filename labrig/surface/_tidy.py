"""Scans made tidy by Open3D: fragments, a base plane, small holes, winding, outliers. Runs in `_aside`'s process.

Open3D (https://www.open3d.org) never raises: what it returns is checked here.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats, Ints
from labrig.surface._pose import spread_rotations

NEIGHBOURS = 20
"""Points whose plane gives a cloud its normals."""
FRAGMENT = 0.02
"""A loose piece with less than this share of the largest one's area, or number of points, is a fragment."""
HOLE = 0.02
"""Holes are closed up to this radius, as a share of the size: dots and shadows of markers, not missing parts."""
BEYOND = 1.25
"""A scan larger than the model by this much may stand on a base plane."""
_FLAT = 0.006
"""Half the thickness of a base plane, as a share of the model's size."""
_BASE_SHARE, _LEFT_SHARE, _ASIDE_SHARE = 0.1, 0.1, 0.95
_TRIES = 1000
_POSES, _SIZED = 240, 5000
_TOUCHING, _COMPANY = 4.0, 4
"""Points hang together within so many times their spacing; with fewer than so many near it one is an outlier."""


def tidy_mesh(
    vertices: Floats, triangles: Ints, like_mm: float | None
) -> tuple[Floats, Ints, tuple[str, ...]]:
    """A welded mesh's vertices (V, 3), mm, and triangles (T, 3) without what is no surface, and what was done.

    With the size of the model, `like_mm` (diagonal of its box), a plane on which the object stands is cut away.
    """
    notes: list[str] = []
    triangles = _without_fragments(vertices, triangles, notes)
    based = _off_base(vertices, like_mm)
    if based is not None:
        # what stands up, and no triangle that only touches the plane
        kept = triangles[~based[triangles].any(axis=1)]
        if len(kept):
            notes.append(f"base plane cut away: {1.0 - len(kept) / len(triangles):.0%} of the triangles")
            triangles = _without_fragments(vertices, kept, notes)
    closed = _without_holes(vertices, triangles)
    if len(closed) > len(triangles):
        notes.append(f"small holes closed with {len(closed) - len(triangles)} triangles")
    turned, count = _one_side(vertices, closed, len(triangles))
    if count:
        notes.append(f"{count} triangles faced the other way than those around them, and were turned")
    used, renumbered = np.unique(turned, return_inverse=True)
    return vertices[used], renumbered.reshape(-1, 3).astype(np.int64), tuple(notes)


def tidy_cloud(points: Floats, like_mm: float | None) -> tuple[Floats, tuple[str, ...]]:
    """A cloud's points (N, 3), mm, without copies, outliers, fragments and base plane, and what was done."""
    notes: list[str] = []
    cloud = _cloud(points).remove_duplicated_points()
    before = len(cloud.points)
    if before:
        spacing = float(np.median(np.asarray(cloud.compute_nearest_neighbor_distance())))
        piece = np.asarray(cloud.cluster_dbscan(_TOUCHING * max(spacing, 1e-9), _COMPANY))
        count = np.bincount(piece + 1)[1:]  # -1: without company
        kept = np.isin(piece, np.flatnonzero(count >= FRAGMENT * count.max(initial=0)))
        cloud = cloud.select_by_index(np.flatnonzero(kept))
    if len(cloud.points) < before:
        notes.append(f"outliers and fragments dropped: {before - len(cloud.points)} points")
    based = _off_base(np.asarray(cloud.points), like_mm)
    if based is not None:
        notes.append(f"base plane cut away: {based.mean():.0%} of the points")
        cloud = cloud.select_by_index(np.flatnonzero(~based))
    return np.asarray(cloud.points).copy(), tuple(notes)


def cloud_frame(points: Floats) -> tuple[Floats, NDArray[np.bool_], float]:
    """Unit normals (N, 3) of points (N, 3), away from their middle; which lie on a border (N,); their spacing, mm."""
    import open3d as o3d

    cloud = _cloud(points)
    cloud.estimate_normals(o3d.geometry.KDTreeSearchParamKNN(min(NEIGHBOURS, len(points))))
    cloud.orient_normals_towards_camera_location(_middle(points))
    spacing = float(np.median(np.asarray(cloud.compute_nearest_neighbor_distance())))
    normals = -np.asarray(cloud.normals)
    exact = o3d.t.geometry.PointCloud(o3d.core.Tensor.from_numpy(np.ascontiguousarray(points)))
    exact.point.normals = o3d.core.Tensor.from_numpy(normals)
    _, border = exact.compute_boundary_points(3.0 * spacing, 30, 90.0)
    return normals, border.numpy().astype(bool).reshape(-1), spacing


def _cloud(points: Floats) -> Any:
    import open3d as o3d

    return o3d.geometry.PointCloud(o3d.utility.Vector3dVector(np.ascontiguousarray(points, np.float64)))


def _mesh(vertices: Floats, triangles: Ints) -> Any:
    import open3d as o3d

    return o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(np.ascontiguousarray(vertices, np.float64)),
        o3d.utility.Vector3iVector(np.ascontiguousarray(triangles, np.int32)),
    )


def _without_fragments(vertices: Floats, triangles: Ints, notes: list[str]) -> Ints:
    if len(triangles) == 0:
        return triangles
    piece, _, area = (np.asarray(x) for x in _mesh(vertices, triangles).cluster_connected_triangles())
    kept = area >= FRAGMENT * area.max()
    if not kept.all():
        notes.append(f"loose fragments dropped: {np.count_nonzero(~kept)}")
    return triangles[kept[piece]]


def _off_base(points: Floats, like_mm: float | None) -> NDArray[np.bool_] | None:
    """Which points (N,) belong to a plane on which the rest stands; None where there is none.

    It is looked for only where the whole is larger than the model; the rest has to stand on one side of it.
    """
    if like_mm is None:
        return None
    most_mm = BEYOND * like_mm
    if float(np.linalg.norm(np.ptp(points, axis=0))) <= most_mm or _size(points) <= most_mm:
        return None
    import open3d as o3d

    o3d.utility.random.seed(0)
    thick = _FLAT * like_mm
    plane, inside = _cloud(points).segment_plane(thick, 3, _TRIES)
    height = points @ np.asarray(plane[:3]) + plane[3]
    rest = np.ones(len(points), bool)
    rest[np.asarray(inside, np.int64)] = False
    if not _BASE_SHARE <= 1.0 - rest.mean() <= 1.0 - _LEFT_SHARE:
        return None
    above = float((height[rest] > 0).mean())
    if max(above, 1.0 - above) < _ASIDE_SHARE:
        return None
    return ~rest | (height < 0 if above > 0.5 else height > 0)


def _size(points: Floats) -> float:
    """The diagonal of the smallest box that holds points (N, 3), in many poses: a square askew is not larger."""
    some = points[:: max(1, len(points) // _SIZED)]
    turned = np.concatenate([np.eye(3)[None], spread_rotations(_POSES)])
    return min(float(np.linalg.norm(np.ptp(some @ rotation.T, axis=0))) for rotation in turned)


def _without_holes(vertices: Floats, triangles: Ints) -> Ints:
    """The triangles, and behind them those that close small holes between the same vertices."""
    import open3d as o3d

    size = float(np.linalg.norm(np.ptp(vertices[np.unique(triangles)], axis=0)))
    mesh = o3d.t.geometry.TriangleMesh(
        o3d.core.Tensor.from_numpy(np.ascontiguousarray(vertices)),
        o3d.core.Tensor.from_numpy(np.ascontiguousarray(triangles)),
    )
    try:
        filled = mesh.fill_holes(HOLE * size)
    except RuntimeError:  # edges of three triangles and the like: nothing is closed
        return triangles
    found = np.asarray(filled.triangle.indices.numpy(), np.int64)
    same = len(filled.vertex.positions) == len(vertices) and len(found) >= len(triangles)
    return found if same and (found[: len(triangles)] == triangles).all() else triangles


def _one_side(vertices: Floats, triangles: Ints, own: int) -> tuple[Ints, int]:
    """All triangles wound as most of the surface is, and how many of the first `own` had to be turned."""
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    if len(np.unique(ends[:, 0] * len(vertices) + ends[:, 1])) == len(ends):
        return triangles, 0  # every edge is run along once each way
    mesh = _mesh(vertices, triangles)
    if not mesh.orient_triangles():  # it has one side only, or edges of three triangles
        return triangles, 0
    wound = np.asarray(mesh.triangles).astype(np.int64)
    before = np.cross(*_edges(vertices, triangles[:own]))
    same = (before * np.cross(*_edges(vertices, wound[:own]))).sum(axis=1) > 0
    area = np.linalg.norm(before, axis=1)
    piece = np.asarray(mesh.cluster_connected_triangles()[0])
    for number in range(piece.max() + 1):
        first = piece[:own] == number
        if area[first & same].sum() < area[first & ~same].sum():
            wound[piece == number] = wound[piece == number][:, ::-1]
            same[first] = ~same[first]
    return wound, int(np.count_nonzero(~same & (area > 0)))


def _edges(vertices: Floats, triangles: Ints) -> tuple[Floats, Floats]:
    a = vertices[triangles[:, 0]]
    return vertices[triangles[:, 1]] - a, vertices[triangles[:, 2]] - a


def _middle(points: Floats) -> Floats:
    """A point inside: the mean, moved back by the depth of the open side of a shell."""
    mean = points.mean(axis=0)
    thin = np.linalg.eigh(np.cov((points - mean).T))[1][:, 0]
    depth = (points - mean) @ thin
    side = np.sign(np.mean(depth**3)) or 1.0  # a shell's rim is the tail of its depth
    return mean + side * np.ptp(depth) * thin
