"""Rough registration of few points with few points, all starts at once: quick enough to try many."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from labrig.arrays import Floats

_TO_POINTS, _TO_PLANES = 3, 6
"""Steps of the starts that are improved."""


@njit(cache=True, fastmath=True)
def _nearest(x, y, z, cloud):
    best, at = np.inf, 0
    for j in range(cloud.shape[1]):
        a, b, c = cloud[0, j] - x, cloud[1, j] - y, cloud[2, j] - z
        square = a * a + b * b + c * c
        if square < best:
            best, at = square, j
    return at, best


@njit(cache=True)
def _match(points, R, t, cloud, moved, index, square):
    for k in range(len(R)):
        for p in range(len(points)):
            for d in range(3):
                moved[k, p, d] = t[k, d]
                for e in range(3):
                    moved[k, p, d] += R[k, d, e] * points[p, e]
            index[k, p], square[k, p] = _nearest(moved[k, p, 0], moved[k, p, 1], moved[k, p, 2], cloud)


def matched(points: Floats, R: Floats, t: Floats, cloud: Floats) -> tuple[Floats, NDArray[np.int64], Floats]:
    """Points (P, 3) moved by motions R (K, 3, 3), t (K, 3), and the nearest of `cloud` (3, N) to each.

    The moved points (K, P, 3), the numbers of the nearest (K, P), and the distances squared (K, P).
    """
    shape = len(R), len(points)
    moved, index, square = np.empty((*shape, 3)), np.empty(shape, np.int64), np.empty(shape)
    points, R, t, cloud = (np.ascontiguousarray(array) for array in (points, R, t, cloud))
    _match(points, R, t, cloud, moved, index, square)
    return moved, index, square


@dataclass(frozen=True)
class Rough:
    """Points (P, 3) with `normals` (P, 3) that are moved to a `cloud` (3, N) with its own (3, N), `size` mm large.

    Normals tell inside from outside where both have them (`oriented`).
    """

    points: Floats
    normals: Floats
    cloud: Floats
    cloud_normals: Floats
    size: float
    oriented: bool

    def try_starts(self, R: Floats, t: Floats, kept: int) -> tuple[Floats, Floats, Floats]:
        """Score every start, improve the best `kept`, and give these back: rotations, shifts, scores, best first."""
        best = np.argsort(self.score(R, t), kind="stable")[:kept]
        R, t = R[best], t[best]
        for _ in range(_TO_POINTS):
            R, t = self._to_points(*self._matched(R, t)[1:])
        for _ in range(_TO_PLANES):
            R, t = self._to_planes(R, t, *self._matched(R, t))
        cost = self.score(R, t)
        order = np.argsort(cost, kind="stable")
        return R[order], t[order], cost[order]

    def score(self, R: Floats, t: Floats, share: float = 0.9) -> Floats:
        """How badly motions fit, (K,): capped distances as a share of the size, and normals that disagree.

        The mean over the best `share` of the points.
        """
        _, index, square = self._matched(R, t)
        agreement = np.einsum("kpd,dkp->kp", self.normals @ R.swapaxes(1, 2), self.cloud_normals[:, index])
        agreement = agreement if self.oriented else np.abs(agreement)
        cost = np.minimum(np.sqrt(square) / self.size, 0.15) + 0.05 * (1.0 - agreement)
        cost.sort(axis=1)
        return cost[:, : max(1, int(share * cost.shape[1]))].mean(axis=1)

    def _matched(self, R: Floats, t: Floats) -> tuple[Floats, NDArray[np.int64], Floats]:
        return matched(self.points, R, t, self.cloud)

    def _to_points(self, index: NDArray[np.int64], square: Floats) -> tuple[Floats, Floats]:
        """The motions that bring points closest to their partners, far ones counting less (Kabsch)."""
        weight = 1.0 / (1.0 + square / (0.05 * self.size) ** 2)
        weight /= weight.sum(axis=1, keepdims=True)
        partner = np.moveaxis(self.cloud[:, index], 0, -1)
        a, b = weight @ self.points, np.einsum("kp,kpd->kd", weight, partner)
        weighed = weight[..., None] * (partner - b[:, None])
        U, _, Vt = np.linalg.svd(weighed.swapaxes(1, 2) @ (self.points - a[:, None]))
        U[:, :, 2] *= np.sign(np.linalg.det(U @ Vt))[:, None]
        R = U @ Vt
        return R, b - np.einsum("kde,ke->kd", R, a)

    def _to_planes(
        self, R: Floats, t: Floats, moved: Floats, index: NDArray[np.int64], square: Floats
    ) -> tuple[Floats, Floats]:
        """One step of point to plane with far pairs counting less."""
        middle = moved.mean(axis=1)
        partner, normal = (np.moveaxis(a[:, index], 0, -1) for a in (self.cloud, self.cloud_normals))
        row = np.concatenate([np.cross(moved - middle[:, None], normal), normal], axis=2)
        away = np.einsum("kpd,kpd->kp", moved - partner, normal)
        weighed = row / ((1.0 + square / (0.06 * self.size) ** 2) ** 2)[..., None]
        H = weighed.swapaxes(1, 2) @ row
        H += np.eye(6) * (1e-3 * H + 1e-12)
        step = -np.linalg.solve(H, np.einsum("kpa,kp->ka", weighed, away)[..., None])[..., 0]
        turn = Rotation.from_rotvec(step[:, :3]).as_matrix()
        return turn @ R, np.einsum("kde,ke->kd", turn, t - middle) + middle + step[:, 3:]
