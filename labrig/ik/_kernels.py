"""The loops of inverse kinematics, most of them compiled; imported when first used."""

import numpy as np
from numba import njit

from labrig.arrays import Floats

REACH = 0.4
"""How far a pressure may go in one step, as a share of its range."""


@njit(cache=True, fastmath=True)
def gather(net, first, weight, value, slope):
    """Points and derivatives from a control net that holds both.

    net (n, 3 (1 + C)): control points, each coordinate followed by its derivatives; for each of P points `first`
    (P, S) the rows of the net that bear on it and `weight` (P, S). Fills value (P, 3) and slope (P, 3, C).
    """
    width = net.shape[1]
    one = width // 3
    total = np.empty(width, net.dtype)
    for p in range(len(first)):
        w = weight[p, 0]
        row = net[first[p, 0]]
        for j in range(width):
            total[j] = w * row[j]
        for s in range(1, first.shape[1]):
            w = weight[p, s]
            row = net[first[p, s]]
            for j in range(width):
                total[j] += w * row[j]
        for d in range(3):
            value[p, d] = total[d * one]
            for k in range(one - 1):
                slope[p, d, k] = total[d * one + 1 + k]


@njit(cache=True, fastmath=True)
def combine(net, first, weight, out):
    """Weighted sums of whole rows: out (U, width) from net (n, width), `first` and `weight` (U, S)."""
    for u in range(len(first)):
        w = weight[u, 0]
        row, total = net[first[u, 0]], out[u]
        for j in range(net.shape[1]):
            total[j] = w * row[j]
        for s in range(1, first.shape[1]):
            w = weight[u, s]
            row = net[first[u, s]]
            for j in range(net.shape[1]):
                total[j] += w * row[j]


@njit(cache=True, fastmath=True)
def warp(value, slope, pull, table, affine, affine_slope, c, moved, moved_slope):
    """Points and derivatives after a warp whose coefficients and centers move with the actuation.

    For P points and C chambers, all about the warp's middle: value (P, 3); slope (P, 3, C); pull (P, 12): the bells'
    sums of coefficient times center (component, coordinate), then of the coefficients (3,); table (P, 12, C): what
    changes by itself (3, C), then what changes with the point (component, coordinate, C); affine (4, 3) and its
    derivative affine_slope (4, 3, C); c the bells' width. Fills moved (P, 3) and moved_slope (P, 3, C).
    """
    C = slope.shape[2]
    for p in range(len(value)):
        x, y, z = value[p, 0], value[p, 1], value[p, 2]
        for d in range(3):
            weighted = pull[p, 9 + d]
            moved[p, d] = affine[0, d] + affine[1, d] * x + affine[2, d] * y + affine[3, d] * z + weighted
            g0 = affine[1, d] - 2.0 * c * (weighted * x - pull[p, 3 * d])
            g1 = affine[2, d] - 2.0 * c * (weighted * y - pull[p, 3 * d + 1])
            g2 = affine[3, d] - 2.0 * c * (weighted * z - pull[p, 3 * d + 2])
            for k in range(C):
                moved_slope[p, d, k] = (
                    g0 * slope[p, 0, k]
                    + g1 * slope[p, 1, k]
                    + g2 * slope[p, 2, k]
                    + affine_slope[0, d, k]
                    + affine_slope[1, d, k] * x
                    + affine_slope[2, d, k] * y
                    + affine_slope[3, d, k] * z
                    + table[p, d, k]
                    + table[p, 3 + 3 * d, k] * x
                    + table[p, 4 + 3 * d, k] * y
                    + table[p, 5 + 3 * d, k] * z
                )


@njit(cache=True)
def pairs(
    points, rotation, translation, index, vertices, normals, inwardness, inward_slope,
    offset, plane, normal, usable, drift,
):  # fmt: skip
    """Offsets of points from their nearest target vertices, in the rig's frame.

    Target to rig: x -> rotation x + translation. Fills offset (P, 3), plane (P,) = normal . offset, normal (P, 3),
    usable (P,): 0 where the nearest vertex is on the border, rising to 1 away from it, so that no pair comes or goes at
    once; and drift (P, 3), by how much a pair becomes more usable as its point moves, 1/mm.
    """
    for p in range(len(points)):
        i = index[p]
        for d in range(3):
            foot, turned, rising = translation[d], 0.0, 0.0
            for e in range(3):
                foot += rotation[d, e] * vertices[i, e]
                turned += rotation[d, e] * normals[i, e]
                rising += rotation[d, e] * inward_slope[i, e]
            offset[p, d] = points[p, d] - foot
            normal[p, d] = turned
            drift[p, d] = rising
        plane[p] = normal[p, 0] * offset[p, 0] + normal[p, 1] * offset[p, 1] + normal[p, 2] * offset[p, 2]
        usable[p] = inwardness[i]


def median_of(plane: Floats, usable: Floats) -> float:
    """Median distance of the usable pairs, mm; 0 without any."""
    far = np.abs(plane[usable > 0])
    if not len(far):
        return 0.0
    half = len(far) // 2
    far.partition(half)  # np.median says the same, and takes four times as long
    return float(far[half] if len(far) % 2 else 0.5 * (far[half] + far[:half].max()))


@njit(cache=True)
def cost_of(offset, plane, usable, also, scale, sliding):
    """Mean robust cost per pair, mm^2 (Geman-McClure of width `scale`), tangential part times `sliding`.

    Pairs count that are usable here and `also` (P,) somewhere else.
    """
    total, count = 0.0, 0.0
    for p in range(len(plane)):
        weight = usable[p] * also[p]
        if weight > 0:
            square = offset[p, 0] ** 2 + offset[p, 1] ** 2 + offset[p, 2] ** 2
            error = plane[p] ** 2 + sliding * square
            total += weight * error / (1.0 + error / scale**2)
            count += weight
    return total / count if count > 0 else np.inf


@njit(cache=True, fastmath=True)
def _motion(along, slope, foot, row):
    """How a point's distance along a direction changes with pressures, rotation and translation, (C + 6,)."""
    C = slope.shape[1]
    a0, a1, a2 = along[0], along[1], along[2]
    for k in range(C):
        row[k] = a0 * slope[0, k] + a1 * slope[1, k] + a2 * slope[2, k]
    row[C] = -(foot[1] * a2 - foot[2] * a1)
    row[C + 1] = -(foot[2] * a0 - foot[0] * a2)
    row[C + 2] = -(foot[0] * a1 - foot[1] * a0)
    row[C + 3], row[C + 4], row[C + 5] = -a0, -a1, -a2


@njit(cache=True, fastmath=True)
def normal_equations(points, slope, offset, plane, normal, usable, scale, sliding, middle):
    """Normal matrix (C + 6, C + 6) and gradient of the robust cost by pressures, rotation, translation.

    The rotation is about `middle`; the motion is the target's: a foot f moves by w x (f - middle) + t.
    """
    n = slope.shape[2] + 6
    H = np.zeros((n, n))
    g = np.zeros(n)
    row = np.empty(n)
    foot, along = np.empty(3), np.empty(3)
    for p in range(len(plane)):
        if usable[p] <= 0:
            continue
        square = offset[p, 0] ** 2 + offset[p, 1] ** 2 + offset[p, 2] ** 2
        error = plane[p] ** 2 + sliding * square
        weight = usable[p] / (1.0 + error / scale**2) ** 2
        for d in range(3):
            foot[d] = points[p, d] - offset[p, d] - middle[d]
        for kind in range(4 if sliding > 0 else 1):
            for d in range(3):  # a copy of a slice would take longer to compile than all that is here
                along[d] = normal[p, d] if kind == 0 else (1.0 if d == kind - 1 else 0.0)
            r = plane[p] if kind == 0 else offset[p, kind - 1]
            w = weight if kind == 0 else weight * sliding
            _motion(along, slope[p], foot, row)
            for i in range(n):
                x = w * row[i]
                g[i] += x * r
                for j in range(i + 1):
                    H[i, j] += x * row[j]
    for i in range(n):
        for j in range(i):
            H[j, i] = H[i, j]
    return H, g


@njit(cache=True)
def mean_size(plane, usable, width, most):
    """Mean over the usable pairs of a size of their distance, mm, which is zero for a distance of zero.

    Below `width` it goes as the square; then it follows the distance; beyond `most`, where something foreign must be
    opposite, it hardly goes on.
    """
    total, count = 0.0, 0.0
    least = width / np.sqrt(1.0 + width**2 / most**2)
    for p in range(len(plane)):
        square = plane[p] ** 2 + width**2
        total += usable[p] * (np.sqrt(square / (1.0 + square / most**2)) - least)
        count += usable[p]
    return total / count if count > 0 else np.inf


@njit(cache=True, fastmath=True)
def mean_equations(points, slope, offset, plane, normal, usable, drift, width, most, middle):
    """Normal matrix and gradient, (C + 6), of `mean_size` by pressures, rotation and translation.

    The gradient is that of the mean itself: pairs that become more usable as their points move, or less, are in it.
    """
    n = slope.shape[2] + 6
    H = np.zeros((n, n))
    g = np.zeros(n)
    row = np.empty(n)
    foot = np.empty(3)
    count = usable.sum()
    mean = mean_size(plane, usable, width, most) + width / np.sqrt(1.0 + width**2 / most**2)
    for p in range(len(plane)):
        if usable[p] <= 0:
            continue
        for d in range(3):
            foot[d] = points[p, d] - offset[p, d] - middle[d]
        square = plane[p] ** 2 + width**2
        kept = 1.0 / (1.0 + square / most**2)
        size = np.sqrt(square * kept)
        _motion(normal[p], slope[p], foot, row)
        weight = usable[p] * kept * kept / size
        for i in range(n):
            x = weight * row[i]
            g[i] += x * plane[p]
            for j in range(i + 1):
                H[i, j] += x * row[j]
        if drift[p, 0] != 0.0 or drift[p, 1] != 0.0 or drift[p, 2] != 0.0:
            _motion(drift[p], slope[p], foot, row)
            for i in range(n):
                g[i] += (size - mean) * row[i]
    for i in range(n):
        for j in range(i):
            H[j, i] = H[i, j]
    return H / count, g / count


@njit(cache=True)
def bounded_step(H, g, damping, value, low, high):
    """The damped Newton step that keeps the first len(value) variables within [low, high] (active set).

    Chambers are damped alike, relative to their ranges, so that one that hardly moves anything does not run away; the
    step goes no farther than `REACH` of a range.
    """
    n, C = len(g), len(value)
    A = np.empty((n, n))
    step, most = np.zeros(n), 0.0
    free, index = np.empty(n, np.int64), np.empty(n, np.int64)
    for i in range(C):
        most = max(most, H[i, i] * (high[i] - low[i]) ** 2)
    for i in range(n):
        for j in range(n):
            A[i, j] = H[i, j]
        A[i, i] += 1e-12 + damping * (most / max(high[i] - low[i], 1e-9) ** 2 if i < C else H[i, i])
        free[i] = 1
        if i < C and ((value[i] <= low[i] and g[i] > 0) or (value[i] >= high[i] and g[i] < 0)):
            free[i] = 0
    for _ in range(C + 1):
        count = 0
        for i in range(n):
            if free[i]:
                index[count] = i
                count += 1
        _solve_free(A, g, index, count, free, step)
        again = False
        for i in range(C):
            reach = REACH * (high[i] - low[i])
            up, down = min(high[i] - value[i], reach), max(low[i] - value[i], -reach)
            if free[i] and (step[i] > up or step[i] < down):
                step[i] = up if step[i] > up else down
                free[i], again = 0, True
        if not again:
            break
    return step


@njit(cache=True)
def _solve_free(A, g, index, count, free, step):
    """Set the free entries of `step` so that A step = -g there, the others as they are (Cholesky).

    np.linalg.solve does the same, and takes five seconds to compile.
    """
    L, x = np.empty((count, count)), np.empty(count)
    for i in range(count):
        k = index[i]
        x[i] = -g[k]
        for j in range(len(step)):
            if not free[j]:
                x[i] -= A[k, j] * step[j]
        for j in range(i + 1):
            left = A[k, index[j]]
            for m in range(j):
                left -= L[i, m] * L[j, m]
            L[i, j] = np.sqrt(max(left, 1e-14 * A[k, k])) if i == j else left / L[j, j]
        for m in range(i):
            x[i] -= L[i, m] * x[m]
        x[i] /= L[i, i]
    for i in range(count - 1, -1, -1):
        for m in range(i + 1, count):
            x[i] -= L[m, i] * x[m]
        x[i] /= L[i, i]
        step[index[i]] = x[i]
