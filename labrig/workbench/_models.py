"""Which models there are for a run: those that lie with it, beside the rig's file, and elsewhere in the folder."""

import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from labrig.log import segment_paths
from labrig.workbench._desk import Desk
from labrig.workbench._fits import Names, made_for, misfit, names_of, names_of_rig, says_it_fits, unreadable
from labrig.workbench._planned import planned_for

_MODEL = re.compile(rb"^base\s*:", re.MULTILINE)
_OTHERS = ("run.yaml", "rig.yaml", "notes.yaml")
_HEAD_BYTES = 4096
_MOST_FOLDERS = 300
"""Folders that are looked into for models that lie elsewhere."""


def models_of(desk: Desk, run: Path, names: Names | None = None) -> list[Path]:
    """The model files for a run that fit it and can be read: those near it, the nearest first, and those elsewhere.

    Before them comes the one that the run was planned for. `names` are for a run that has only begun.
    """
    near = near_models(desk, run, names)
    return [path for path in [*near, *far_models(desk, run, near, names)] if not unreadable(path)]


def near_models(desk: Desk, run: Path, names: Names | None = None) -> list[Path]:
    """The model files that lie with a run, beside it or above it in the folder, in `models`, or beside the file of its
    rig, and fit it, as far as they say; those that cannot be read are among them.
    """
    planned, names = planned_for(desk, run), names_of(run) or names
    places = [*_above(desk, run), desk.folder / "models"]
    places += [planned.parent] if planned is not None else []
    places += [desk.rig_file.parent] if desk.rig_file is not None and _is_of_rig(desk, names) else []
    found: dict[Path, None] = {}
    for place in places:
        found |= dict.fromkeys(_in(place))
    first = {planned: None} if planned is not None else {}
    return [path for path in first | found if path == planned or not misfit(path, names, named(desk, path))]


def far_models(desk: Desk, run: Path, near: list[Path], names: Names | None = None) -> list[Path]:
    """The models in other folders, two levels deep, as an investigation or a demo leaves them, that name the run's
    chambers: of what names none, so far off, nobody knows whether it is meant.
    """
    names = names_of(run) or names
    if names is None:
        return []
    found = [path for place in folders_below(desk.folder, 2) for path in _in(place) if path not in near]
    return [path for path in found if says_it_fits(path, names)]


def is_model(path: Path) -> bool:
    """Whether a file is meant as a model: it names a base."""
    try:
        with path.open("rb") as file:
            return _MODEL.search(file.read(_HEAD_BYTES)) is not None
    except OSError:
        return False


def named(desk: Desk, model: Path) -> list[Path]:
    """The runs that a model may have been made for, by its name, wherever they lie in the folder."""
    name = made_for(model)
    places = (desk.folder / name, *(p / name for p in desk.folder.iterdir()), model.parent / name)
    return list(dict.fromkeys(place for place in places if name and (place / "run.yaml").is_file()))


def results_name(desk: Desk, run: Path, model: Path) -> str:
    """What the folder of the results of a run and a model is called: by the model's name, of one that lies elsewhere by
    its folders, too, for another model may have the same name.
    """
    near = (*_above(desk, run), desk.folder / "models")
    if model.parent in near or not model.is_relative_to(desk.folder):
        return model.stem
    return "-".join(model.relative_to(desk.folder).with_suffix("").parts)


def _above(desk: Desk, run: Path) -> list[Path]:
    return [run, *(p for p in run.parents if p.is_relative_to(desk.folder))]


def _in(place: Path) -> list[Path]:
    """The model files in a folder, those with short names first."""
    own = [path for path in place.glob("*.yaml") if path.name not in _OTHERS and is_model(path)]
    return sorted(own, key=lambda path: (len(path.name), path.name))


def _is_of_rig(desk: Desk, names: Names | None) -> bool:
    """Whether a run is of the desk's rig, as far as chambers say, and the rig's file lies in the folder."""
    rig = desk.known_rig()
    if rig is None or desk.rig_file is None or not desk.rig_file.is_relative_to(desk.folder):
        return False
    return names is None or set(names.chambers) == set(names_of_rig(rig).chambers)


def folders_below(folder: Path, levels: int) -> Iterator[Path]:
    """The folders below one that are no runs, those with dots and links left out; a bounded number of them."""
    return islice(_below(folder, levels), _MOST_FOLDERS)


def _below(folder: Path, levels: int) -> Iterator[Path]:
    try:
        inside = sorted(path for path in folder.iterdir() if path.is_dir() and not path.is_symlink())
    except OSError:
        return
    for path in inside:
        if path.name.startswith(".") or (path / "run.yaml").exists() or segment_paths(path):
            continue
        yield path
        if levels > 1:
            yield from _below(path, levels - 1)
