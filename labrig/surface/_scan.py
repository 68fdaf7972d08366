"""Scan files read from any export of a scanner: their unit, and what is no part of the surface."""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.surface._aside import call
from labrig.surface._mesh import Mesh

_SIZES_MM = (30.0, 5000.0)
"""Sizes that a person's surface can have: what a file's unit is guessed from where no model is there to compare."""
_FACTOR = 20.0
"""The unit that brings a file within this factor of the model's size is taken for its own; it may be a part of it."""
_LEAST_POINTS, _LEAST_TRIANGLES = 20, 8
_LOOKED_AT = 2000
"""So many points tell whether they are a line, about."""
_HALVINGS = (2, 7)
"""Distances at which it is looked for a line: from a quarter of the size down, each half of the one before."""
_COMPANY = 2.0
"""Others around a point, on average, from which on their number says something."""
_LINE = 1.25
"""A dimension no larger than this is a line's (1), and not a surface's (2); a strip comes to more from near."""


def read_mesh(path: str | Path, unit: str | None = None, like_mm: float | None = None) -> Mesh:
    """Read an OBJ, PLY, STL or XYZ file as Artec Studio and others export it, and clean it.

    `unit` (mm, cm, m, inch) is that of the file; left out, it is what a PLY says of itself (`comment unit mm`), or
    mm or m, whichever comes near to the model's size, `like_mm` (diagonal of its box), or without a model to a
    person's. The mesh's notes say what was guessed and cleaned. Raises `LabrigError`, in one line, for a file that is
    missing, damaged, of another kind, or of no clear size, and without the extra `scan`.
    """
    from labrig_drivers._artec_files import MM_PER_UNIT, ScanFileError, declared_unit, parse, read_set

    path = Path(path)
    if unit is not None and unit not in MM_PER_UNIT:
        raise LabrigError(f"unit {unit!r}: choose one of {', '.join(MM_PER_UNIT)}")
    try:
        data, _ = read_set((path,))  # colours and textures may be missing
        geometry = parse(data, path.name)
    except ScanFileError as error:
        raise LabrigError(f"{path.parent / str(error)}") from None
    except OSError as error:
        raise LabrigError(f"cannot read {path}: {error.strerror or error}") from None
    known, note = unit or declared_unit(data), ()
    if known is None:
        size = float(np.linalg.norm(np.ptp(geometry.vertices, axis=0)))
        known = _likely_unit(size, like_mm, path)
        if known != "mm":
            note = (f"{path.name} is {size:.3g} across and does not say its unit: taken for {known}",)
    mesh = clean(geometry.vertices * MM_PER_UNIT[known], geometry.triangles, str(path), like_mm)
    return Mesh(mesh.vertices_mm, mesh.triangles, note + mesh.notes)


def _likely_unit(size: float, like_mm: float | None, path: Path) -> str:
    """mm or m, whichever makes a size near to the model's, or to a person's where there is no model."""
    low, high = _SIZES_MM if like_mm is None else (like_mm / _FACTOR, like_mm * _FACTOR)
    for unit, in_mm in (("mm", size), ("m", 1000.0 * size)):
        if low <= in_mm <= high:
            return unit
    what = "no size for a surface" if like_mm is None else f"not near to the model's {like_mm:.3g} mm"
    raise LabrigError(f"{path} is {size:.3g} across, in mm or in m {what}: say its unit (--unit)")


def clean(
    vertices_mm: ArrayLike, triangles: ArrayLike, name: str = "mesh", like_mm: float | None = None
) -> Mesh:
    """Weld seams; drop loose fragments and outliers; close small holes; wind all triangles the same way round.

    With the size of the model, `like_mm`, a plane on which the object stands is cut away. The mesh's notes say what was
    done. Raises `LabrigError` when nothing is left that could be a surface, such as points along a line, straight or
    bent, and without the extra `scan`.
    """
    from labrig_drivers._artec_files import weld

    vertices, corners = np.asarray(vertices_mm, float), np.asarray(triangles, np.int64).reshape(-1, 3)
    if len(corners) == 0:
        points, notes = call("tidy_cloud", vertices, like_mm) if len(vertices) else (vertices, ())
        if len(points) < _LEAST_POINTS:
            raise LabrigError(f"{name}: has {len(points)} different points, which is no surface")
        if _is_line(points):
            raise LabrigError(
                f"{name}: its points lie along a line, which is no surface: export points all over it, or its mesh"
            )
        return Mesh(points, np.zeros((0, 3), np.int64), notes)
    welded = weld(vertices, corners)
    vertices, corners, notes = welded.vertices, welded.triangles, ()
    if len(corners):
        vertices, corners, notes = call("tidy_mesh", vertices, corners, like_mm)
    if len(corners) < _LEAST_TRIANGLES:
        raise LabrigError(f"{name}: has {len(corners)} triangles with an area, which is no surface")
    return Mesh(vertices, corners, notes)


def _is_line(points: Floats) -> bool:
    """Whether points (N, 3) lie along a line, straight or bent, however near one looks.

    Around a point of a line there are twice as many others within twice the distance, on a surface four times as many:
    2 to the power of the correlation dimension (Grassberger, Procaccia, Measuring the strangeness of strange
    attractors, 1983). Rows of points far from each other are a surface to who stands far enough away.
    """
    from scipy.spatial import KDTree

    some = points[:: max(1, len(points) // _LOOKED_AT)]
    size_mm = float(np.linalg.norm(np.ptp(some, axis=0)))
    tree = KDTree(some)
    reach_mm = size_mm * 0.5 ** np.arange(*_HALVINGS)
    others = tree.count_neighbors(tree, reach_mm).astype(float) / len(some) - 1.0
    near, far = others[1:], others[:-1]
    enough = near >= _COMPANY
    return bool(enough.any() and (np.log2(far[enough] / near[enough]) < _LINE).all())
