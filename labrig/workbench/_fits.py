"""Which model files are meant for a run: both know the same chambers and observables by name.

What a file does not say is not held against it: a line or a parabola is fitted to whatever it meets, and a function of
one's own has no names. A wrong one of these is told when it is compared.
"""

import os
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from labrig._errors import LabrigError
from labrig._own_code import USER_FOLDER
from labrig._yaml import read_yaml
from labrig.log import read_run_yaml
from labrig.rig import RigConfig

_MADE = "-model"
"""The workbench calls a model that it makes for a run by the run's name with this behind it."""
_AXES = (".x", ".y", ".z")
_NAMED = 4
_WRONG = (LabrigError, OSError, KeyError, TypeError, AttributeError)
"""What a file raises that is not as it should be."""


class Names(NamedTuple):
    """What a run or a rig calls its chambers, its markers and its observables."""

    chambers: tuple[str, ...]
    markers: tuple[str, ...]
    observables: tuple[str, ...]


def names_of(run: Path) -> Names | None:
    """The names in a run's run.yaml; None where it has none (a log alone), and all models may fit."""
    try:
        return _names(str(run), (run / "run.yaml").stat().st_mtime_ns)
    except OSError:
        return None


@lru_cache(maxsize=256)
def _names(folder: str, _changed_ns: int) -> Names | None:
    run = Path(folder)
    try:
        facts = read_run_yaml(run)
        if (rig := facts.get("rig")) and rig.get("chambers"):
            markers = tuple(map(str, rig.get("markers") or ()))
            chambers = tuple(str(chamber["name"]) for chamber in rig["chambers"])
            return Names(chambers, markers, tuple(f"{marker}{axis}" for marker in markers for axis in _AXES))
        if mapping := facts.get("mapping"):
            seen = mapping.get("observables") or []
            return Names(
                tuple(_name(each) for each in mapping.get("actuation") or []),
                tuple(dict.fromkeys(str(each["marker"]) for each in seen if each.get("marker"))),
                tuple(_name(each) for each in seen),
            )
    except _WRONG:
        return None
    return None


def names_of_rig(config: RigConfig) -> Names:
    """The names that a run on a rig will have; a rig that is simulated may know its markers only when it runs."""
    markers = tuple(config.markers)
    observables = tuple(f"{marker}{axis}" for marker in markers for axis in _AXES)
    return Names(tuple(chamber.name for chamber in config.chambers), markers, observables)


def misfit(model: Path, run: Names | None, runs_of_its_name: Iterable[Path] = ()) -> str:
    """Why a model is not one of this run, in words; empty where nothing says so.

    `runs_of_its_name` are runs that it may have been made for, by its name: one of them decides for a bare map.
    """
    if run is None:
        return ""
    try:
        content = _read(str(model), model.stat().st_mtime_ns)
        known, kind = _known(content, model.parent), content["base"]["kind"]
    except _WRONG:
        return ""  # said when it is opened
    for chambers, observables in known:
        if chambers and set(chambers) != set(run.chambers):
            return f"{model.name} is for {_list('chamber', chambers)}; the rig has {_list('chamber', run.chambers)}"
        if run.observables and (other := [name for name in observables if name not in run.observables]):
            return f"{model.name} is for {_list('observable', other)}, which the rig does not have"
    if known or kind != "static":
        return ""
    others = [names for path in runs_of_its_name if (names := names_of(path)) is not None]
    if others and not any(set(o.chambers) == set(run.chambers) and _alike(o, run) for o in others):
        return f"{model.name} was made for another run, of another rig"
    return ""


def says_it_fits(model: Path, run: Names) -> bool:
    """Whether a model names chambers, and they and its observables are the run's."""
    try:
        content = _read(str(model), model.stat().st_mtime_ns)
        known = _known(content, model.parent)
    except _WRONG:
        return False
    return any(chambers for chambers, _ in known) and not misfit(model, run)


def unreadable(model: Path) -> str:
    """Why a model cannot be opened, in words, as far as that is seen without computing; empty where nothing says so."""
    try:
        base = _read(str(model), model.stat().st_mtime_ns)["base"]
        named, _ = base.get("file") or base.get("rig"), base["kind"]
        lost = named is not None and not (model.parent / str(named)).exists()
    except LabrigError as error:
        return str(error).removeprefix(f"{model.parent}{os.sep}")
    except _WRONG:
        return f"{model.name} does not say which kind of base it has"
    return f"{model.name} names {named}, which is not there" if lost else ""


def base_kind(model: Path) -> str:
    """The kind of a model's base; empty where the file does not say it."""
    try:
        return str(_read(str(model), model.stat().st_mtime_ns)["base"]["kind"])
    except _WRONG:
        return ""


def effects_in(model: Path) -> int:
    """How many effects a model has: one that was improved has more than the one before."""
    try:
        return len(_read(str(model), model.stat().st_mtime_ns).get("effects") or [])
    except _WRONG:
        return 0


def base_file(model: Path) -> Path | None:
    """The file in which a model's base is: a Python function, a network, an FMU; None for other bases."""
    try:
        base = _read(str(model), model.stat().st_mtime_ns)["base"]
        return model.parent / str(base["file"]) if base.get("file") else None
    except _WRONG:
        return None


def base_rig(model: Path) -> Path | None:
    """The rig's file that a model's base simulates; None for other bases."""
    try:
        base = _read(str(model), model.stat().st_mtime_ns)["base"]
        return model.parent / str(base["rig"]) if base.get("rig") else None
    except _WRONG:
        return None


def own_effects(*folders: Path) -> list[Path]:
    """The files with effects of people's own that are known beside a model in, and to commands of, these folders."""
    return [file for folder in folders for file in (folder / USER_FOLDER).glob("*.py")]


def made_for(model: Path) -> str:
    """The name of the run that the workbench made a model for; empty where its name says no such thing."""
    return model.stem.removesuffix(_MADE) if model.stem.endswith(_MADE) else ""


def _alike(one: Names, other: Names) -> bool:
    return not one.observables or not other.observables or set(one.observables) == set(other.observables)


def _known(content: dict[str, Any], folder: Path) -> list[tuple[tuple[str, ...], tuple[str, ...]]]:
    """Chambers and observables that a model names, place by place; () where a place says nothing of them."""
    base, known = content["base"], []
    if base["kind"] == "simulator":
        rig = read_yaml(folder / str(base["rig"]), "rig")
        known.append((tuple(_name(each) for each in rig.get("chambers") or []), ()))
    elif base["kind"] == "fmu":
        known.append((tuple(map(str, base["inputs"])), ()))
    for effect in content.get("effects") or []:
        per = [str(n) for value in (effect.get("parameters") or {}).values() for n in value.get("per") or []]
        chambers = tuple(map(str, (effect.get("fitted_on") or {}).get("chambers") or []))
        observables = tuple(dict.fromkeys(name for name in per if name.endswith(_AXES)))
        if chambers or observables:
            known.append((chambers, observables))
    return known


@lru_cache(maxsize=256)
def _read(path: str, _changed_ns: int) -> dict[str, Any]:
    return read_yaml(Path(path), "model")  # not as a model: what reads that would compute in the server


def _name(column: Any) -> str:
    return str(column.get("name") or column.get("column"))


def _list(what: str, names: Iterable[str]) -> str:
    all_ = list(names)
    more = f" and {len(all_) - _NAMED} more" if len(all_) > _NAMED else ""
    return f"{what}{'s' if len(all_) > 1 else ''} {', '.join(all_[:_NAMED])}{more}"
