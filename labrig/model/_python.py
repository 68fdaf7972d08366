"""Functions of the user's: in a file, or handed over as they are."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from labrig._errors import LabrigError
from labrig._own_code import load_module
from labrig.model._file import PythonBase


def load_function(path: Path, name: str) -> Callable[..., Any]:
    """A function by its name; raises `LabrigError` if the file, or the function in it, can't be had."""
    if not path.is_file():
        raise LabrigError(f"{path}: the model's Python file does not exist")
    if path.suffix != ".py":
        raise LabrigError(f"{path}: is not a Python file; its name ends in .py")
    function = getattr(load_module(path, f"labrig_user_base_{path.stem}"), name, None)
    if not callable(function):
        raise LabrigError(f"{path}: has no function {name!r}")
    return function


def function_of(spec: PythonBase, folder: Path) -> Callable[..., Any]:
    """The function of a base: as it was handed over, else in its file."""
    return load_function(folder / spec.file, spec.function) if spec.given is None else spec.given


def place_of(spec: PythonBase, folder: Path) -> str:
    """Where the function of a base stands, for messages."""
    in_file = f"{folder / spec.file}:{spec.function}"
    return in_file if spec.given is None else f"the function {spec.function}"
