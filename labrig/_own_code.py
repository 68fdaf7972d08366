"""Python files of people's own: loaded, and their errors said in one line that names the file and its line."""

import importlib
import importlib.util
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import ModuleType

from labrig._errors import LabrigError

FAULTS = (Exception, SystemExit)
"""What somebody's code fails with; a library of theirs that calls `sys.exit` must not end labrig, nor a vent."""

USER_FOLDER = "effects"
"""A folder of this name beside the model file, or where labrig is called, holds the user's own effects."""


def load_module(path: Path, name: str) -> ModuleType:
    """The module in a file; raises `LabrigError` where there is none, or where its code fails.

    It is known by `name`, and may import what lies beside it; see `_beside`.
    """
    spec = importlib.util.spec_from_file_location(name, path)
    if not path.is_file():
        raise LabrigError(f"there is no file {path}")
    if spec is None or spec.loader is None:
        raise LabrigError(f"{path}: is not a Python file; its name ends in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        with _beside(path.resolve().parent):
            spec.loader.exec_module(module)
    except FAULTS as error:
        del sys.modules[name]
        raise LabrigError(failed(error, path, named=str(path))) from error
    return module


@contextmanager
def _beside(folder: Path) -> Iterator[None]:
    """Imports what lies in a folder from there and as it is now, and keeps none of it.

    Another folder may have modules of the same names, and both change while a notebook or the workbench runs.
    """
    files = {file.stem for file in folder.glob("*.py")} - {"labrig", "__main__", *sys.stdlib_module_names}
    aside = {name: sys.modules.pop(name) for name in files & sys.modules.keys()}
    before, wrote = set(sys.modules), sys.dont_write_bytecode
    sys.path.insert(0, str(folder))
    # to Python's own cache a file that changed within a second looks unchanged
    sys.dont_write_bytecode = True
    importlib.invalidate_caches()
    try:
        yield
    finally:
        with suppress(ValueError):  # somebody's code may have taken it out itself
            sys.path.remove(str(folder))
        sys.dont_write_bytecode = wrote
        for name in sys.modules.keys() - before:
            top = name.partition(".")[0]
            if top not in before and _lies_in(sys.modules[name], folder / top):
                del sys.modules[name]
        sys.modules.update(aside)


def _lies_in(module: ModuleType, place: Path) -> bool:
    """Whether a module is the file, or in the package, of that name."""
    file = getattr(module, "__file__", None)
    if file is None:
        return False
    path = Path(file).resolve()
    return path == place.with_suffix(".py") or path.is_relative_to(place)


def failed(error: BaseException, path: Path, what: str = "", named: str = "") -> str:
    """An error of somebody's code in one line: the file, the line in it, `what` was called, and what went wrong.

    The file is called by its name, or as it is `named`.
    """
    line = line_in(error, path)
    if isinstance(error, SyntaxError):
        said = f"is no Python ({error.msg})"
    else:
        text = " ".join(str(error).split())
        said = f"{type(error).__name__}: {text}" if text else type(error).__name__
        if isinstance(error, SystemExit):
            said = f"calls sys.exit: {text}" if isinstance(error.code, str) else "calls sys.exit"
    return f"{named or path.name}{f', line {line}' if line else ''}: {f'{what}: ' if what else ''}{said}"


def line_in(error: BaseException, path: Path) -> int | None:
    """The line of a file at which its code failed; None where the error comes from elsewhere."""
    if isinstance(error, SyntaxError) and error.lineno and _same(error.filename, path):
        return error.lineno
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if _same(frame.filename, path)]
    return lines[-1] if lines else None


def _same(name: str | None, path: Path) -> bool:
    return name is not None and Path(name).resolve() == path.resolve()
