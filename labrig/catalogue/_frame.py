"""The catalogue as a table for Python, and as a Parquet file."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from labrig._durable import put_at
from labrig._errors import LabrigError
from labrig._paths import path_of
from labrig.catalogue._list import list_runs
from labrig.catalogue._row import Row

if TYPE_CHECKING:
    import pandas as pd

_WHOLE = ("captures", "planned", "warnings")


def runs(folder: Path | str = "runs", where: str | None = None) -> "pd.DataFrame":
    """The runs below a folder as a table, one row each; `docs/how-to/find-your-runs.md` has the columns.

    `where` is a condition such as ``"verdict == 'identified' and captures > 20"``; it can only compare. Raises
    `LabrigError` if there is no such folder, or for a condition that has no meaning.

    Example:
        >>> known = labrig.runs("runs", where="captures > 30")
        >>> list(known["procedure"])
        ['capture']
    """
    below = path_of(folder, "a folder of runs", "its path, such as runs")
    return frame(list_runs(below, where))


def frame(rows: Sequence[Row]) -> "pd.DataFrame":
    """Rows as a DataFrame: times in UTC, what is not known is missing (texts: empty)."""
    import pandas as pd

    table = pd.DataFrame(rows, columns=list(Row._fields))
    table["started"] = pd.to_datetime(table["started"], utc=True, errors="coerce", format="%Y-%m-%d %H:%M:%S")
    for name in _WHOLE:
        table[name] = table[name].astype("Int64")
    for name in ("length_s", "size_mb", "error", "floor"):
        table[name] = table[name].astype("float64")
    table["tags"] = [list(row.tags) for row in rows]
    return table


def write_parquet(rows: Sequence[Row], path: Path) -> None:
    """Write rows to a Parquet file, whole or not at all; raises `LabrigError` where pyarrow is missing."""
    partial = path.with_name(path.name + ".partial")
    try:
        frame(rows).to_parquet(partial, index=False)
        put_at(partial, path)
    except ImportError:
        raise LabrigError("Parquet files need pyarrow, which is not installed: pip install pyarrow") from None
    finally:
        partial.unlink(missing_ok=True)
