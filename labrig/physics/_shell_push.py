"""The force of each chamber's air on a whole shell: one compiled loop over elements."""

import numpy as np

from labrig.physics._shell_terms import air, compiled, gather, jit, locate


@compiled
def push(moved, rest, free, node, basis, points_per_element, area, core, patch, layer_of, count, force_of):
    """Add the force of 1 kPa in each chamber to `force_of` (D, C), kPa mm^2.

    patch      (Q, C)        share of each chamber's pressure that bears on a quadrature point
    layer_of   (C,)          the layer that each chamber lies below, of `count`
    The rest as for `assemble`.
    """
    elements, nodes = node.shape
    chambers = patch.shape[1]
    point = np.zeros((count, 3, 3))
    bend = np.zeros((count, 3, 3))
    local = np.zeros((count, 3, nodes))
    force = np.zeros((count, 3, 3))
    pull = np.zeros((count, 3, nodes))
    for element in range(elements):
        gather(element, moved, rest, free, node, local)
        for q in range(element * points_per_element, (element + 1) * points_per_element):
            locate(basis, q, local, point, bend)
            for below in range(count):
                force[:] = 0.0
                air(below, point, core, q, area[q], force)
                _pull(basis, q, force, pull)
                for chamber in range(chambers):
                    if layer_of[chamber] == below and patch[q, chamber] > 0.0:
                        _add(free, element, -patch[q, chamber], pull, force_of, chamber)


@jit
def _pull(basis, q, force, pull):
    """What acts on position and tangents, as forces on an element's control points."""
    for layer in range(pull.shape[0]):
        for c in range(3):
            for i in range(basis.shape[2]):
                pull[layer, c, i] = (
                    basis[q, 0, i] * force[layer, 0, c]
                    + basis[q, 1, i] * force[layer, 1, c]
                    + basis[q, 2, i] * force[layer, 2, c]
                )


@jit
def _add(free, element, share, pull, force_of, chamber):
    """Add a share of the forces on an element's control points to those of a chamber."""
    count = pull.shape[0]
    for i in range(free.shape[1]):
        f = free[element, i]
        if f >= 0:
            for layer in range(count):
                for c in range(3):
                    force_of[(f * count + layer) * 3 + c, chamber] += share * pull[layer, c, i]
