"""Rough registration of few points with few points, compiled: quick enough to try many starts."""

import numpy as np
from numba import njit


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
def match(points, R, t, cloud, moved, index, square):
    """Move points (P, 3) and find the nearest of `cloud` (3, N) to each."""
    for p in range(len(points)):
        for d in range(3):
            moved[p, d] = R[d, 0] * points[p, 0] + R[d, 1] * points[p, 1] + R[d, 2] * points[p, 2] + t[d]
        index[p], square[p] = _nearest(moved[p, 0], moved[p, 1], moved[p, 2], cloud)


@njit(cache=True)
def score(R, normals, cloud_normals, index, square, size, oriented, share):
    """How badly a motion fits: capped distances as a share of the size, and normals that disagree.

    The mean over the best `share` of the points.
    """
    cost = np.empty(len(index))
    for p in range(len(index)):
        agreement = 0.0
        for d in range(3):
            turned = R[d, 0] * normals[p, 0] + R[d, 1] * normals[p, 1] + R[d, 2] * normals[p, 2]
            agreement += turned * cloud_normals[d, index[p]]
        agreement = agreement if oriented else abs(agreement)
        cost[p] = min(np.sqrt(square[p]) / size, 0.15) + 0.05 * (1.0 - agreement)
    cost.sort()
    return cost[: max(1, int(share * len(cost)))].mean()


@njit(cache=True)
def _turn(vector):
    angle = np.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    K = np.zeros((3, 3))
    K[0, 1], K[0, 2], K[1, 0] = -vector[2], vector[1], vector[2]
    K[1, 2], K[2, 0], K[2, 1] = -vector[0], -vector[1], vector[0]
    if angle < 1e-8:
        return np.eye(3) + K
    return np.eye(3) + np.sin(angle) / angle * K + (1.0 - np.cos(angle)) / angle**2 * (K @ K)


@njit(cache=True)
def _to_points(points, moved, index, square, cloud, size):
    """The motion that brings points closest to their partners, far ones counting less (Kabsch)."""
    a, b, total = np.zeros(3), np.zeros(3), 0.0
    weight = np.empty(len(points))
    for p in range(len(points)):
        weight[p] = 1.0 / (1.0 + square[p] / (0.05 * size) ** 2)
        total += weight[p]
        for d in range(3):
            a[d] += weight[p] * points[p, d]
            b[d] += weight[p] * cloud[d, index[p]]
    a /= total
    b /= total
    M = np.zeros((3, 3))
    for p in range(len(points)):
        for d in range(3):
            for e in range(3):
                M[d, e] += weight[p] * (cloud[d, index[p]] - b[d]) * (points[p, e] - a[e])
    U, _, Vt = np.linalg.svd(M)
    sign = np.eye(3)
    sign[2, 2] = np.sign(np.linalg.det(U @ Vt))
    R = U @ sign @ Vt
    return R, b - R @ a


@njit(cache=True)
def _to_planes(R, t, moved, index, square, cloud, cloud_normals, size):
    """One step of point to plane with far pairs counting less."""
    H, g, row = np.zeros((6, 6)), np.zeros(6), np.empty(6)
    middle = np.zeros(3)
    for p in range(len(moved)):
        for d in range(3):
            middle[d] += moved[p, d] / len(moved)
    for p in range(len(moved)):
        j = index[p]
        n0, n1, n2 = cloud_normals[0, j], cloud_normals[1, j], cloud_normals[2, j]
        x, y, z = moved[p, 0] - middle[0], moved[p, 1] - middle[1], moved[p, 2] - middle[2]
        row[0], row[1], row[2] = y * n2 - z * n1, z * n0 - x * n2, x * n1 - y * n0
        row[3], row[4], row[5] = n0, n1, n2
        r = (
            (moved[p, 0] - cloud[0, j]) * n0
            + (moved[p, 1] - cloud[1, j]) * n1
            + (moved[p, 2] - cloud[2, j]) * n2
        )
        w = 1.0 / (1.0 + square[p] / (0.06 * size) ** 2) ** 2
        for a in range(6):
            g[a] += w * row[a] * r
            for b in range(6):
                H[a, b] += w * row[a] * row[b]
    for a in range(6):
        H[a, a] += 1e-3 * H[a, a] + 1e-12
    step = -np.linalg.solve(H, g)
    turn = _turn(step[:3])
    return turn @ R, turn @ (t - middle) + middle + step[3:]


@njit(cache=True)
def rough_icp(points, normals, R, t, cloud, cloud_normals, size, oriented, to_points, to_planes, share):
    """Some steps to points, then to planes; returns rotation, translation and score (0 steps: the start's)."""
    count = len(points)
    moved, index, square = np.empty((count, 3)), np.empty(count, np.int64), np.empty(count)
    match(points, R, t, cloud, moved, index, square)
    for _ in range(to_points):
        R, t = _to_points(points, moved, index, square, cloud, size)
        match(points, R, t, cloud, moved, index, square)
    for _ in range(to_planes):
        R, t = _to_planes(R, t, moved, index, square, cloud, cloud_normals, size)
        match(points, R, t, cloud, moved, index, square)
    return R, t, score(R, normals, cloud_normals, index, square, size, oriented, share)


@njit(cache=True)
def try_starts(points, normals, rotations, shifts, cloud, cloud_normals, size, oriented, kept):
    """Score every start, improve the best `kept`, and give these back: rotations, shifts, scores, best first."""
    first = np.empty(len(rotations))
    for k in range(len(rotations)):
        _, _, first[k] = rough_icp(
            points, normals, rotations[k], shifts[k], cloud, cloud_normals, size, oriented, 0, 0, 0.9
        )
    chosen = np.argsort(first)[:kept]
    R, t, cost = np.empty((len(chosen), 3, 3)), np.empty((len(chosen), 3)), np.empty(len(chosen))
    for i in range(len(chosen)):
        k = chosen[i]
        R[i], t[i], cost[i] = rough_icp(
            points, normals, rotations[k], shifts[k], cloud, cloud_normals, size, oriented, 3, 6, 0.9
        )
    order = np.argsort(cost)
    return R[order], t[order], cost[order]
