"""What lies in a folder of runs, by names, sizes and times; no log and no result is opened for it."""

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from labrig.catalogue._notes import NOTES
from labrig.log import folders_below, is_segment

RESULTS = ("diagnosis.json", "compare.json")
_LOG = ("run.yaml",)


class RunFiles(NamedTuple):
    """A run folder; `log` and `notes` say which files it held, how large and from when."""

    folder: Path
    log: str
    notes: str


class ResultFile(NamedTuple):
    """A file of results: its size, and when it was written."""

    path: Path
    size: int
    written_ns: int


@dataclass
class Found:
    """Runs and results by their paths below the folder, as they are written on every system (`a/b`)."""

    runs: dict[str, RunFiles] = field(default_factory=dict)
    results: dict[str, ResultFile] = field(default_factory=dict)


def look(folder: Path) -> Found:
    """The runs of a folder, and the results in it and in the folders beside it.

    Raises `LabrigError` if the folder does not exist.
    """
    found = Found()
    for path, entries in folders_below(folder):
        name = path.relative_to(folder).as_posix()
        files = {entry.name for entry in entries}
        segments = sorted(file for file in files if is_segment(file))
        if segments:
            log = _stamp(path, [*segments, *(file for file in _LOG if file in files)])
            found.runs[name] = RunFiles(path, log, _stamp(path, [NOTES] if NOTES in files else []))
        for file in RESULTS:
            if file in files:
                _add(found, f"{name}/{file}" if name != "." else file, path / file)
    own = folder.resolve()
    for beside in _folders_beside(own):
        for file in RESULTS:
            _add(found, f"../{beside.name}/{file}" if beside != own.parent else f"../{file}", beside / file)
    return found


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


def _add(found: Found, name: str, path: Path) -> None:
    try:
        status = path.stat()
    except OSError:
        return
    found.results[name] = ResultFile(path, status.st_size, status.st_mtime_ns)


def _stamp(folder: Path, names: list[str]) -> str:
    """Sizes and times of files. Asked of the files: what Windows keeps in a folder is late for one that grows."""
    parts = []
    for name in names:
        try:
            status = os.stat(os.path.join(folder, name))  # noqa: PTH116, PTH118  (thousands of them: half the time)
        except OSError:
            continue
        parts.append(f"{name} {status.st_size} {status.st_mtime_ns}")
    return ", ".join(parts)
