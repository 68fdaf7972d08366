"""A foreign file becomes a table, by its ending and by what is in it."""

import json
import os
import re
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from labrig._errors import LabrigError
from labrig.tables._amounts import amounts
from labrig.tables._mapping import Format, Mapping
from labrig.tables._packed import DAMAGED, is_packed, open_bytes, open_text
from labrig.tables._plain import plain
from labrig.tables._spelling import is_absolute, unit_of
from labrig.tables._table import Table, short

_ENDINGS = {
    "excel": {".xlsx", ".xlsm", ".xls", ".xlsb", ".ods"},
    "parquet": {".parquet", ".pq", ".feather", ".arrow"},
    "arrays": {".tdms", ".mat", ".h5", ".hdf5", ".hdf", ".npz", ".npy", ".nc"},
    "c3d": {".c3d"},
    "json": {".json", ".jsonl", ".ndjson"},
    "bag": {".mcap", ".bag", ".db3"},
}
_BEGINS = (
    (b"PAR1", "parquet"),
    (b"ARROW1", "parquet"),
    (b"FEA1", "parquet"),
    (b"TDSm", "arrays"),
    (b"\x89HDF", "arrays"),
    (b"MATLAB 5.0", "arrays"),
    (b"MATLAB 7.3", "arrays"),
    (b"\x93NUMPY", "arrays"),
    (b"\x89MCAP", "bag"),
    (b"#ROSBAG", "bag"),
    (b"\xd0\xcf\x11\xe0", "excel"),
)
_JSON = re.compile(rb"(\xef\xbb\xbf)?\s*(\{|\[\s*\{)")
READ = (
    "CSV and other text, JSON, Excel, Parquet, Feather, MAT, HDF5, NPZ, TDMS, C3D, MCAP and ROS bags, "
    "and text packed as .gz or .zip"
)


def kind_of(path: Path) -> str:
    """`text`, `json`, `excel`, `parquet`, `arrays`, `c3d` or `bag`: by what the file begins with, else by its ending.

    A file with the wrong ending is read as what it is. Raises `LabrigError` if it is not there, is empty, or can't be
    read.
    """
    if path.is_dir():
        if (path / "metadata.yaml").is_file():
            return "bag"
        raise LabrigError(f"{path}: is a folder; name a table ({READ})")
    if not path.is_file():
        raise LabrigError(f"{path}: there is no such table")
    try:
        with open_bytes(path) as file:
            head = file.read(512)
        packed = is_packed(path)
    except DAMAGED:
        raise _cut_off(path) from None
    except OSError as error:
        raise LabrigError(f"{path}: can't be read ({error.strerror or error})") from None
    if not head:
        raise LabrigError(f"{path}: is empty")
    known = next((kind for begin, kind in _BEGINS if head.startswith(begin)), None)
    if packed and known is not None:
        raise LabrigError(f"{path}: is packed; only text is read so, unpack it")
    if known is not None:
        return known
    if head.startswith(b"PK") and zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as archive:
            return "arrays" if any(n.endswith(".npy") for n in archive.namelist()) else "excel"
    ending = "" if packed else path.suffix.lower()
    for kind, endings in _ENDINGS.items():
        if ending in endings:
            return kind
    return "json" if _JSON.match(head) else "text"


def read_table(path: Path, mapping: Mapping, part: str | None = None) -> Table:
    """Read one file of a mapping, or a `part` of it; raises `LabrigError` when it is not there or not what its name
    says.
    """
    how = mapping.format if part is None else mapping.format.model_copy(update={"part": part})
    return read_file(path, how, mapping, as_text=mapping.any_thousands())


def read_file(path: Path, how: Format, mapping: Mapping | None = None, *, as_text: bool = False) -> Table:
    """Read one file as `how` says; a C3D file takes the names of its markers from the `mapping`."""
    kind = kind_of(path)
    with readable(path, kind):
        table = _reader(kind, mapping, as_text)(path, how)
    frame = table.frame.iloc[: how.rows].reset_index(drop=True)
    if frame.empty:
        raise LabrigError(f"{path}: has no rows")
    below = _units_below(path, how, table)
    units = {
        **table.units,
        **{name: unit for name, text in below.items() if (unit := unit_of(text)) is not None},
    }
    absolute = table.absolute | {name for name, text in below.items() if is_absolute(text)}
    table = replace(table, frame=frame, missing=frozenset(how.missing), units=units, absolute=absolute)
    if as_text:
        return table
    frame, own = amounts(table)
    return replace(table, frame=frame, units={**units, **own})


def _units_below(path: Path, how: Format, table: Table) -> dict[str, str]:
    """What stands in the row of units below the names, by the names of their columns."""
    if not (how.units_row and how.header):
        return {}
    raw = read_file(path, how.model_copy(update={"units_row": False, "rows": 1}), as_text=True).frame.iloc[0]
    names = [str(c) for c in table.frame.columns]
    return {name: str(text) for name, text in zip(names, raw.tolist(), strict=False)}


@contextmanager
def readable(path: Path, kind: str) -> Iterator[None]:
    """Whatever a reader stumbles over is said in one line, with the file."""
    try:
        yield
    except LabrigError:
        raise
    except DAMAGED:
        raise _cut_off(path) from None
    except MemoryError:
        raise LabrigError(f"{path}: is too large for this computer's memory; take less of it") from None
    except Exception as error:
        lines = str(error).strip().splitlines()
        reason = short(lines[0].strip(), quote=False) if lines else type(error).__name__
        raise LabrigError(f"{path}: can't be read as {_NAMES[kind]} ({reason})") from error


def _cut_off(path: Path) -> LabrigError:
    return LabrigError(f"{path}: is packed, and can't be unpacked: it was cut off, or is damaged")


_NAMES = {
    "text": "a table",
    "excel": "a workbook",
    "parquet": "Parquet or Feather",
    "arrays": "a file of arrays",
    "c3d": "C3D",
    "bag": "a log",
    "json": "JSON, one record a line or a list of records",
}


def _reader(kind: str, mapping: Mapping | None, as_text: bool) -> Callable[[Path, Format], Table]:
    if kind == "c3d":
        from labrig.tables._c3d import read_c3d

        return lambda path, how: read_c3d(path, mapping)
    if kind == "excel":
        from labrig.tables._workbook import read_workbook

        return read_workbook
    if kind == "arrays":
        from labrig.tables._arrays import read_arrays

        return read_arrays
    if kind == "bag":
        from labrig.tables._bags import read_bag

        return read_bag
    if kind == "parquet":
        return _read_parquet
    if kind == "json":
        return _read_json
    from labrig.tables._text import read_text

    return lambda path, how: read_text(path, how, as_text=as_text)


def _read_json(path: Path, how: Format) -> Table:
    """Records of one object each, one a line or in a list; a key within a key is called ``KEY.KEY``, as is an entry of
    a list by its number.
    """
    import pandas as pd

    with open_text(path, how.encoding or "utf-8-sig") as file:
        text = file.read()
    whole = text.lstrip().startswith("[")
    records = json.loads(text) if whole else [json.loads(line) for line in text.splitlines() if line.strip()]
    return Table(
        path, pd.DataFrame([dict(_flat(record)) for record in records]), decimal=how.decimal, row_is="record"
    )


def _flat(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """What a record holds, by the names of columns."""
    inner = (
        value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else None
    )
    if inner is None:
        yield name, value
        return
    for key, one in inner:
        yield from _flat(one, f"{name}.{key}" if name else str(key))


def _read_parquet(path: Path, how: Format) -> Table:
    """Read Parquet or Feather.

    A named index becomes a column. An index without a name becomes the column `time`, unless it only counts rows.
    """
    import pandas as pd

    with path.open("rb") as file:
        whole = file.read(4) == b"PAR1"
    return Table(path, plain(pd.read_parquet(path) if whole else pd.read_feather(path)), decimal=how.decimal)


def parts_of(path: Path) -> dict[str, int]:
    """What a file has several of, with the rows of each: sheets, groups of arrays with a length, topics."""
    kind = kind_of(path)
    with readable(path, kind):
        if kind == "excel":
            from labrig.tables._workbook import sheets

            return sheets(path)
        if kind == "arrays":
            from labrig.tables._arrays import groups

            return groups(path)
        if kind == "bag":
            from labrig.tables._bags import topics

            return topics(path)
    return {}


def parts_of_one_kind(path: Path) -> dict[str, int]:
    """The parts of a file that may be recordings of one kind, in its order: all its sheets, or groups of arrays that
    are called alike.
    """
    if (kind := kind_of(path)) != "arrays":
        return parts_of(path) if kind == "excel" else {}
    with readable(path, kind):
        from labrig.tables._arrays import groups_of_one_kind

        return groups_of_one_kind(path)


def beside(path: Path, folder: Path) -> str:
    """A path as a mapping in `folder` writes it, with slashes on every system."""
    try:
        return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()
    except ValueError:  # another drive on Windows
        return path.resolve().as_posix()
