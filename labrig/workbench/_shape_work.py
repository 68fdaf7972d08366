"""What the worker computes of shapes: a target's size, a model's limits, and the picture of the two. Plain values."""

from pathlib import Path
from typing import Any

from labrig._errors import LabrigError
from labrig.shape_contents import SolvedTarget
from labrig.workbench._answers import told

_MOST_TRIANGLES = 30_000
"""A target with more of them is drawn with evenly many left out."""


def size_of(path: str) -> str:
    """What a target's file holds, in words; raises `LabrigError` where it cannot be read."""
    import numpy as np

    from labrig_drivers._artec_files import ScanFileError, declared_unit, parse, read_set

    file = Path(path)
    try:
        data, _ = read_set((file,))
        geometry = parse(data, file.name)
    except ScanFileError as error:
        raise LabrigError(str(error)) from None
    across, unit = float(np.linalg.norm(np.ptp(geometry.vertices, axis=0))), declared_unit(data)
    count = len(geometry.triangles)
    what = f"{count} triangles" if count else f"{len(geometry.vertices)} points"
    return f"{what}, {across:.3g} {unit or '(of no stated unit)'} across"


def limits_of(model: str, rig: str) -> dict[str, Any]:
    """The chambers of a model with the limits, kPa, that a search keeps to: the `rig` file's, or without one its own.

    Raises `LabrigError` for a model without a surface, or a rig of other chambers.
    """
    from labrig.api._ik import limits_kpa
    from labrig.ik import load_shape_model

    shape, _ = load_shape_model(model)
    try:
        low, high = limits_kpa(rig, model) if rig else (shape.low_kpa, shape.high_kpa)
    except LabrigError as error:
        raise LabrigError(f"{error}; choose another model, or its own limits") from None
    rows = zip(shape.chamber_names, low, high, strict=True)
    return {"chambers": [[name, float(least), float(most)] for name, least, most in rows]}


def picture_of(entry: SolvedTarget, model: str, folder: str) -> str:
    """A solved target and the surface that comes near to it, as figures in JSON: the target, the surface in colours of
    its signed distance, and how these distances are spread.
    """
    from labrig.ik import placed
    from labrig.view import target_figures

    return told(target_figures(placed(entry, model, Path(folder)), _MOST_TRIANGLES))
