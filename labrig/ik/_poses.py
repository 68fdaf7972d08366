"""Where to begin: how the target may lie, and at which pressures the surface looks most like it."""

import numpy as np

from labrig.arrays import Floats
from labrig.surface import Mesh, Target
from labrig.surface._starts import COARSE, global_starts, start_score

NEAR = 0.06
"""Score up to which the pose that the target has is a good one to begin with."""
POSES = 5
SHAPES = 16


def lies_near(shape: Mesh, goal: Target) -> bool:
    """Whether the target lies where the surface is, more or less; either side of it may be the outside.

    Either may be a part of the other: the surface lies on the target, or the target on the surface.
    """
    if start_score(*_few(shape), goal, False) < NEAR:
        return True
    points, normals = goal.few
    return start_score(points[:, ::2].T, normals[:, ::2].T, Target(shape), False) < NEAR


def likeliest(
    shapes: list[tuple[Floats, Mesh]], goal: Target, oriented: bool = True
) -> list[tuple[float, Floats, Floats, Floats]]:
    """The best starts of a global search with these actuations' surfaces, best first.

    Each: score, rotation and translation from the rig to the target, pressures. Without `oriented` a mesh's triangles
    may face inwards.
    """
    found = []
    for pressure, shape in shapes:
        starts = global_starts(*_few(shape), goal, oriented and not goal.mesh.is_cloud)
        found += [(score, R, t, pressure) for R, t, score in starts]
    return sorted(found, key=lambda start: start[0])[:POSES]


def spread_actuations(low: Floats, high: Floats) -> Floats:
    """Some actuations all over the range, (SHAPES, C)."""
    shares = np.random.default_rng(0).random((SHAPES, len(low)))
    return low + shares * (high - low)


def _few(shape: Mesh) -> tuple[Floats, Floats]:
    chosen = np.linspace(0, len(shape.vertices_mm) - 1, COARSE).astype(int)
    return shape.vertices_mm[chosen], shape.normals[chosen]
