"""Energy, gradient and banded second derivatives of a whole shell: one compiled loop over elements."""

import numpy as np

from labrig.physics._shell_terms import (
    IMPOSSIBLE,
    air,
    bending,
    foundation,
    interlayer,
    jit,
    membrane,
    weight,
)


@jit
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
    basis      (Q, N, 6)     value, two tangents, second derivatives 11, 22, 12
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
    size = count * 3
    point = np.zeros((count, 3, 3))
    bend = np.zeros((count, 3, 3))
    force = np.zeros((count, 3, 3))
    stiff = np.zeros((count, 3, count, 3, 3, 3))
    normal = np.zeros((count, 3))
    slope = np.zeros((count, 3, 2))
    moment = np.zeros((count, 3))
    curving = np.zeros((count, nodes, 3))
    local = np.zeros((nodes, count, 3))
    block = np.zeros((nodes * size, nodes * size))
    energy = 0.0
    for element in range(elements):
        for i in range(nodes):
            f = free[element, i]
            for layer in range(count):
                for c in range(3):
                    local[i, layer, c] = rest[node[element, i], c]
                    if f >= 0:
                        local[i, layer, c] += moved[(f * count + layer) * 3 + c]
        if curved:
            block[:] = 0.0
        for q in range(element * points_per_element, (element + 1) * points_per_element):
            w = area[q]
            point[:] = 0.0
            bend[:] = 0.0
            force[:] = 0.0
            if curved:
                stiff[:] = 0.0
            for i in range(nodes):
                for layer in range(count):
                    for c in range(3):
                        x = local[i, layer, c]
                        for k in range(3):
                            point[layer, k, c] += basis[q, i, k] * x
                            bend[layer, k, c] += basis[q, i, 3 + k] * x
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
                    density += air(layer, point, core, q, pressure[q, layer], curved, force, stiff)
                for i in range(nodes):
                    for r in range(3):
                        curving[layer, i, r] = (
                            basis[q, i, 3 + r]
                            - slope[layer, r, 0] * basis[q, i, 1]
                            - slope[layer, r, 1] * basis[q, i, 2]
                        )
            energy += w * density
            for i in range(nodes):
                f = free[element, i]
                if f < 0:
                    continue
                for layer in range(count):
                    m = (
                        moment[layer, 0] * curving[layer, i, 0]
                        + moment[layer, 1] * curving[layer, i, 1]
                        + moment[layer, 2] * curving[layer, i, 2]
                    )
                    for c in range(3):
                        gradient[(f * count + layer) * 3 + c] += w * (
                            basis[q, i, 0] * force[layer, 0, c]
                            + basis[q, i, 1] * force[layer, 1, c]
                            + basis[q, i, 2] * force[layer, 2, c]
                            + m * normal[layer, c]
                        )
            if curved:
                _spread(block, basis, q, w, stiff, curving, normal, layers, intact)
        if curved:
            _scatter(block, free, element, count, band)
    return energy


@jit
def _spread(block, basis, q, w, stiff, curving, normal, layers, intact):
    """Add one quadrature point to an element's second derivatives (lower triangle by control points).

    Bending enters as Gauss-Newton: curvature by curvature, without the moments' own share.
    """
    nodes, count = basis.shape[1], layers.shape[0]
    size = count * 3
    row = np.empty((count, 3, 3))
    for j in range(nodes):
        b0, b1, b2 = w * basis[q, j, 0], w * basis[q, j, 1], w * basis[q, j, 2]
        for m in range(count):
            rigid = layers[m, 1] ** 3 * layers[m, 0] / 6.0 * intact[q, m] * w
            k0, k1, k2 = curving[m, j, 0], curving[m, j, 1], curving[m, j, 2]
            r0, r1, r2 = rigid * (2.0 * k0 + k1), rigid * (k0 + 2.0 * k1), rigid * 2.0 * k2
            for b in range(3):
                for layer in range(count):
                    for alpha in range(3):
                        for a in range(3):
                            row[layer, alpha, a] = (
                                b0 * stiff[m, 0, layer, alpha, b, a]
                                + b1 * stiff[m, 1, layer, alpha, b, a]
                                + b2 * stiff[m, 2, layer, alpha, b, a]
                            )
                line = j * size + m * 3 + b
                nb = normal[m, b]
                for i in range(j, nodes):
                    c0, c1, c2 = basis[q, i, 0], basis[q, i, 1], basis[q, i, 2]
                    for layer in range(count):
                        for a in range(3):
                            block[line, i * size + layer * 3 + a] += (
                                c0 * row[layer, 0, a] + c1 * row[layer, 1, a] + c2 * row[layer, 2, a]
                            )
                    t = nb * (r0 * curving[m, i, 0] + r1 * curving[m, i, 1] + r2 * curving[m, i, 2])
                    for a in range(3):
                        block[line, i * size + m * 3 + a] += t * normal[m, a]


@jit
def _scatter(block, free, element, count, band):
    """Add an element's block to the band."""
    nodes = free.shape[1]
    size = count * 3
    for j in range(nodes):
        fj = free[element, j]
        if fj < 0:
            continue
        for b in range(size):
            column = fj * size + b
            for i in range(j, nodes):
                fi = free[element, i]
                if fi < 0:
                    continue
                offset = fi * size - column
                for a in range(b if i == j else 0, size):
                    band[column, offset + a] += block[j * size + b, i * size + a]
