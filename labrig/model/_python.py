"""Functions in a file of the user's."""

import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from labrig._errors import LabrigError


def load_function(path: Path, name: str) -> Callable[..., Any]:
    """A function by its name; raises `LabrigError` if the file, or the function in it, can't be had."""
    if not path.is_file():
        raise LabrigError(f"{path}: the model's Python file does not exist")
    spec = importlib.util.spec_from_file_location(f"labrig_user_base_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise LabrigError(f"{path}: is not a Python file; its name ends in .py")
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(path.parent.resolve()))
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise LabrigError(f"{path}: can't be imported: {type(error).__name__}: {error}") from error
    finally:
        sys.path.remove(str(path.parent.resolve()))
    function = getattr(module, name, None)
    if not callable(function):
        raise LabrigError(f"{path}: has no function {name!r}")
    return function
