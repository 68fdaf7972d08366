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
    curving = np.zeros((count, 3, nodes))
    local = np.zeros((nodes, count, 3))
    block = np.zeros((nodes, count, 3, count, 3, nodes))
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
                            point[layer, k, c] += basis[q, k, i] * x
                            bend[layer, k, c] += basis[q, 3 + k, i] * x
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
                        curving[layer, r, i] = (
                            basis[q, 3 + r, i]
                            - slope[layer, r, 0] * basis[q, 1, i]
                            - slope[layer, r, 1] * basis[q, 2, i]
                        )
            energy += w * density
            for i in range(nodes):
                f = free[element, i]
                if f < 0:
                    continue
                for layer in range(count):
                    m = (
                        moment[layer, 0] * curving[layer, 0, i]
                        + moment[layer, 1] * curving[layer, 1, i]
                        + moment[layer, 2] * curving[layer, 2, i]
                    )
                    for c in range(3):
                        gradient[(f * count + layer) * 3 + c] += w * (
                            basis[q, 0, i] * force[layer, 0, c]
                            + basis[q, 1, i] * force[layer, 1, c]
                            + basis[q, 2, i] * force[layer, 2, c]
                            + m * normal[layer, c]
                        )
            if curved:
                _spread(block, basis, q, w, stiff, curving, normal, layers, intact)
        if curved:
            _scatter(block, free, element, count, band)
    return energy


@jit
def _spread(block, basis, q, w, stiff, curving, normal, layers, intact):
    """Add one quadrature point to an element's second derivatives [point, layer, xyz, layer, xyz, point].

    The innermost loops run along arrays, over the second control point, so that they become vector instructions.
    Bending enters as Gauss-Newton: curvature by curvature, without the moments' own share.
    """
    nodes, count = basis.shape[2], layers.shape[0]
    row = np.empty((count, 3, 3))
    bent = np.empty(nodes)
    c0, c1, c2 = basis[q, 0], basis[q, 1], basis[q, 2]
    for j in range(nodes):
        b0, b1, b2 = w * c0[j], w * c1[j], w * c2[j]
        for m in range(count):
            rigid = layers[m, 1] ** 3 * layers[m, 0] / 6.0 * intact[q, m] * w
            k0, k1, k2 = curving[m, 0], curving[m, 1], curving[m, 2]
            r0, r1, r2 = rigid * (2.0 * k0[j] + k1[j]), rigid * (k0[j] + 2.0 * k1[j]), rigid * 2.0 * k2[j]
            for i in range(nodes):
                bent[i] = r0 * k0[i] + r1 * k1[i] + r2 * k2[i]
            for b in range(3):
                h0, h1, h2 = stiff[m, 0, b], stiff[m, 1, b], stiff[m, 2, b]
                for layer in range(count):
                    for beta in range(3):
                        for a in range(3):
                            row[layer, beta, a] = (
                                b0 * h0[layer, beta, a] + b1 * h1[layer, beta, a] + b2 * h2[layer, beta, a]
                            )
                for layer in range(count):
                    for a in range(3):
                        line = block[j, m, b, layer, a]
                        s0, s1, s2 = row[layer, 0, a], row[layer, 1, a], row[layer, 2, a]
                        s3 = normal[m, b] * normal[m, a] if layer == m else 0.0
                        for i in range(nodes):
                            line[i] += s0 * c0[i] + s1 * c1[i] + s2 * c2[i] + s3 * bent[i]


@jit
def _scatter(block, free, element, count, band):
    """Add an element's block to the band: its lower triangle."""
    nodes = free.shape[1]
    size = count * 3
    for j in range(nodes):
        fj = free[element, j]
        if fj < 0:
            continue
        for m in range(count):
            for b in range(3):
                column = fj * size + m * 3 + b
                for i in range(j, nodes):
                    fi = free[element, i]
                    if fi < 0:
                        continue
                    offset = fi * size - column
                    for layer in range(count):
                        for a in range(3):
                            if i > j or layer * 3 + a >= m * 3 + b:
                                band[column, offset + layer * 3 + a] += block[j, m, b, layer, a, i]
