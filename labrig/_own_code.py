"""Python files of people's own: loaded, and their errors said in one line that names the file and its line."""

import importlib.util
import sys
import traceback
from pathlib import Path
from types import ModuleType

from labrig._errors import LabrigError


def load_module(path: Path, name: str) -> ModuleType:
    """The module in a file; raises `LabrigError` where there is none, or where its code fails.

    It is known by `name`, and may import what lies beside it.
    """
    spec = importlib.util.spec_from_file_location(name, path)
    if not path.is_file():
        raise LabrigError(f"there is no file {path}")
    if spec is None or spec.loader is None:
        raise LabrigError(f"{path}: is not a Python file; its name ends in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    sys.path.insert(0, str(path.resolve().parent))
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise LabrigError(failed(error, path, named=str(path))) from error
    finally:
        sys.path.pop(0)
    return module


def failed(error: Exception, path: Path, what: str = "", named: str = "") -> str:
    """An error of somebody's code in one line: the file, the line in it, `what` was called, and what went wrong.

    The file is called by its name, or as it is `named`.
    """
    line = line_in(error, path)
    if isinstance(error, SyntaxError):
        said = f"is no Python ({error.msg})"
    else:
        text = " ".join(str(error).split())
        said = f"{type(error).__name__}: {text}" if text else type(error).__name__
    return f"{named or path.name}{f', line {line}' if line else ''}: {f'{what}: ' if what else ''}{said}"


def line_in(error: Exception, path: Path) -> int | None:
    """The line of a file at which its code failed; None where the error comes from elsewhere."""
    if isinstance(error, SyntaxError) and error.lineno and _same(error.filename, path):
        return error.lineno
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if _same(frame.filename, path)]
    return lines[-1] if lines else None


def _same(name: str | None, path: Path) -> bool:
    return name is not None and Path(name).resolve() == path.resolve()
