"""What lies in a folder of runs, by names, sizes and times; no log and no result is opened for it."""

import os
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from labrig.catalogue._notes import NOTES
from labrig.log import folders_below, is_segment

RESULTS = ("diagnosis.json", "compare.json")
_LOG = ("run.yaml",)


class RunFiles(NamedTuple):
    """A run folder; `log` and `notes` say which files it held, how large and from when."""

    folder: str
    log: str
    notes: str


class ResultFile(NamedTuple):
    """A file of results: its size, and when it was written."""

    path: str
    size: int
    written_ns: int


@dataclass
class Found:
    """Runs and results by their paths below the folder, as they are written on every system (`a/b`)."""

    runs: dict[str, RunFiles] = field(default_factory=dict)
    results: dict[str, ResultFile] = field(default_factory=dict)


def look(folder: Path) -> Found:
    """The runs of a folder, and the results in it, in those of its runs, and in the folders beside it.

    Raises `LabrigError` if the folder does not exist.
    """
    found = Found()
    for path, name, entries in folders_below(folder):
        files = {entry.name: entry.path for entry in entries}
        segments = [file for file in files if is_segment(file)]
        if segments:
            log = _stamp(files, [*sorted(segments), *_LOG])
            found.runs[name] = RunFiles(path, log, _stamp(files, [NOTES]))
            _add_results_in(found, name, entries)
        for file in RESULTS:
            if file in files:
                _add(found, f"{name}/{file}" if name != "." else file, files[file])
    own = folder.resolve()
    for beside in _folders_beside(own):
        for file in RESULTS:
            _add(
                found,
                f"../{beside.name}/{file}" if beside != own.parent else f"../{file}",
                str(beside / file),
            )
    return found


def _add_results_in(found: Found, run: str, entries: Iterable[os.DirEntry[str]]) -> None:
    """The results in the folders of a run: below the deepest runs nobody else looks."""
    for entry in entries:
        with suppress(OSError):
            if entry.is_dir():
                name = entry.name if run == "." else f"{run}/{entry.name}"
                for file in RESULTS:
                    _add(found, f"{name}/{file}", str(Path(entry.path, file)))


def _folders_beside(folder: Path) -> list[Path]:
    """The folder that a folder lies in, and the others there: where commands write when nothing else is said."""
    if folder.parent == folder:
        return []
    try:
        with os.scandir(folder.parent) as entries:
            return [
                folder.parent,
                *(Path(e.path) for e in entries if e.is_dir() and e.name != folder.name),
            ]
    except OSError:
        return []


def _add(found: Found, name: str, path: str) -> None:
    if (status := _status(path)) is not None:
        found.results[name] = ResultFile(path, status.st_size, status.st_mtime_ns)


def _stamp(files: Mapping[str, str], names: Iterable[str]) -> str:
    """Sizes and times of those files that there are."""
    known = [(name, _status(files[name])) for name in names if name in files]
    return ", ".join(f"{name} {s.st_size} {s.st_mtime_ns}" for name, s in known if s is not None)


def _status(path: str) -> os.stat_result | None:
    """Asked of the file: what Windows keeps in a folder is late for one that grows. None where it has gone."""
    try:
        return os.stat(path)  # noqa: PTH116  (tens of thousands of them)
    except OSError:
        return None
