"""The index: what was read of runs and results, in one SQLite file beside the runs, so that it is read once.

It is a copy of what the runs themselves say. The file is replaced as a whole and never changed, so it needs no lock,
also on a network drive, and whoever reads it sees one that is whole. Of two who write at once, the later one's stays,
and what that one lacks is read again. Whatever is not as it was written counts as not there.
"""

import json
import os
import secrets
import sqlite3
import zlib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

from labrig.catalogue._results import Result
from labrig.catalogue._row import Row

INDEX = ".labrig-runs.sqlite"
_OURS = 0x6C616272
_VERSION = 5
_MARKS = {"application_id": _OURS, "user_version": _VERSION}
_PARTIAL = ".partial"
_LEFT_OVER_S = 3600.0
_RUNS = (*Row._fields, "log_stamp", "notes_stamp")
_LISTS = {"runs": Row._fields.index("tags"), "results": Result._fields.index("runs")}


class Kept(NamedTuple):
    """What was read of a run, and the stamps of the files that it was read from."""

    row: Row
    log: str
    notes: str


@dataclass
class Index:
    """What was read of runs and results, by their paths."""

    runs: dict[str, Kept] = field(default_factory=dict)
    results: dict[str, Result] = field(default_factory=dict)


def load(folder: Path) -> Index:
    """The index of a folder; empty where there is none, or none of this labrig's."""
    try:
        with closing(_opened(folder / INDEX, "mode=ro&immutable=1")) as connection:
            marks = [connection.execute(f"PRAGMA {name}").fetchone()[0] for name in _MARKS]
            if marks != list(_MARKS.values()):
                return Index()
            runs = [(Row._make(v[:-2]), *v[-2:]) for v in _rows(connection, "runs", _RUNS)]
            results = [Result._make(v) for v in _rows(connection, "results", Result._fields)]
    except (sqlite3.Error, OSError, ValueError, TypeError):
        return Index()
    return Index({row.run: Kept(row, log, notes) for row, log, notes in runs}, {r.path: r for r in results})


def save(folder: Path, index: Index) -> bool:
    """Write the index of a folder, as a whole or not at all; whether it could be written."""
    partial = folder / f"{INDEX}.{secrets.token_hex(4)}{_PARTIAL}"
    try:
        with partial.open("xb"):
            pass
    except OSError:
        return False
    try:
        _write(partial, index)
        with partial.open("rb+") as file:
            os.fsync(file.fileno())
        _remove_left_over(folder, partial)
        partial.replace(folder / INDEX)
    except (sqlite3.Error, OSError):
        with suppress(OSError):
            partial.unlink(missing_ok=True)
        return False
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
    return True


def _opened(path: Path, how: str) -> sqlite3.Connection:
    place = path.resolve().as_posix()
    return sqlite3.connect(
        f"file://{'' if place.startswith('/') else '/'}{quote(place)}?{how}", uri=True, isolation_level=None
    )


def _write(path: Path, index: Index) -> None:
    runs = [(*kept.row, kept.log, kept.notes) for kept in index.runs.values()]
    with closing(_opened(path, "mode=rw&nolock=1")) as connection:
        connection.execute("PRAGMA journal_mode=OFF")
        connection.execute("PRAGMA synchronous=OFF")
        for name, value in _MARKS.items():
            connection.execute(f"PRAGMA {name}={value}")
        connection.execute("BEGIN")
        for table, names, rows in (
            ("runs", _RUNS, runs),
            ("results", Result._fields, index.results.values()),
        ):
            connection.execute(f"CREATE TABLE {table} ({_quoted(names)}, checksum)")
            places = ", ".join("?" * (len(names) + 1))
            connection.executemany(f"INSERT INTO {table} VALUES ({places})", _encoded(table, rows))
        connection.execute("COMMIT")


def _quoted(names: Sequence[str]) -> str:
    return ", ".join(f'"{name}"' for name in names)


def _encoded(table: str, rows: Iterable[Sequence[Any]]) -> Iterator[tuple[Any, ...]]:
    """Rows as they are stored; one whose name no UTF-8 can hold is left out, and is read anew each time."""
    at = _LISTS[table]
    for row in rows:
        values = (*row[:at], json.dumps(row[at], ensure_ascii=False) if row[at] else "", *row[at + 1 :])
        text = repr(values)
        if all(not isinstance(v, str) or _encodes(v) for v in values):
            yield (*values, zlib.crc32(text.encode()))


def _encodes(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _rows(connection: sqlite3.Connection, table: str, names: Sequence[str]) -> Iterator[tuple[Any, ...]]:
    """The rows of a table that are as they were written."""
    at = _LISTS[table]
    for *values, checksum in connection.execute(f"SELECT {_quoted(names)}, checksum FROM {table}"):
        if zlib.crc32(repr(tuple(values)).encode()) == checksum:
            listed = json.loads(values[at]) if values[at] else ()
            values[at] = tuple(tuple(each) if isinstance(each, list) else each for each in listed)
            yield tuple(values)


def _remove_left_over(folder: Path, own: Path) -> None:
    """Remove what writers that were killed have left; by the clock that stamps files in this folder."""
    now_s = own.stat().st_mtime
    for path in folder.glob(f"{INDEX}.*{_PARTIAL}"):
        with suppress(OSError):
            if path.stat().st_mtime < now_s - _LEFT_OVER_S:
                path.unlink()
