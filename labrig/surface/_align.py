"""A scan laid onto a surface by Open3D: features and RANSAC, then robust point-to-plane ICP; in `_aside`'s process.

Open3D (https://www.open3d.org) never raises: what it returns is checked here.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Bools, Floats, Ints
from labrig.surface._damped import damped_step

if TYPE_CHECKING:
    from labrig.surface._mesh import Mesh

FINE = 6000
"""Points of the source that are laid onto the target, about."""
_SEED = 0
_NO_FIT = "the scan and the surface do not fit each other: no part of one lies on the other"
_LEAST_SHARE = 0.02
_CELLS = 40
"""Cells along the target's size in which features are computed (FPFH: Rusu et al. 2009)."""
_FEATURE_CELLS, _FEATURE_POINTS = 5.0, 100
_ALIKE, _NEAR_CELLS, _DRAWN = 0.9, 1.5, 3
_DRAWS, _SURE = 100_000, 0.999
_DENSE = 10_000
"""A coarse target is subdivided up to about so many vertices, so that feet lie on its triangles."""
_REACH, _ROUNDS, _STEPS, _STILL_MM = 0.1, 20, 10, 1e-4
_TUKEY = 4.685
_FITS, _FAR = 0.005, 0.05
"""Misfit, as a share of the target's size, at which no other start is tried; distance that is simply far."""
_AGREE = 0.4
"""Cosine between normals, either way round, below which two points are no pair."""


@dataclass(frozen=True)
class Placed:
    """What `place` found: the `motion` (4, 4) from source to target, and its pairs at the end.

    `moved_mm` (P, 3) the source's points that were laid, `weight` (P,) how far each counts, `normal` (P, 3) and
    `height_mm` (P,) of the target under it; `own_normal` (P, 3) the source's, as moved; `turned`: most of them point
    against the target's.
    """

    motion: Floats
    moved_mm: Floats
    weight: Floats
    normal: Floats
    height_mm: Floats
    own_normal: Floats
    rounds: int
    turned: bool


def place(source: "Mesh", target: "Mesh", start: Floats | None) -> Placed:
    """Lay a source onto a target, from `start` (4, 4) or from anywhere; both may be partial.

    Without a start both sides of the source are tried as its outside: a scan may be inside out. Raises `LabrigError`
    when no part of one lies on the other.
    """
    points = _sampled(source)
    goal, border = _dense(target)
    size_mm = float(np.linalg.norm(np.ptp(target.vertices_mm, axis=0)))
    spacing_mm = target.spacing_mm * np.sqrt(len(target.vertices_mm) / len(border))
    starts = iter([start]) if start is not None else _from_anywhere(source, target, size_mm)
    best, least = None, np.inf
    for motion in starts:
        found, thrown = _fine(points, goal, border, motion, size_mm, spacing_mm)
        tried = [found, _slowly(points, goal, border, motion, size_mm, spacing_mm)] if thrown else [found]
        for placed in (one for one in tried if one is not None):
            misfit = _misfit(points, goal, placed.motion, size_mm)
            if misfit < least:
                best, least = placed, misfit
        if least < _FITS:
            break
    if best is None:
        raise LabrigError(_NO_FIT)
    return best


def _cloud(points: Floats, normals: Floats) -> Any:
    import open3d as o3d

    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(np.ascontiguousarray(points, np.float64)))
    cloud.normals = o3d.utility.Vector3dVector(np.ascontiguousarray(normals, np.float64))
    return cloud


def _sampled(mesh: "Mesh") -> Any:
    """About `FINE` points evenly over a surface, its border left out: the means of cells."""
    inner = ~mesh.border if not mesh.border.all() else np.ones(len(mesh.border), bool)
    cloud = _cloud(mesh.vertices_mm[inner], mesh.normals[inner])
    count = int(inner.sum())
    if count > FINE:
        cloud = cloud.voxel_down_sample(mesh.spacing_mm * float(np.sqrt(count / FINE)))
        cloud.normalize_normals()
    return cloud


def _dense(mesh: "Mesh") -> tuple[Any, Bools]:
    """A surface as points, closer together than its vertices where these are few, and which lie on its border."""
    if mesh.is_cloud or len(mesh.vertices_mm) >= _DENSE:
        return _cloud(mesh.vertices_mm, mesh.normals), mesh.border
    import open3d as o3d

    vector = o3d.utility.Vector3dVector
    fine = o3d.geometry.TriangleMesh(
        vector(np.ascontiguousarray(mesh.vertices_mm)),
        o3d.utility.Vector3iVector(mesh.triangles.astype(np.int32)),
    )
    fine.vertex_normals = vector(mesh.normals)
    fine.vertex_colors = vector(np.repeat(mesh.border[:, None], 3, axis=1).astype(float))
    fine = fine.subdivide_midpoint(round(np.log(_DENSE / len(mesh.vertices_mm)) / np.log(4.0)))
    fine.normalize_normals()
    return _cloud(np.asarray(fine.vertices), np.asarray(fine.vertex_normals)), np.asarray(fine.vertex_colors)[
        :, 0
    ] > 0.99


def _from_anywhere(source: "Mesh", target: "Mesh", size_mm: float) -> Iterator[Floats]:
    """Motions (4, 4) that RANSAC finds between features, with the source's normals as they are and turned."""
    cell_mm = size_mm / _CELLS
    goal, goal_features = _features(_cloud(target.vertices_mm, target.normals), cell_mm)
    for side in (1.0, -1.0):
        cloud, features = _features(_cloud(source.vertices_mm, side * source.normals), cell_mm)
        if min(len(cloud.points), len(goal.points)) > _DRAWN:
            yield from _drawn(cloud, goal, features, goal_features, cell_mm)


def _features(cloud: Any, cell_mm: float) -> tuple[Any, Any]:
    import open3d as o3d

    cells = cloud.voxel_down_sample(cell_mm)
    cells.normalize_normals()
    around = o3d.geometry.KDTreeSearchParamHybrid(_FEATURE_CELLS * cell_mm, _FEATURE_POINTS)
    registration: Any = o3d.pipelines.registration  # its stubs ask for an argument that has a default
    return cells, registration.compute_fpfh_feature(cells, around)


def _drawn(cloud: Any, goal: Any, features: Any, goal_features: Any, cell_mm: float) -> list[Floats]:
    import open3d as o3d

    registration = o3d.pipelines.registration
    o3d.utility.random.seed(_SEED)  # the same scan always comes to lie at the same place
    found = registration.registration_ransac_based_on_feature_matching(
        cloud, goal, features, goal_features, True, _NEAR_CELLS * cell_mm,
        registration.TransformationEstimationPointToPoint(False), _DRAWN,
        [
            registration.CorrespondenceCheckerBasedOnEdgeLength(_ALIKE),
            registration.CorrespondenceCheckerBasedOnDistance(_NEAR_CELLS * cell_mm),
        ],
        registration.RANSACConvergenceCriteria(_DRAWS, _SURE),
    )  # fmt: skip
    motion = np.asarray(found.transformation)
    rigid = np.allclose(motion[:3, :3] @ motion[:3, :3].T, np.eye(3), atol=1e-6)
    return [motion.copy()] if found.fitness > 0.0 and rigid else []


def _misfit(points: Any, goal: Any, motion: Floats, size_mm: float) -> float:
    """Mean distance of the points from the goal as a share of its size; far is far, and counts `_FAR`."""
    import open3d as o3d

    far_mm = _FAR * size_mm
    found = o3d.pipelines.registration.evaluate_registration(points, goal, far_mm, motion)
    return float(found.fitness * found.inlier_rmse / size_mm + (1.0 - found.fitness) * _FAR)


def _fine(
    points: Any, goal: Any, border: Bools, motion: Floats, size_mm: float, spacing_mm: float
) -> tuple[Placed | None, bool]:
    """Rounds of ICP, each within a reach and with a robust width that the round before gave; None: nothing opposite.

    And whether a step was ever longer than the reach of its pairs: then they did not hold it, and it went anywhere.
    """
    import open3d as o3d

    registration = o3d.pipelines.registration
    steps = registration.ICPConvergenceCriteria(1e-7, 1e-7, _STEPS)
    reach_mm, done, thrown = _REACH * size_mm, 0, False
    corners = np.asarray(points.get_axis_aligned_bounding_box().get_box_points())
    for done in range(1, _ROUNDS + 1):
        pairs = _pairs(points, goal, border, motion, reach_mm)
        if pairs is None:
            return None, thrown
        own, _, distance_mm, scale_mm = pairs
        kernel = registration.TukeyLoss(_TUKEY * scale_mm)
        before = motion
        motion = np.asarray(
            registration.registration_icp(
                points.select_by_index(own), goal, reach_mm, motion,
                registration.TransformationEstimationPointToPlane(kernel), steps,
            ).transformation
        ).copy()  # fmt: skip
        step_mm = _farthest(corners, before, motion)
        thrown |= step_mm > reach_mm
        reach_mm = max(3.0 * float(np.quantile(distance_mm, 0.8)), 2.0 * spacing_mm, 0.5 * reach_mm)
        if step_mm < _STILL_MM and done > 2:
            break
    pairs = _pairs(points, goal, border, motion, reach_mm)
    if pairs is None:
        return None, thrown
    return _placed(points, goal, motion, pairs[0], pairs[1], pairs[3], done), thrown


def _slowly(
    points: Any, goal: Any, border: Bools, motion: Floats, size_mm: float, spacing_mm: float
) -> Placed | None:
    """Damped steps (`damped_step`) with a width that falls from the reach to the heights' own; None as `_fine`.

    For surfaces that are flat but for a little of them: the median of their heights is that of the flat part, so that
    by their own width what stands up would never count, and nothing would hold the rest.
    """
    corners = np.asarray(points.get_axis_aligned_bounding_box().get_box_points())
    reach_mm, done = _REACH * size_mm, 0
    falling_mm = reach_mm / _TUKEY
    for done in range(1, _ROUNDS + 1):
        step_mm, scale_mm = 0.0, 0.0
        for _ in range(_STEPS):
            pairs = _pairs(points, goal, border, motion, reach_mm)
            if pairs is None:
                return None
            own, other, _, scale_mm = pairs
            width_mm = max(scale_mm, falling_mm)
            placed = _placed(points, goal, motion, own, other, width_mm, done)
            used = placed.weight > 0
            held = (x[used] for x in (placed.moved_mm, placed.height_mm, placed.normal, placed.weight))
            before, motion = motion, damped_step(*held, width_mm) @ motion
            step_mm = _farthest(corners, before, motion)
            if step_mm < _STILL_MM:
                break
        if step_mm < _STILL_MM and falling_mm < scale_mm:
            break
        reach_mm, falling_mm = max(0.5 * reach_mm, 2.0 * spacing_mm), 0.5 * falling_mm
    pairs = _pairs(points, goal, border, motion, reach_mm)
    return None if pairs is None else _placed(points, goal, motion, pairs[0], pairs[1], pairs[3], done)


def _farthest(corners: Floats, before: Floats, after: Floats) -> float:
    """How far corners (8, 3) of the source's box come to lie from where they were before, mm, along an axis."""
    return float(np.abs(corners @ (after - before)[:3, :3].T + (after - before)[:3, 3]).max())


def _pairs(
    points: Any, goal: Any, border: Bools, motion: Floats, reach_mm: float
) -> tuple[Ints, Ints, Floats, float] | None:
    """Which points have which of the goal's opposite, how far off, mm, and the robust width of their heights, mm."""
    import open3d as o3d

    found = o3d.pipelines.registration.evaluate_registration(points, goal, reach_mm, motion)
    own, other = np.asarray(found.correspondence_set, np.int64).reshape(-1, 2).T
    offset = (
        np.asarray(points.points)[own] @ motion[:3, :3].T + motion[:3, 3] - np.asarray(goal.points)[other]
    )
    normal = np.asarray(goal.normals)[other]
    along = (np.asarray(points.normals)[own] @ motion[:3, :3].T * normal).sum(axis=1)
    kept = ~border[other] & (np.abs(along) > _AGREE)
    if kept.sum() < _LEAST_SHARE * len(points.points):
        return None
    height = (offset * normal).sum(axis=1)[kept]
    scale_mm = 1.4826 * float(np.median(np.abs(height - np.median(height))))
    return own[kept], other[kept], np.linalg.norm(offset[kept], axis=1), max(scale_mm, 1e-3)


def _placed(
    points: Any, goal: Any, motion: Floats, own: Ints, other: Ints, scale_mm: float, rounds: int
) -> Placed:
    moved = np.asarray(points.points) @ motion[:3, :3].T + motion[:3, 3]
    weight, height, normal = np.zeros(len(moved)), np.zeros(len(moved)), np.zeros_like(moved)
    normal[own] = np.asarray(goal.normals)[other]
    height[own] = ((moved[own] - np.asarray(goal.points)[other]) * normal[own]).sum(axis=1)
    x = height[own] / (_TUKEY * scale_mm)
    weight[own] = np.where(np.abs(x) < 1.0, (1.0 - x**2) ** 2, 0.0)
    own_normal = np.asarray(points.normals) @ motion[:3, :3].T
    turned = bool((weight * (own_normal * normal).sum(axis=1)).sum() < 0.0)
    return Placed(motion, moved, weight, normal, height, own_normal, rounds, turned)
