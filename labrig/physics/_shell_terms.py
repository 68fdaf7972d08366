"""The energy of a shell at one quadrature point, one compiled kernel per term.

Every kernel adds its share of the energy density (kPa mm), of its derivatives `force[layer, alpha, xyz]` by the
position and its two tangents (alpha = 0, 1, 2), and, where `curved`, of the second derivatives
`stiff[layer, alpha, xyz, layer, beta, xyz]`. Tangents are derivatives along two orthonormal directions of the
resting surface, the second to the left of the first seen from outside, so that their cross product points outwards.

Arrays are passed whole and indexed, never sliced, and vectors are tuples: views and small arrays would cost more than
the arithmetic.
"""

import math

import numba

_OPTIONS = {"fastmath": True, "cache": True, "nogil": True, "error_model": "numpy"}
compiled = numba.njit(**_OPTIONS)
jit = numba.njit(**_OPTIONS, forceinline=True)
"""All but the outermost function are put into it: else which copy of them runs, and so the last bits of a result,
would depend on whether the code was compiled now or came from the cache."""

MODULUS, THICKNESS, STIFFENING, WEIGHT = range(4)
"""Columns of `layers`: shear modulus, kPa; thickness, mm; exponential stiffening; weight per area, kPa."""
SEAM, ADHESION, CONTACT = range(3)
"""Entries of `springs`: the seams between chambers, the tangential adhesion, contact; all kPa/mm."""

_LARGEST = 40.0
"""Strain invariant beyond which a trial shape is refused: its exponential would overflow a search."""
IMPOSSIBLE = 1e30


@jit
def gather(element, moved, rest, free, node, local):
    """Where an element's control points are now: `local` [layer, xyz, control point], see `assemble`."""
    count = local.shape[0]
    for i in range(free.shape[1]):
        f = free[element, i]
        for layer in range(count):
            for c in range(3):
                local[layer, c, i] = rest[node[element, i], c]
                if f >= 0:
                    local[layer, c, i] += moved[(f * count + layer) * 3 + c]


@jit
def locate(basis, q, local, point, bend):
    """Position, tangents and second derivatives of every layer at a quadrature point."""
    for layer in range(local.shape[0]):
        for c in range(3):
            for k in range(3):
                at, by = 0.0, 0.0
                for i in range(basis.shape[2]):
                    at += basis[q, k, i] * local[layer, c, i]
                    by += basis[q, 3 + k, i] * local[layer, c, i]
                point[layer, k, c] = at
                bend[layer, k, c] = by


@jit
def _row(a, i, j):
    """The vector a[i, j, :]."""
    return a[i, j, 0], a[i, j, 1], a[i, j, 2]


@jit
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@jit
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@jit
def _mix(p, a, q, b):
    """p a + q b."""
    return p * a[0] + q * b[0], p * a[1] + q * b[1], p * a[2] + q * b[2]


@jit
def _push(force, layer, alpha, scale, v):
    """Add `scale` v to a force."""
    force[layer, alpha, 0] += scale * v[0]
    force[layer, alpha, 1] += scale * v[1]
    force[layer, alpha, 2] += scale * v[2]


@jit
def _add_skew(stiff, la, alpha, lb, beta, scale, v):
    """Add `scale` [v]x to one block of the second derivatives and its transpose to the mirrored one."""
    x, y, z = scale * v[0], scale * v[1], scale * v[2]
    stiff[la, alpha, 0, lb, beta, 1] -= z
    stiff[la, alpha, 0, lb, beta, 2] += y
    stiff[la, alpha, 1, lb, beta, 0] += z
    stiff[la, alpha, 1, lb, beta, 2] -= x
    stiff[la, alpha, 2, lb, beta, 0] -= y
    stiff[la, alpha, 2, lb, beta, 1] += x
    stiff[lb, beta, 1, la, alpha, 0] -= z
    stiff[lb, beta, 2, la, alpha, 0] += y
    stiff[lb, beta, 0, la, alpha, 1] += z
    stiff[lb, beta, 2, la, alpha, 1] -= x
    stiff[lb, beta, 0, la, alpha, 2] -= y
    stiff[lb, beta, 1, la, alpha, 2] += x


@jit
def membrane(layer, point, layers, inner, q, intact, curved, convex, force, stiff):
    """In-plane stretch: incompressible neo-Hookean, stiffened exponentially (Fung).

    W = h mu / (2 k) (exp(k (I - 3)) - 1), I - 3 = tr C + 1 / det C - 3, with C the metric of the elastic part of
    the deformation: `inner[q, layer]` (3, 3) takes (C11, C22, C12) as measured to the elastic one, which is how
    pre-stretch and internal strains enter. `convex` clips compressive stress out of the geometric stiffness.
    """
    f1, f2 = _row(point, layer, 1), _row(point, layer, 2)
    metric = _dot(f1, f1), _dot(f2, f2), _dot(f1, f2)
    t1 = inner[q, layer, 0, 0], inner[q, layer, 0, 1], inner[q, layer, 0, 2]
    t2 = inner[q, layer, 1, 0], inner[q, layer, 1, 1], inner[q, layer, 1, 2]
    t3 = inner[q, layer, 2, 0], inner[q, layer, 2, 1], inner[q, layer, 2, 2]
    a11, a22, a12 = _dot(t1, metric), _dot(t2, metric), _dot(t3, metric)
    area = a11 * a22 - a12 * a12
    if area < 1e-6:
        return IMPOSSIBLE
    r = 1.0 / area
    invariant = a11 + a22 + r - 3.0
    if invariant > _LARGEST:
        return IMPOSSIBLE
    k = layers[layer, STIFFENING]
    rise = math.exp(k * invariant)
    scale = layers[layer, MODULUS] * layers[layer, THICKNESS] * intact
    energy = 0.5 * scale * (rise - 1.0) / k
    scale *= rise
    # Voigt derivatives by (a11, a22, a12); i.. is the inverse metric
    i11, i22, i12 = a22 * r, a11 * r, -a12 * r
    e1, e2, e3 = 0.5 * scale * (1.0 - r * i11), 0.5 * scale * (1.0 - r * i22), -scale * r * i12
    s11 = 2.0 * (t1[0] * e1 + t2[0] * e2 + t3[0] * e3)
    s22 = 2.0 * (t1[1] * e1 + t2[1] * e2 + t3[1] * e3)
    s12 = t1[2] * e1 + t2[2] * e2 + t3[2] * e3
    _push(force, layer, 1, 1.0, _mix(s11, f1, s12, f2))
    _push(force, layer, 2, 1.0, _mix(s12, f1, s22, f2))
    if not curved:
        return energy
    g = scale * r
    c11, c22, c12 = g * i11 * i11, g * i22 * i22, g * (i11 * i22 + i12 * i12) * 0.5
    c13, c23, c33 = (
        2.0 * g * i11 * i12,
        2.0 * g * i22 * i12,
        2.0 * g * i12 * i12 + g * (i11 * i22 + i12 * i12),
    )
    n = 2.0 * k / scale
    c11 += n * e1 * e1
    c22 += n * e2 * e2
    c12 += n * e1 * e2
    c13 += n * e1 * e3
    c23 += n * e2 * e3
    c33 += n * e3 * e3
    # d2W by the measured metric: transpose(t) c t, in the convention of the strain (dC11/2, dC22/2, dC12)
    u1 = _mix(1.0, _mix(c11, t1, c12, t2), c13, t3)
    u2 = _mix(1.0, _mix(c12, t1, c22, t2), c23, t3)
    u3 = _mix(1.0, _mix(c13, t1, c23, t2), c33, t3)
    d11 = 4.0 * (t1[0] * u1[0] + t2[0] * u2[0] + t3[0] * u3[0])
    d22 = 4.0 * (t1[1] * u1[1] + t2[1] * u2[1] + t3[1] * u3[1])
    d12 = 4.0 * (t1[0] * u1[1] + t2[0] * u2[1] + t3[0] * u3[1])
    d13 = 2.0 * (t1[0] * u1[2] + t2[0] * u2[2] + t3[0] * u3[2])
    d23 = 2.0 * (t1[1] * u1[2] + t2[1] * u2[2] + t3[1] * u3[2])
    d33 = t1[2] * u1[2] + t2[2] * u2[2] + t3[2] * u3[2]
    if convex:
        mean = 0.5 * (s11 + s22)
        spread = math.sqrt(0.25 * (s11 - s22) ** 2 + s12 * s12)
        low = mean - spread
        if low < 0.0:
            high = max(mean + spread, 0.0)
            part = high / (2.0 * spread) if spread > 1e-14 else 0.0
            s11, s22, s12 = part * (s11 - low), part * (s22 - low), part * s12
    for a in range(3):
        for b in range(3):
            p11, p12, p21, p22 = f1[a] * f1[b], f1[a] * f2[b], f2[a] * f1[b], f2[a] * f2[b]
            stiff[layer, 1, a, layer, 1, b] += d11 * p11 + d13 * (p12 + p21) + d33 * p22
            stiff[layer, 2, a, layer, 2, b] += d22 * p22 + d23 * (p12 + p21) + d33 * p11
            mixed = d12 * p12 + d13 * p11 + d23 * p22 + d33 * p21
            stiff[layer, 1, a, layer, 2, b] += mixed
            stiff[layer, 2, b, layer, 1, a] += mixed
        stiff[layer, 1, a, layer, 1, a] += s11
        stiff[layer, 2, a, layer, 2, a] += s22
        stiff[layer, 1, a, layer, 2, a] += s12
        stiff[layer, 2, a, layer, 1, a] += s12
    return energy


@jit
def bending(layer, point, bend, layers, rest_curvature, q, intact, normal, slope, moment):
    """Change of curvature (Kirchhoff-Love, plane stress, incompressible): mu h^3 / 12 (tr^2 + k : k).

    Leaves the unit normal, the Christoffel symbols `slope[layer]` (3, 2) that turn second derivatives of a
    displacement into changes of curvature, and the moments `moment[layer]` (3,): bending acts on second
    derivatives, so the assembly spreads it. `bend[layer, r]` are the second derivatives 11, 22, 12.
    """
    f1, f2 = _row(point, layer, 1), _row(point, layer, 2)
    m11, m22, m12 = _dot(f1, f1), _dot(f2, f2), _dot(f1, f2)
    r = 1.0 / (m11 * m22 - m12 * m12)
    across = _cross(f1, f2)
    length = math.sqrt(_dot(across, across))
    n = across[0] / length, across[1] / length, across[2] / length
    normal[layer, 0], normal[layer, 1], normal[layer, 2] = n
    for row in range(3):
        w = _row(bend, layer, row)
        moment[layer, row] = _dot(w, n) - rest_curvature[q, row]
        along1, along2 = _dot(w, f1), _dot(w, f2)
        slope[layer, row, 0] = r * (m22 * along1 - m12 * along2)
        slope[layer, row, 1] = r * (m11 * along2 - m12 * along1)
    k = moment[layer, 0], moment[layer, 1], moment[layer, 2]
    rigid = layers[layer, MODULUS] * layers[layer, THICKNESS] ** 3 / 6.0 * intact
    trace = k[0] + k[1]
    moment[layer, 0] = rigid * (trace + k[0])
    moment[layer, 1] = rigid * (trace + k[1])
    moment[layer, 2] = rigid * 2.0 * k[2]
    return 0.5 * rigid * (trace * trace + k[0] * k[0] + k[1] * k[1] + 2.0 * k[2] * k[2])


@jit
def weight(layer, point, layers, down, force):
    """Dead weight, -w (down . x)."""
    w = layers[layer, WEIGHT]
    along = 0.0
    for c in range(3):
        along += down[c] * point[layer, 0, c]
        force[layer, 0, c] -= w * down[c]
    return -w * along


@jit
def foundation(point, core, outward, q, seam, springs, curved, force, stiff):
    """Layer 1 on the core: the seams that hold it down, adhesion along the surface, one-sided contact.

    Half of `seam` |d|^2, of adhesion |d - (d.n) n|^2 and, where it sinks in, of contact (d.n)^2.
    """
    d = _mix(1.0, _row(point, 0, 0), -1.0, _row(core, q, 0))
    n = outward[q, 0], outward[q, 1], outward[q, 2]
    gap, square = _dot(d, n), _dot(d, d)
    adhesion = springs[ADHESION]
    across = (springs[CONTACT] if gap < 0.0 else 0.0) - adhesion
    along = seam + adhesion
    _push(force, 0, 0, 1.0, _mix(along, d, across * gap, n))
    if curved:
        for a in range(3):
            stiff[0, 0, a, 0, 0, a] += along
            for b in range(3):
                stiff[0, 0, a, 0, 0, b] += across * n[a] * n[b]
    return 0.5 * (along * square + across * gap * gap)


@jit
def interlayer(layer, point, outward, q, springs, curved, force, stiff):
    """Layer layer + 1 on the layer below it: adhesion along the surface and one-sided contact."""
    below = layer - 1
    n = outward[q, 0], outward[q, 1], outward[q, 2]
    d = _mix(1.0, _row(point, layer, 0), -1.0, _row(point, below, 0))
    gap, square = _dot(d, n), _dot(d, d)
    along = springs[ADHESION]
    across = (springs[CONTACT] if gap < 0.0 else 0.0) - along
    f = _mix(along, d, across * gap, n)
    _push(force, layer, 0, 1.0, f)
    _push(force, below, 0, -1.0, f)
    if curved:
        for a in range(3):
            for b in range(3):
                s = across * n[a] * n[b] + (along if a == b else 0.0)
                stiff[layer, 0, a, layer, 0, b] += s
                stiff[below, 0, a, below, 0, b] += s
                stiff[layer, 0, a, below, 0, b] -= s
                stiff[below, 0, a, layer, 0, b] -= s
    return 0.5 * (along * square + across * gap * gap)


@jit
def air(layer, point, core, q, pressure, force):
    """Pressure as a potential: -p V, V the exact volume of the ruled region between a chamber's two faces.

    Per area of the resting surface, V = d . (u1 x u2 / 3 + v1 x v2 / 3 + (u1 x v2 + v1 x u2) / 6), where u are the
    tangents of the lower face, v those of the upper one and d leads from one to the other. A follower load, whose
    second derivatives (`air_curved`) are nevertheless symmetric.
    """
    d, u1, u2, v1, v2 = _faces(layer, point, core, q)
    even = _mix(1.0, _cross(u1, u2), 1.0, _cross(v1, v2))
    mixed = _mix(1.0, _cross(u1, v2), 1.0, _cross(v1, u2))
    n = _mix(1.0 / 3.0, even, 1.0 / 6.0, mixed)
    a = _mix(1.0 / 3.0, v2, 1.0 / 6.0, u2)  # d n / d v1 = -[a]x
    b = _mix(1.0 / 3.0, v1, 1.0 / 6.0, u1)  # d n / d v2 = [b]x
    _push(force, layer, 0, -pressure, n)
    _push(force, layer, 1, -pressure, _cross(a, d))
    _push(force, layer, 2, -pressure, _cross(d, b))
    if layer > 0:
        k = layer - 1
        e = _mix(1.0 / 3.0, u2, 1.0 / 6.0, v2)  # the same by u1 and u2
        f = _mix(1.0 / 3.0, u1, 1.0 / 6.0, v1)
        _push(force, k, 0, pressure, n)
        _push(force, k, 1, -pressure, _cross(e, d))
        _push(force, k, 2, -pressure, _cross(d, f))
    return -pressure * _dot(d, n)


@jit
def air_curved(layer, point, core, q, pressure, stiff):
    """The second derivatives of `air`."""
    d, u1, u2, v1, v2 = _faces(layer, point, core, q)
    a, b = _mix(1.0 / 3.0, v2, 1.0 / 6.0, u2), _mix(1.0 / 3.0, v1, 1.0 / 6.0, u1)
    _add_skew(stiff, layer, 0, layer, 1, pressure, a)
    _add_skew(stiff, layer, 0, layer, 2, -pressure, b)
    _add_skew(stiff, layer, 1, layer, 2, pressure / 3.0, d)
    if layer == 0:
        return
    k = layer - 1
    e, f = _mix(1.0 / 3.0, u2, 1.0 / 6.0, v2), _mix(1.0 / 3.0, u1, 1.0 / 6.0, v1)
    _add_skew(stiff, layer, 0, k, 1, pressure, e)
    _add_skew(stiff, layer, 0, k, 2, -pressure, f)
    _add_skew(stiff, k, 0, k, 1, -pressure, e)
    _add_skew(stiff, k, 0, k, 2, pressure, f)
    _add_skew(stiff, k, 0, layer, 1, -pressure, a)
    _add_skew(stiff, k, 0, layer, 2, pressure, b)
    _add_skew(stiff, k, 1, k, 2, pressure / 3.0, d)
    _add_skew(stiff, k, 1, layer, 2, pressure / 6.0, d)
    _add_skew(stiff, layer, 1, k, 2, pressure / 6.0, d)


@jit
def _faces(layer, point, core, q):
    """What leads from the lower face of a chamber to the upper one, and the tangents of both."""
    if layer == 0:
        low, u1, u2 = _row(core, q, 0), _row(core, q, 1), _row(core, q, 2)
    else:
        low, u1, u2 = _row(point, layer - 1, 0), _row(point, layer - 1, 1), _row(point, layer - 1, 2)
    return _mix(1.0, _row(point, layer, 0), -1.0, low), u1, u2, _row(point, layer, 1), _row(point, layer, 2)
