"""Which folders are runs, and what a run is recognised by; no log is read for it."""

import hashlib
import os
from collections.abc import Iterator
from pathlib import Path

from labrig._errors import LabrigError
from labrig.log._segments import is_segment, segment_paths

_DEPTH = 2
_HEAD_BYTES = 64 * 1024


def find_runs(folder: Path) -> list[Path]:
    """The run folders below a folder, at most two levels deep, in order of their names.

    Raises `LabrigError` if the folder does not exist.
    """
    return [
        Path(path) for path, _, entries in folders_below(folder) if any(is_segment(e.name) for e in entries)
    ]


def folders_below(folder: Path) -> Iterator[tuple[str, str, list[os.DirEntry[str]]]]:
    """A folder and those below it, two levels deep, in order of their names.

    Each with its path, its name below the first one (`.`, `a`, `a/b`), and what lies in it. Folders that can't be read
    are left out. Raises `LabrigError` if the first one is none.
    """
    if not folder.is_dir():
        raise LabrigError(f"{folder} is not a folder; name the one that holds your runs")
    level = [(str(folder), ".")]
    for depth in range(_DEPTH + 1):
        below: list[tuple[str, str]] = []
        for path, name in level:
            try:
                with os.scandir(path) as found:
                    entries = sorted(found, key=lambda entry: entry.name)
            except OSError:
                continue
            yield path, name, entries
            if depth < _DEPTH:
                start = "" if name == "." else f"{name}/"
                below += [(entry.path, start + entry.name) for entry in entries if _is_folder(entry)]
        level = below


def _is_folder(entry: os.DirEntry[str]) -> bool:
    try:
        return entry.is_dir()
    except OSError:
        return False


def run_id(path: Path) -> str:
    """What a run (a folder, or an .mcap file) is recognised by, wherever it is copied: a digest of its log's beginning.

    It is settled once the first log file holds 64 KiB, or is finished.
    """
    first = path if path.is_file() else segment_paths(path)[0][1]
    with first.open("rb") as file:
        return hashlib.sha256(file.read(_HEAD_BYTES)).hexdigest()[:16]
