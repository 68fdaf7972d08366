"""Surfaces as labrig handles them: B-splines over the unit square, meshes and scans, and what is done with them."""

from labrig.surface._distance import Distances, distances
from labrig.surface._kernels import vertex_normals
from labrig.surface._mesh import Mesh
from labrig.surface._nearest import Nearest
from labrig.surface._pose import rotation_of
from labrig.surface._registration import Registration, register
from labrig.surface._scan import clean, read_mesh
from labrig.surface._spline import Spline, grid
from labrig.surface._target import Target
from labrig.surface._warp import (
    SLACK,
    Warp,
    bells,
    design,
    identity_coefficients,
    interpolation_matrix,
)

__all__ = [
    "SLACK",
    "Distances",
    "Mesh",
    "Nearest",
    "Registration",
    "Spline",
    "Target",
    "Warp",
    "bells",
    "clean",
    "design",
    "distances",
    "grid",
    "identity_coefficients",
    "interpolation_matrix",
    "read_mesh",
    "register",
    "rotation_of",
    "vertex_normals",
]
