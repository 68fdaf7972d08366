"""Where commands write: looked at before any work is done, and what was there before is not replaced in silence."""

import os
from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path

from labrig._errors import LabrigError
from labrig._paths import check_parent

_PLACES = ("--out", "-o")


def check_named(words: Sequence[str]) -> None:
    """Raise `LabrigError` for a place to write into without a name, which would be taken for the current folder."""
    for option, value in zip_longest(words, words[1:]):
        name, equals, rest = option.partition("=")
        if name in _PLACES and (rest if equals else value) == "":
            raise LabrigError(
                f"{name} is empty; name the place, or leave {name} out (`.` is the current folder)"
            )


def check_folder(folder: Path, option: str = "--out") -> None:
    """Raise `LabrigError` if a folder can be neither used nor made."""
    there = folder
    while not there.exists() and there != there.parent:
        there = there.parent
    if not there.is_dir():
        raise LabrigError(
            f"{option} {folder}: {'this' if there == folder else there} is a file; choose a folder"
        )
    if not os.access(there, os.W_OK | os.X_OK):
        raise LabrigError(
            f"{option} {folder}: nothing can be written into {there.resolve()}; choose another folder"
        )


def check_file(path: Path, option: str = "-o") -> None:
    """Raise `LabrigError` if a file can be neither written nor replaced."""
    if path.is_dir():
        raise LabrigError(f"{option} {path}: is a folder; name a file")
    check_parent(path)
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise LabrigError(
            f"{option} {path}: nothing can be written into {path.parent.resolve()}; choose another folder"
        )


def replaced(path: Path) -> str:
    """What is said behind the name of a file that is about to be written."""
    return " (replaces the one that was there)" if path.exists() else ""
