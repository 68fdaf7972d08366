"""Paths that people hand over; what is none is refused in one line."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from labrig._errors import LabrigError


def path_of(given: Any, what: str, wanted: str) -> Path:
    """A path, as text or as a Path; raises `LabrigError` for anything else, and for an empty text."""
    if isinstance(given, str) and not given:
        raise LabrigError(f"{what} is needed: {wanted}")
    if isinstance(given, str | os.PathLike):
        return Path(given)
    raise wrong(what, given, wanted)


def paths_of(given: Any, what: str, wanted: str) -> list[Path]:
    """One path or several; raises `LabrigError` for anything else, and for none."""
    several = list(given) if isinstance(given, list | tuple) else [given]
    if not several:
        raise LabrigError(f"{what}: none was given; {wanted}")
    return [path_of(one, what, wanted) for one in several]


def check_there(files: Sequence[str | Path]) -> None:
    """Raise `LabrigError` for a file that is not there, before anything is done with the others."""
    if missing := [path for path in files if not Path(path).is_file()]:
        more = f" (and {len(missing) - 1} more)" if len(missing) > 1 else ""
        raise LabrigError(f"{missing[0]} does not exist{more}")


def check_parent(path: Path) -> None:
    """Raise `LabrigError` if the folder that something is to be written into is not there."""
    if not path.parent.is_dir():
        raise LabrigError(f"{path}: the folder {path.parent} does not exist")


def wrong(what: str, given: Any, wanted: str) -> LabrigError:
    """The error for something of a type that is none of those wanted."""
    kind = type(given)
    named = (
        kind.__name__ if kind.__module__ == "builtins" else f"{kind.__module__.split('.')[0]}.{kind.__name__}"
    )
    return LabrigError(f"{what} is needed, and a {named} was given: {wanted}")
