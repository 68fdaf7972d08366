"""Loops over meshes, compiled; imported when first used."""

import numpy as np
from numba import njit


@njit(cache=True)
def extent(points):
    """Lowest and highest coordinates and the mean of points (V, 3), (3,) each."""
    low, high, mean = np.full(3, np.inf), np.full(3, -np.inf), np.zeros(3)
    for v in range(len(points)):
        for d in range(3):
            x = points[v, d]
            low[d], high[d] = min(low[d], x), max(high[d], x)
            mean[d] += x
    return low, high, mean / len(points)


@njit(cache=True)
def vertex_normals(vertices, triangles):
    """Unit normals at the vertices, (V, 3), weighted by the areas around; zero at loose vertices."""
    normal = np.zeros_like(vertices)
    for t in range(len(triangles)):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        x0 = vertices[b, 0] - vertices[a, 0]
        x1 = vertices[b, 1] - vertices[a, 1]
        x2 = vertices[b, 2] - vertices[a, 2]
        y0 = vertices[c, 0] - vertices[a, 0]
        y1 = vertices[c, 1] - vertices[a, 1]
        y2 = vertices[c, 2] - vertices[a, 2]
        n0, n1, n2 = x1 * y2 - x2 * y1, x2 * y0 - x0 * y2, x0 * y1 - x1 * y0
        for corner in (a, b, c):
            normal[corner, 0] += n0
            normal[corner, 1] += n1
            normal[corner, 2] += n2
    for v in range(len(normal)):
        length = np.sqrt(normal[v, 0] ** 2 + normal[v, 1] ** 2 + normal[v, 2] ** 2)
        if length > 0:
            for k in range(3):
                normal[v, k] /= length
    return normal


@njit(cache=True)
def _marks(count):
    """Pseudo-random odd numbers, one a vertex (splitmix64)."""
    out = np.empty(count, np.uint64)
    state = np.uint64(0x9E3779B97F4A7C15)
    step = np.uint64(0x9E3779B97F4A7C15)
    for i in range(count):
        state += step
        z = state
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        out[i] = (z ^ (z >> np.uint64(31))) | np.uint64(1)
    return out


@njit(cache=True)
def border_vertices(count, triangles):
    """Which vertices have an edge with one triangle only, (V,).

    Around an inner vertex every neighbour comes once as the next corner and once as the one before, so the sum of
    random marks, next minus before, is zero; at a border it is not (but for one chance in 2**63).
    """
    mark = _marks(count)
    total = np.zeros(count, np.uint64)
    for t in range(len(triangles)):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        total[a] += mark[b] - mark[c]
        total[b] += mark[c] - mark[a]
        total[c] += mark[a] - mark[b]
    return total != 0


@njit(cache=True)
def rings_from_border(border, triangles, start, around, most):
    """How many edges each vertex is away from the border, (V,), `most` at most; see `triangles_around`."""
    ring, reached = np.empty(len(border), np.int64), np.empty(len(border), np.int64)
    count = 0
    for v in range(len(border)):
        ring[v] = 0 if border[v] else most
        if border[v]:
            reached[count] = v
            count += 1
    at = 0
    while at < count:
        v = reached[at]
        at += 1
        if ring[v] + 1 >= most:
            break
        for s in range(start[v], start[v + 1]):
            for k in range(3):
                other = triangles[around[s], k]
                if ring[other] > ring[v] + 1:
                    ring[other] = ring[v] + 1
                    reached[count] = other
                    count += 1
    return ring


@njit(cache=True)
def slope_along(vertices, triangles, values):
    """How values (V,) at the vertices rise along the surface, (V, 3), per mm: the mean of the triangles around."""
    slope = np.zeros_like(vertices)
    around = np.zeros(len(vertices))
    total = np.empty(3)
    for t in range(len(triangles)):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        for corner in (a, b, c):
            around[corner] += 1.0
        if values[a] == values[b] and values[b] == values[c]:
            continue
        n = _cross(_minus(_row(vertices, b), _row(vertices, a)), _minus(_row(vertices, c), _row(vertices, a)))
        square = _dot(n, n)
        if square <= 0.0:
            continue
        total[:] = 0.0
        for one, following, last in ((a, b, c), (b, c, a), (c, a, b)):
            across = _cross(n, _minus(_row(vertices, last), _row(vertices, following)))
            for d in range(3):
                total[d] += values[one] * across[d] / square
        for corner in (a, b, c):
            for d in range(3):
                slope[corner, d] += total[d]
    for v in range(len(slope)):
        for d in range(3):
            slope[v, d] /= max(around[v], 1.0)
    return slope


@njit(cache=True)
def walk_to_nearest(points, index, vertices, triangles, start, around):
    """The vertices nearest to points (P, 3), sought along the surface from others (P,) that are not far from them."""
    found = np.empty(len(points), np.int64)
    for p in range(len(points)):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        at, best, least = -1, index[p], np.inf
        while at != best:
            at = best
            for s in range(start[at], start[at + 1]):
                for k in range(3):
                    v = triangles[around[s], k]
                    a, b, c = vertices[v, 0] - x, vertices[v, 1] - y, vertices[v, 2] - z
                    square = a * a + b * b + c * c
                    if square < least:
                        least, best = square, v
        found[p] = best
    return found


@njit(cache=True, inline="always")
def _row(array, i):
    return (array[i, 0], array[i, 1], array[i, 2])


@njit(cache=True, inline="always")
def _minus(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@njit(cache=True, inline="always")
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, inline="always")
def _cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@njit(cache=True)
def _closest_on_triangle(ab, ac, ap):
    """Where a triangle is nearest to a point, as shares of its edges ab and ac (Ericson 2005, 5.1.5)."""
    d1, d2 = _dot(ab, ap), _dot(ac, ap)
    if d1 <= 0 and d2 <= 0:
        return 0.0, 0.0
    bp = _minus(ap, ab)
    d3, d4 = _dot(ab, bp), _dot(ac, bp)
    if d3 >= 0 and d4 <= d3:
        return 1.0, 0.0
    vc = d1 * d4 - d3 * d2
    if vc <= 0 and d1 >= 0 and d3 <= 0:
        return d1 / (d1 - d3), 0.0
    cp = _minus(ap, ac)
    d5, d6 = _dot(ab, cp), _dot(ac, cp)
    if d6 >= 0 and d5 <= d6:
        return 0.0, 1.0
    vb = d5 * d2 - d1 * d6
    if vb <= 0 and d2 >= 0 and d6 <= 0:
        return 0.0, d2 / (d2 - d6)
    va = d3 * d6 - d5 * d4
    if va <= 0 and d4 - d3 >= 0 and d5 - d6 >= 0:
        share = (d4 - d3) / (d4 - d3 + d5 - d6)
        return 1.0 - share, share
    scale = 1.0 / (va + vb + vc)
    return vb * scale, vc * scale


@njit(cache=True)
def closest_points(points, candidates, vertices, triangles, start, around, normals, border):
    """Nearest points of a mesh among the triangles around candidate vertices.

    points (P, 3); candidates (P, k) vertices; `around[start[v]:start[v + 1]]` the triangles of vertex v. Returns feet
    (P, 3), signed distances (P,) (positive on the side of the normals), and whether the foot lies on the border (P,).
    """
    feet = np.zeros_like(points)
    signed = np.full(len(points), np.inf)
    beyond = np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        p = _row(points, i)
        best, nearest, x, y = np.inf, -1, 0.0, 0.0
        for j in range(candidates.shape[1]):
            v = candidates[i, j]
            for s in range(start[v], start[v + 1]):
                t = around[s]
                a = _row(vertices, triangles[t, 0])
                ab = _minus(_row(vertices, triangles[t, 1]), a)
                ac = _minus(_row(vertices, triangles[t, 2]), a)
                ap = _minus(p, a)
                along, across = _closest_on_triangle(ab, ac, ap)
                d0 = ap[0] - along * ab[0] - across * ac[0]
                d1 = ap[1] - along * ab[1] - across * ac[1]
                d2 = ap[2] - along * ab[2] - across * ac[2]
                square = d0 * d0 + d1 * d1 + d2 * d2
                if square < best:
                    best, nearest, x, y = square, t, along, across
        if nearest < 0:
            continue
        i0, i1, i2 = triangles[nearest, 0], triangles[nearest, 1], triangles[nearest, 2]
        share = (1.0 - x - y, x, y)
        for k in range(3):
            feet[i, k] = share[0] * vertices[i0, k] + share[1] * vertices[i1, k] + share[2] * vertices[i2, k]
        # on an edge a flat triangle's own normal may give the wrong sign: the vertices' normals do not
        side = 0.0
        for k in range(3):
            normal = share[0] * normals[i0, k] + share[1] * normals[i1, k] + share[2] * normals[i2, k]
            side += (points[i, k] - feet[i, k]) * normal
        signed[i] = np.sqrt(best) if side >= 0 else -np.sqrt(best)
        inner = 0  # corners that are not of the border and have a share in the foot
        for corner, weight in ((i0, share[0]), (i1, share[1]), (i2, share[2])):
            if weight > 1e-9 and not border[corner]:
                inner += 1
        on_edge = min(share[0], min(share[1], share[2])) <= 1e-9
        beyond[i] = on_edge and inner == 0
    return feet, signed, beyond


@njit(cache=True)
def triangles_around(count, triangles):
    """Which triangles each vertex belongs to, as (start (V + 1,), list)."""
    start = np.zeros(count + 1, np.int64)
    for t in range(len(triangles)):
        for k in range(3):
            start[triangles[t, k] + 1] += 1
    for v in range(count):
        start[v + 1] += start[v]
    place = start[:-1].copy()
    around = np.empty(3 * len(triangles), np.int64)
    for t in range(len(triangles)):
        for k in range(3):
            v = triangles[t, k]
            around[place[v]] = t
            place[v] += 1
    return start, around
