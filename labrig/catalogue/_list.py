"""The rows of all runs below a folder: those that the index knows, and those that are new or have changed."""

from collections.abc import Callable, Iterable
from datetime import UTC, datetime
from pathlib import Path

from labrig._errors import LabrigError
from labrig.catalogue._index import Index, Kept, load, save
from labrig.catalogue._look import Found, RunFiles, look
from labrig.catalogue._notes import read_notes
from labrig.catalogue._results import Result, by_run, read_result, with_result
from labrig.catalogue._row import Row, read_row, unreadable
from labrig.catalogue._where import condition
from labrig.log import segment_paths

UNREADABLE = "unreadable: "
"""How the notes of a run begin whose notes.yaml is damaged."""
Progress = Callable[[int, int], None]


def list_runs(folder: Path | str, where: str | None = None, progress: Progress | None = None) -> list[Row]:
    """The runs below a folder, two levels deep, in order of their names; those of which `where` is true.

    Only logs that are new or have changed are read (`progress` is told how many of how many); the rest is in an index
    in the folder, which is written if it can be. Raises `LabrigError` if there is no such folder, or for a condition
    that has no meaning.
    """
    folder = Path(folder)
    fits = condition(where) if where is not None else None
    found = look(folder)
    known = load(folder)
    index = Index()
    try:
        index.results = _results(found, known)
        rows = _rows(found, known, index, progress)
    finally:  # what an interrupted listing has read is not read again
        known_of = by_run(index.results.values(), (kept.row for kept in index.runs.values()))
        index.runs = {n: kept._replace(row=with_result(kept.row, known_of)) for n, kept in index.runs.items()}
        if index != known and found.runs and "." not in found.runs:
            save(folder, index)
    rows = [with_result(row, known_of) for row in rows]
    return rows if fits is None else [row for row in rows if fits(row)]


def _rows(found: Found, known: Index, index: Index, progress: Progress | None) -> list[Row]:
    """The rows of what was found; those that can be kept go into the index."""
    new = {name for name, files in found.runs.items() if not _is_known(known, name, files)}
    rows, done = [], 0
    for name, files in found.runs.items():
        if name in new and progress is not None:
            progress(done, len(new))
        done += name in new
        row, whole = _row(name, files, known.runs.get(name))
        rows.append(row)
        if whole:
            index.runs[name] = Kept(row, files.log, files.notes)
    return rows


def _is_known(known: Index, name: str, files: RunFiles) -> bool:
    return name in known.runs and known.runs[name].log == files.log


def _row(name: str, files: RunFiles, known: Kept | None) -> tuple[Row, bool]:
    """A run's row, and whether it holds all that there is to know (what can't be read is tried again each time)."""
    row, whole = (known.row, True) if known is not None and known.log == files.log else (None, True)
    if row is None:
        try:
            row = read_row(Path(files.folder), name)
        except (LabrigError, OSError) as error:
            row, whole = unreadable(name, error), False
    if known is not None and known.row is row and known.notes == files.notes:
        return row, whole
    if not files.notes:
        return row._replace(tags=(), notes="", ruled_out=""), whole
    try:
        notes = read_notes(Path(files.folder))
    except LabrigError as error:
        return row._replace(tags=(), notes=f"{UNREADABLE}{error}", ruled_out=""), False
    said = {"tags": tuple(notes.tags), "notes": "\n".join(notes.notes), "ruled_out": notes.ruled_out_in_words}
    return row._replace(**said), whole


def _results(found: Found, known: Index) -> dict[str, Result]:
    """What the results say; those that can't be read are left out, and tried again each time."""
    results: dict[str, Result] = {}
    for name, file in found.results.items():
        old = known.results.get(name)
        if old is None or (old.size, old.written_ns) != (file.size, file.written_ns):
            try:
                old = read_result(Path(file.path), name, file.size, file.written_ns)
            except (OSError, ValueError, RecursionError):
                continue
        results[name] = old
    return results


def newest_first(folder: Path, rows: Iterable[Row]) -> list[Row]:
    """Rows in the order of their runs' times, the newest first; a run that says no time is as old as its files here."""
    return sorted(rows, key=lambda row: (row.started or _written(folder / row.run), row.run), reverse=True)


def _written(run: Path) -> str:
    """When a run was written, such as imported, as `started` is written; empty where its files cannot be looked at."""
    try:
        first = next((path for _, path in segment_paths(run)), run)
        return f"{datetime.fromtimestamp(first.stat().st_mtime, UTC):%Y-%m-%d %H:%M:%S}"
    except OSError:
        return ""
