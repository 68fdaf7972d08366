"""Saves a log whose folder was deleted or moved while it was written: the open file still has its content."""

import contextlib
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import yaml


def rescue(file: BinaryIO, path: Path, run: dict[str, Any]) -> Path | None:
    """Copy the open `file`, once `path`, to a new folder beside the one that is gone; returns the folder.

    Where nothing can be written there it goes to the computer's folder for temporary files; None if it cannot be
    saved at all. A file that is open can only be deleted on POSIX: Windows refuses it.
    """
    for folder in _places(path.parent):
        try:
            folder.mkdir()
            file.seek(0)
            with (folder / path.name).open("xb") as copy:
                shutil.copyfileobj(file, copy)
            text = yaml.safe_dump(run, sort_keys=False, allow_unicode=True)
            (folder / "run.yaml").write_text(text, encoding="utf-8")
        except OSError:
            continue
        return folder
    return None


def _places(gone: Path) -> Iterator[Path]:
    for number in range(1, 100):
        place = gone.with_name(f"{gone.name}-rescued" + (f"-{number}" if number > 1 else ""))
        if not place.exists():
            yield place
            break
    with contextlib.suppress(OSError):
        yield Path(tempfile.mkdtemp(prefix="labrig-")) / gone.name
