"""Which targets, models and rigs there are for a shape: those of the folder, and those beside the rig's file."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypedDict

from labrig._errors import LabrigError
from labrig.workbench._desk import Desk
from labrig.workbench._fits import base_kind, unreadable
from labrig.workbench._models import folders_below, is_model
from labrig.workbench._rig_files import rigs_in
from labrig.workbench._shape_work import size_of
from labrig.workbench._uploads import free_name

SHAPES = frozenset({".ply", ".stl", ".obj", ".xyz"})
"""How the names of targets end."""
TARGETS = "targets"
"""The folder below the desk's in which an uploaded target is kept."""
_LEARNED = ".pt"
_SURFACES = ("simulator", "surrogate")
"""Kinds of a model file's base that have a surface."""
_LEVELS = 3
_MOST = 400


class TakenTarget(TypedDict):
    """An uploaded target: its name in the folder, and what it holds, in words."""

    target: str
    about: str


def targets_of(desk: Desk) -> list[str]:
    """The files of the folder, of its sub-folders that are no runs, and beside the rig, that may be targets."""
    return _names(desk, (path for path in _files(desk) if path.suffix.lower() in SHAPES))


def models_of_shapes(desk: Desk) -> list[dict[str, str]]:
    """The models that have a surface, and why one of them cannot be used (`why`, empty where nothing is known)."""
    found = [path for path in _files(desk) if path.suffix == _LEARNED or _has_surface(path)]
    by_name = {name: desk.folder / name for name in _names(desk, found)}
    return [
        {"name": name, "why": "" if path.suffix == _LEARNED else unreadable(path)}
        for name, path in by_name.items()
    ]


def rigs_of_shapes(desk: Desk) -> list[str]:
    """The rigs whose limits may hold: the one that the workbench was started for, and those of the folder."""
    own = [] if desk.rig_file is None else [typed(desk, desk.rig_file)]
    return [name for name in dict.fromkeys([*own, *rigs_in(desk)]) if not name.startswith("-")]


def chosen(desk: Desk, name: Any, offered: list[str], what: str) -> Path:
    """The file that a page names, of those that it was offered; raises `LabrigError` for every other one.

    So a file outside the folder can be reached only where it lies beside the rig's.
    """
    if not name:
        raise LabrigError(f"choose {what}")
    if name not in offered:
        raise LabrigError(f"{name}: is not there any more; choose {what} of the list")
    return desk.folder / str(name)


def taken(desk: Desk, path: Path) -> TakenTarget:
    """An uploaded target is put into `targets`, under a name that is free.

    Raises `LabrigError`, and keeps nothing, where it cannot be read.
    """
    try:
        if path.suffix.lower() not in SHAPES:
            raise LabrigError(f"{path.name}: a target is a mesh (OBJ, PLY, STL) or points (XYZ)")
        about = desk.worker.ask(size_of, str(path))
        folder = desk.folder / TARGETS
        folder.mkdir(exist_ok=True)
        name = free_name(folder, path.stem, path.suffix.lower()) + path.suffix.lower()
        path.rename(folder / name)
    except LabrigError as error:
        raise LabrigError(str(error).replace(str(path), path.name)) from None
    finally:
        shutil.rmtree(path.parent, ignore_errors=True)
    return {"target": f"{TARGETS}/{name}", "about": about}


def _files(desk: Desk) -> Iterator[Path]:
    """The files that are looked at, those nearest first."""
    places = [desk.folder]
    beside = desk.rig_file.parent if desk.rig_file is not None else desk.folder
    if not beside.is_relative_to(desk.folder):
        places.append(beside)
    for place in [*places, *folders_below(desk.folder, _LEVELS)]:
        try:
            yield from sorted(
                path for path in place.iterdir() if path.is_file() and not path.name.startswith(".")
            )
        except OSError:
            continue


def _has_surface(path: Path) -> bool:
    return path.suffix in (".yaml", ".yml") and is_model(path) and base_kind(path) in _SURFACES


def _names(desk: Desk, paths: Any) -> list[str]:
    names = dict.fromkeys(typed(desk, path) for path in paths)
    return [name for name in names if not name.startswith("-")][:_MOST]  # which commands take for an option


def typed(desk: Desk, path: Path) -> str:
    """As its pages and commands call a file: below the folder with `/`, elsewhere by its whole path."""
    return path.relative_to(desk.folder).as_posix() if path.is_relative_to(desk.folder) else str(path)
