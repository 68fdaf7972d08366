"""Rigid registration: a start that needs no guess, then robust point-to-plane ICP."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.surface._distance import distances
from labrig.surface._mesh import Mesh
from labrig.surface._nearest import Nearest
from labrig.surface._pose import angle_deg, cube_rotations, rotation_of, spread_rotations, upright_frames

COARSE = 200
"""Points on which starts are tried, against twice as many of the target."""
FINE = 6000
_SPARSE = 1500
"""Vertices in the tree from which nearest ones are sought along the surface."""
_SPREAD = 240
_KEPT = 8
_GOOD_SCORE = 0.04
_SAME_DEG = 12.0
_TUKEY = 4.685


class Target:
    """A surface made ready to be asked for nearest points again and again; `library` as of `Nearest`."""

    def __init__(self, mesh: Mesh, library: bool = True) -> None:
        self.mesh = mesh
        self._library = library

    @cached_property
    def nearest(self) -> Nearest:
        """A tree over all of its vertices."""
        return Nearest(self.mesh.vertices_mm, self._library)

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
        chosen = np.random.default_rng(0).permutation(count)[: 2 * COARSE]
        points, normals = self.mesh.vertices_mm[chosen], self.mesh.normals[chosen]
        return np.ascontiguousarray(points.T), np.ascontiguousarray(normals.T)

    def near(self, points_mm: Floats, index: NDArray[np.int64] | None = None) -> NDArray[np.int64]:
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
        return stride, Nearest(self.mesh.vertices_mm[::stride], self._library)


@dataclass(frozen=True)
class Registration:
    """How `source` was brought onto `target`: x -> rotation @ x + translation.

    `rms_mm`: point-to-plane distance of the pairs that count; `share`: how many of the source's points those are;
    `sd_mm`: standard deviation of the position that noise of `rms_mm` leaves, at the worst point of the source.
    """

    rotation: Floats
    translation_mm: Floats
    rms_mm: float
    share: float
    iterations: int
    sd_mm: float

    def apply(self, points_mm: Floats) -> Floats:
        """Points (..., 3) of the source in the target's frame."""
        return points_mm @ self.rotation.T + self.translation_mm


def thinned(mesh: Mesh, count: int) -> NDArray[np.int64]:
    """Indices of about `count` vertices, evenly over the surface: one of each voxel, borders left out of it."""
    inner = np.flatnonzero(~mesh.border) if not mesh.border.all() else np.arange(len(mesh.vertices_mm))
    if len(inner) <= count:
        return inner
    points = mesh.vertices_mm[inner]
    size = mesh.spacing_mm * np.sqrt(len(inner) / count)
    for _ in range(6):
        cell = np.floor((points - points.min(axis=0)) / size).astype(np.int64)
        extent = cell.max(axis=0) + 1
        _, first = np.unique(
            (cell[:, 0] * extent[1] + cell[:, 1]) * extent[2] + cell[:, 2], return_index=True
        )
        if 0.7 * count <= len(first) <= 1.3 * count:
            break
        size *= np.sqrt(len(first) / count)
    return inner[np.sort(first)]


def global_starts(
    points: Floats, normals: Floats, target: Target, oriented: bool = True
) -> list[tuple[Floats, Floats, float]]:
    """Motions (rotation, translation, score) that bring points (P, 3) near to a surface, from nowhere; best first.

    The principal axes of both, in every order and sign, are tried first; where none of them fits, rotations spread
    over all there are. `normals` (P, 3) tell inside from outside where both surfaces have them (`oriented`). The
    score is the mean distance as a share of the target's size, with normals that disagree counted in.
    """
    frame = upright_frames(target.mesh.vertices_mm) @ cube_rotations() @ upright_frames(points).T
    found = _improved(points, normals, target, frame, oriented)
    if found[0][2] > _GOOD_SCORE:
        found += _improved(points, normals, target, spread_rotations(_SPREAD), oriented)
        found.sort(key=lambda motion: motion[2])
    different: list[tuple[Floats, Floats, float]] = []
    for motion in found:
        if all(angle_deg(motion[0] @ other[0].T) > _SAME_DEG for other in different):
            different.append(motion)
    return different


def _improved(
    points: Floats, normals: Floats, target: Target, rotations: Floats, oriented: bool
) -> list[tuple[Floats, Floats, float]]:
    from labrig.surface._coarse import try_starts

    cloud, cloud_normals = target.few
    shifts = target.middle_mm - rotations @ points.mean(axis=0)
    R, t, cost = try_starts(
        np.ascontiguousarray(points), np.ascontiguousarray(normals), rotations, shifts, cloud, cloud_normals,
        target.size_mm, oriented, _KEPT,
    )  # fmt: skip
    return [(R[k], t[k], float(cost[k])) for k in range(len(cost))]


def start_score(points: Floats, normals: Floats, target: Target, oriented: bool = True) -> float:
    """The score, as of `global_starts`, of the better half of the points as they lie."""
    from labrig.surface._coarse import rough_icp

    cloud, cloud_normals = target.few
    where = np.ascontiguousarray(points), np.ascontiguousarray(normals), np.eye(3), np.zeros(3)
    return float(rough_icp(*where, cloud, cloud_normals, target.size_mm, oriented, 0, 0, 0.5)[2])


def _solve_plane(
    moved: Floats, feet: Floats, normal: Floats, weight: Floats, R: Floats, t: Floats
) -> tuple[Floats, Floats, Floats]:
    """One Gauss-Newton step of point to plane; returns the new motion and the normal matrix (6, 6)."""
    middle = moved.mean(axis=0)
    residual = np.einsum("pi,pi->p", moved - feet, normal)
    A = np.concatenate([np.cross(moved - middle, normal), normal], axis=1)
    H = (A * weight[:, None]).T @ A
    g = (A * weight[:, None]).T @ residual
    x = -np.linalg.solve(H + (1e-9 * np.trace(H) + 1e-12) * np.eye(6), g)  # all pairs may have no weight
    turn = rotation_of(x[:3])
    return turn @ R, turn @ (t - middle) + middle + x[3:], H


def register(
    source: Mesh,
    target: Mesh | Target,
    start: tuple[Floats, Floats] | None = None,
    iterations: int = 60,
    library: bool = True,
) -> Registration:
    """Bring `source` onto `target`: robust point-to-plane ICP after a global start, or after `start` (R, t).

    Pairs at the target's border and pairs that are far off for their number (Tukey's biweight) count less or not at
    all, so both may be partial, have holes, and hold points that belong to something else. Raises `LabrigError` when
    the two do not fit each other.
    """
    goal = target if isinstance(target, Target) else Target(target, library)
    chosen = thinned(source, FINE)
    points, normals = source.vertices_mm[chosen], source.normals[chosen]
    if start is None:
        coarse = np.linspace(0, len(points) - 1, min(COARSE, len(points))).astype(int)
        oriented = not (source.is_cloud or goal.mesh.is_cloud)
        R, t, _ = global_starts(points[coarse], normals[coarse], goal, oriented)[0]
    else:
        R, t = np.asarray(start[0], float), np.asarray(start[1], float)
    reach_mm, done = 0.1 * goal.size_mm, 0
    weight, residual, H = np.zeros(len(points)), np.zeros(len(points)), np.eye(6)
    for done in range(1, iterations + 1):
        moved = points @ R.T + t
        feet, normal, seen, off = _feet(moved, goal, exact=reach_mm < 4.0 * goal.mesh.spacing_mm)
        residual = np.einsum("pi,pi->p", moved - feet, normal)
        agrees = np.abs(np.einsum("pi,pi->p", normals @ R.T, normal)) > 0.4
        weight = _weights(residual, off, seen & agrees, reach_mm)
        if weight.sum() < 0.02 * len(points):
            raise LabrigError(
                "the scan and the surface do not fit each other: no part of one lies on the other"
            )
        last_R, last_t = R, t
        R, t, H = _solve_plane(moved, feet, normal, weight, R, t)
        step_mm = np.abs((points[:8] @ (R - last_R).T) + (t - last_t)).max()
        counted = np.abs(off[weight > 0])
        reach_mm = max(3.0 * float(np.quantile(counted, 0.8)), 2.0 * goal.mesh.spacing_mm, 0.5 * reach_mm)
        if step_mm < 1e-4 and done > 5:
            break
    rms = float(np.sqrt((weight * residual**2).sum() / weight.sum()))
    centred = points @ R.T + t
    centred = centred - centred.mean(axis=0)
    return Registration(R, t, rms, float((weight > 0).mean()), done, _worst_sd(centred, H, rms))


def _feet(moved: Floats, goal: Target, exact: bool) -> tuple[Floats, Floats, NDArray[np.bool_], Floats]:
    """Feet, normals, which pairs count, and distances: at vertices while far away, on triangles at the end."""
    if exact and not goal.mesh.is_cloud:
        found = distances(moved, goal.mesh, goal.nearest)
        index, _ = goal.nearest.one(found.feet_mm)
        return found.feet_mm, goal.mesh.normals[index], ~found.beyond, found.signed_mm
    index, square = goal.nearest.one(moved)
    return (
        goal.mesh.vertices_mm[index],
        goal.mesh.normals[index],
        ~goal.mesh.border[index],
        np.sqrt(square),
    )


def _weights(residual: Floats, off: Floats, usable: NDArray[np.bool_], reach_mm: float) -> Floats:
    usable = usable & (np.abs(off) < reach_mm)
    if not usable.any():
        return np.zeros(len(residual))
    inside = residual[usable]
    scale = 1.4826 * float(np.median(np.abs(inside - np.median(inside)))) + 1e-6
    x = residual / (_TUKEY * max(scale, 1e-3))
    return np.where(usable & (np.abs(x) < 1.0), (1.0 - x**2) ** 2, 0.0)


def _worst_sd(centred: Floats, H: Floats, rms: float) -> float:
    """The largest standard deviation of a point's position, mm, if the pairs' errors are independent."""
    covariance = np.linalg.pinv(H) * rms**2
    lever = np.zeros((len(centred), 3, 6))
    lever[:, 0, 1], lever[:, 0, 2] = centred[:, 2], -centred[:, 1]
    lever[:, 1, 0], lever[:, 1, 2] = -centred[:, 2], centred[:, 0]
    lever[:, 2, 0], lever[:, 2, 1] = centred[:, 1], -centred[:, 0]
    lever[:, :, 3:] = np.eye(3)
    variance = np.einsum("pij,jk,pik->p", lever, covariance, lever)
    return float(np.sqrt(variance.max()))
