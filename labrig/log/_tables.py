"""Foreign tables read into columns: CSV, Parquet, C3D; every complaint names the file, row and column."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.log._mapping import Format, Mapping
from labrig.log._units import factor

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Table:
    """One file's rows; markers of C3D files appear as columns ``NAME.x`` in mm, their time as ``time_s``."""

    path: Path
    frame: "pd.DataFrame"
    first_row: int
    decimal: str = "."

    def numbers(
        self, column: str | int, what: str, *, required: bool = False, thousands: str | None = None
    ) -> Floats:
        """A column as floats; raises `LabrigError` for a missing column, text, or (if required) a gap."""
        values = self._column(column, what)
        if values.dtype.kind not in "fiu" and (thousands or self.decimal != "."):
            text = (
                values.astype(str).str.replace(thousands, "", regex=False)
                if thousands
                else values.astype(str)
            )
            values = text.str.replace(self.decimal, ".", regex=False)
        import pandas as pd

        out = np.asarray(pd.to_numeric(values, errors="coerce"), dtype=float)
        blank = np.asarray(values.isna() | (values.astype(str).str.strip().isin(["", "nan", "NaN", "NA"])))
        wrong = ~np.isfinite(out) & ~blank
        if wrong.any():
            i = int(np.flatnonzero(wrong)[0])
            found = values.tolist()[i]
            raise LabrigError(f"{self._at(i)}: column {column!r} ({what}) holds {found!r}, not a number")
        if required and blank.any():
            i = int(np.flatnonzero(blank)[0])
            raise LabrigError(
                f"{self._at(i)}: column {column!r} ({what}) is empty or NaN; every row needs it"
            )
        return out

    def labels(self, column: str | int, what: str) -> list[str]:
        """A column as text, empty where there is nothing; whole numbers without a decimal point."""
        values = self._column(column, what)
        return [
            "" if v is None or v != v else str(int(v)) if isinstance(v, float) and v.is_integer() else str(v)
            for v in values.tolist()
        ]

    def _column(self, column: str | int, what: str) -> "pd.Series":
        if column not in self.frame.columns:
            have = ", ".join(str(c) for c in list(self.frame.columns)[:12])
            more = ", ..." if len(self.frame.columns) > 12 else ""
            raise LabrigError(f"{self.path}: has no column {column!r} ({what}); it has {have}{more}")
        values: Any = self.frame[column]
        return values

    def _at(self, i: int) -> str:
        return f"{self.path}, line {i + self.first_row}"


def read_table(path: Path, mapping: Mapping) -> Table:
    """Read one file by its ending; raises `LabrigError` when it is not there or not what its name says."""
    if not path.is_file():
        raise LabrigError(f"{path}: there is no such table")
    kind = path.suffix.lower()
    if kind == ".c3d":
        return _read_c3d(path, mapping)
    try:
        import pandas as pd

        if kind in {".parquet", ".pq"}:
            frame, first = pd.read_parquet(path), 1
        else:
            frame, first = _read_text(path, mapping.format, mapping.any_thousands())
    except LabrigError:
        raise
    except Exception as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise LabrigError(f"{path}: can't be read as a table ({reason})") from error
    frame = frame.iloc[: mapping.format.rows : mapping.format.every].reset_index(drop=True)
    if frame.empty:
        raise LabrigError(f"{path}: has no rows")
    return Table(path, frame, first, mapping.format.decimal)


def _read_text(path: Path, how: Format, any_thousands: bool) -> tuple["pd.DataFrame", int]:
    import pandas as pd

    separator = {"whitespace": r"\s+", "tab": "\t"}.get(how.separator, how.separator)
    options: dict[str, Any] = {"sep": separator, "encoding": "utf-8-sig", "skipinitialspace": True}
    options |= {"skiprows": how.skip_rows, "header": 0 if how.header else None, "skip_blank_lines": False}
    if any_thousands or how.decimal != ".":
        options["dtype"] = str
    frame = pd.read_csv(path, **options)
    if how.header:
        frame.columns = [str(c).strip() for c in frame.columns]
    return frame, how.skip_rows + (2 if how.header else 1)


def _read_c3d(path: Path, mapping: Mapping) -> Table:
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
    wanted = mapping.marker_table() or dict.fromkeys(labels)
    for name, marker in wanted.items():
        label = marker.point if marker is not None and marker.point else name
        if label not in labels:
            raise LabrigError(f"{path}: has no point {label!r}; it has {', '.join(labels[:12])}")
        for a, axis in enumerate("xyz"):
            columns[f"{name}.{axis}"] = points[a, labels.index(label)] * scale
    frame = pd.DataFrame(columns).iloc[:: mapping.format.every].reset_index(drop=True)
    return Table(path, frame, 1)
