"""C3D files of motion capture systems: their points become columns."""

from pathlib import Path

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.tables._mapping import Mapping
from labrig.tables._table import Table
from labrig.tables._units import factor


def read_c3d(path: Path, mapping: Mapping | None) -> Table:
    """The points that a mapping names, or all of them, in mm; a frame each 1 / rate s.

    Raises `LabrigError` if it is no C3D file, has no frames, or lacks a point.
    """
    import ezc3d
    import pandas as pd

    try:
        content = ezc3d.c3d(str(path))
        points = np.asarray(content["data"]["points"], dtype=float)
        parameters = content["parameters"]["POINT"]
        labels = [str(v).strip() for v in parameters["LABELS"]["value"]]
        units = parameters["UNITS"]["value"] if "UNITS" in parameters else []
        unit = str(units[0]).strip() if len(units) else "mm"
        rate = float(parameters["RATE"]["value"][0])
    except Exception as error:
        raise LabrigError(f"{path}: can't be read as C3D ({type(error).__name__})") from error
    if points.shape[2] == 0 or rate <= 0:
        raise LabrigError(f"{path}: has no frames")
    scale = factor(unit or "mm", "mm", f"{path}: POINT:UNITS")
    columns: dict[str, Floats] = {"time_s": np.arange(points.shape[2]) / rate}
    wanted = (mapping.marker_table() if mapping is not None else None) or dict.fromkeys(labels)
    for name, marker in wanted.items():
        label = marker.point if marker is not None and marker.point else name
        if label not in labels:
            raise LabrigError(f"{path}: has no point {label!r}; it has {', '.join(labels[:12])}")
        for a, axis in enumerate("xyz"):
            columns[f"{name}.{axis}"] = points[a, labels.index(label)] * scale
    return Table(path, pd.DataFrame(columns))
