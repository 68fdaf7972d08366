"""Energy, gradient and banded second derivatives of a whole shell: one compiled loop over elements."""

import numpy as np

from labrig.physics._shell_terms import (
    IMPOSSIBLE,
    MODULUS,
    THICKNESS,
    air,
    air_curved,
    bending,
    compiled,
    foundation,
    gather,
    interlayer,
    jit,
    locate,
    membrane,
    weight,
)


@compiled
def assemble(
    moved, rest, free, node, basis, area, points_per_element,
    core, outward, rest_curvature, pressure, seam, inner, intact,
    layers, springs, down, gradient, band, curved, convex,
):  # fmt: skip
    """Total energy, kPa mm^3; adds to `gradient` (D,) and, where `curved`, to `band` (D, bandwidth + 1).

    moved      (D,)          displacements of the free control points, mm: [control point, layer, xyz]
    rest       (K, 3)        control points of the resting surface, mm
    free       (E, N)        number of each element's control points among the free ones, or -1
    node       (E, N)        their numbers among all
    basis      (Q, 6, N)     value, two tangents, second derivatives 11, 22, 12
    area       (Q,)          of the resting surface, mm^2; quadrature points are ordered by element
    core       (Q, 3, 3)     position and tangents of the core
    outward    (Q, 3)        its normal
    rest_curvature (Q, 3)    11, 22, 12
    pressure   (Q, L)        below each layer, kPa
    seam       (Q,)          kPa/mm
    inner      (Q, L, 3, 3)  from the measured to the elastic metric
    intact     (Q, L)        what damage left of the stiffness, 0..1
    layers     (L, 4), springs (3,), down (3,)   see `_shell_terms`

    Row j of `band` is column j of the lower triangle from the diagonal on, so its transpose is LAPACK's.
    """
    elements, nodes = node.shape
    count = layers.shape[0]
    point = np.zeros((count, 3, 3))
    bend = np.zeros((count, 3, 3))
    force = np.zeros((count, 3, 3))
    stiff = np.zeros((count, 3, 3, count, 3, 3))
    normal = np.zeros((count, 3))
    slope = np.zeros((count, 3, 2))
    moment = np.zeros((count, 3))
    local = np.zeros((count, 3, nodes))
    pull = np.zeros((count, 3, nodes))
    curving = np.zeros((count, 3, nodes))
    block = np.zeros((count * 3, count * 3, nodes, nodes))
    side = np.zeros((3, nodes))
    energy = 0.0
    for element in range(elements):
        gather(element, moved, rest, free, node, local)
        pull[:] = 0.0
        if curved:
            block[:] = 0.0
        for q in range(element * points_per_element, (element + 1) * points_per_element):
            w = area[q]
            force[:] = 0.0
            if curved:
                stiff[:] = 0.0
            locate(basis, q, local, point, bend)
            density = 0.0
            for layer in range(count):
                density += membrane(
                    layer, point, layers, inner, q, intact[q, layer], curved, convex, force, stiff
                )
                if density >= IMPOSSIBLE:
                    return IMPOSSIBLE
                density += bending(
                    layer, point, bend, layers, rest_curvature, q, intact[q, layer], normal, slope, moment
                )
                density += weight(layer, point, layers, down, force)
                if layer == 0:
                    density += foundation(point, core, outward, q, seam[q], springs, curved, force, stiff)
                else:
                    density += interlayer(layer, point, outward, q, springs, curved, force, stiff)
                if pressure[q, layer] > 0.0:
                    density += air(layer, point, core, q, pressure[q, layer], force)
                    if curved:
                        air_curved(layer, point, core, q, pressure[q, layer], stiff)
            energy += w * density
            _pull(basis, q, w, force, slope, moment, normal, curving, pull)
            if curved:
                _spread(block, basis, q, w, stiff, curving, normal, layers, intact, side)
        for i in range(nodes):
            f = free[element, i]
            if f >= 0:
                for layer in range(count):
                    for c in range(3):
                        gradient[(f * count + layer) * 3 + c] += pull[layer, c, i]
        if curved:
            _scatter(block, free, element, count, band)
    return energy


@jit
def _pull(basis, q, w, force, slope, moment, normal, curving, pull):
    """Add one quadrature point to the forces on an element's control points; leaves how each of them curves it."""
    for layer in range(pull.shape[0]):
        m0, m1, m2 = w * moment[layer, 0], w * moment[layer, 1], w * moment[layer, 2]
        for i in range(basis.shape[2]):
            b0, b1, b2 = w * basis[q, 0, i], w * basis[q, 1, i], w * basis[q, 2, i]
            for r in range(3):
                curving[layer, r, i] = (
                    basis[q, 3 + r, i]
                    - slope[layer, r, 0] * basis[q, 1, i]
                    - slope[layer, r, 1] * basis[q, 2, i]
                )
            bent = m0 * curving[layer, 0, i] + m1 * curving[layer, 1, i] + m2 * curving[layer, 2, i]
            for c in range(3):
                pull[layer, c, i] += (
                    b0 * force[layer, 0, c]
                    + b1 * force[layer, 1, c]
                    + b2 * force[layer, 2, c]
                    + bent * normal[layer, c]
                )


@jit
def _spread(block, basis, q, w, stiff, curving, normal, layers, intact, side):
    """Add one quadrature point to an element's second derivatives: `block[s, t, j, i]` for s <= t, where s and t are
    layer and axis of the control points j and i; the rest is its mirror image. `side` (3, N) is room to work in.

    Bending enters as Gauss-Newton: curvature by curvature, without the moments' own share.
    """
    nodes, count = basis.shape[2], layers.shape[0]
    for m in range(count):
        for b in range(3):
            for layer in range(m, count):
                for a in range(b if layer == m else 0, 3):
                    for alpha in range(3):
                        h0 = w * stiff[m, alpha, b, layer, 0, a]
                        h1 = w * stiff[m, alpha, b, layer, 1, a]
                        h2 = w * stiff[m, alpha, b, layer, 2, a]
                        for i in range(nodes):
                            side[alpha, i] = h0 * basis[q, 0, i] + h1 * basis[q, 1, i] + h2 * basis[q, 2, i]
                    s, t = m * 3 + b, layer * 3 + a
                    for j in range(nodes):
                        c0, c1, c2 = basis[q, 0, j], basis[q, 1, j], basis[q, 2, j]
                        for i in range(nodes):
                            block[s, t, j, i] += c0 * side[0, i] + c1 * side[1, i] + c2 * side[2, i]
        rigid = w * layers[m, MODULUS] * layers[m, THICKNESS] ** 3 / 6.0 * intact[q, m]
        for i in range(nodes):
            k0, k1 = curving[m, 0, i], curving[m, 1, i]
            side[0, i] = rigid * (2.0 * k0 + k1)
            side[1, i] = rigid * (k0 + 2.0 * k1)
            side[2, i] = rigid * 2.0 * curving[m, 2, i]
        for b in range(3):
            for a in range(b, 3):
                n = normal[m, b] * normal[m, a]
                s, t = m * 3 + b, m * 3 + a
                for j in range(nodes):
                    c0, c1, c2 = n * curving[m, 0, j], n * curving[m, 1, j], n * curving[m, 2, j]
                    for i in range(nodes):
                        block[s, t, j, i] += c0 * side[0, i] + c1 * side[1, i] + c2 * side[2, i]


@jit
def _scatter(block, free, element, count, band):
    """Add an element's block to the band: its lower triangle."""
    nodes = free.shape[1]
    size = count * 3
    for j in range(nodes):
        fj = free[element, j]
        if fj < 0:
            continue
        for i in range(j, nodes):
            fi = free[element, i]
            if fi < 0:
                continue
            for s in range(size):
                offset = (fi - fj) * size - s
                for t in range(s if i == j else 0, size):
                    value = block[s, t, j, i] if s <= t else block[t, s, i, j]
                    band[fj * size + s, offset + t] += value
