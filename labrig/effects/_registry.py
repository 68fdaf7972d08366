"""Which effects there are: labrig's own, and those that a user wrote."""

import importlib
import inspect
import pkgutil
from collections.abc import Collection, Iterator
from functools import cache
from pathlib import Path
from typing import get_args

from labrig._errors import LabrigError
from labrig._near import meant
from labrig._own_code import USER_FOLDER, load_module
from labrig._text import listed
from labrig.effects._effect import Acts, Effect, Parameter
from labrig.effects._own import Unreadable, checked, unreadable


@cache
def shipped() -> dict[str, Effect]:
    """The effects that come with labrig, by name."""
    package = importlib.import_module("labrig.effects")
    names = [m.name for m in pkgutil.iter_modules(package.__path__) if not m.name.startswith("_")]
    found = {}
    for name in names:
        for effect in _effects_in(importlib.import_module(f"labrig.effects.{name}")):
            found[effect.name] = effect
    return found


def library(*folders: Path) -> dict[str, Effect]:
    """Every effect by name: labrig's own and those in the `effects` folder of each of `folders`.

    A user's file that can't be read as an effect stands in it by its own name, and fails when it is asked for its
    forms: so a diagnosis goes on without it, and says so. Raises `LabrigError` where two effects have one name.
    """
    found = dict(shipped())
    for folder in dict.fromkeys([Path.cwd(), *folders]):
        file_of: dict[str, Path] = {}
        for effect, file in _own_effects(folder):
            if effect.name in shipped():
                raise LabrigError(
                    f"{file}: labrig has an effect named {effect.name!r} already; give yours another name"
                )
            if other := file_of.get(effect.name):
                raise LabrigError(
                    f"{file}: {other.name} has an effect named {effect.name!r} already; give one another name"
                )
            found[effect.name], file_of[effect.name] = effect, file
    return found


def _own_effects(folder: Path) -> Iterator[tuple[Effect, Path]]:
    """The user's effects in a folder, each with its file."""
    for file in sorted((folder / USER_FOLDER).glob("*.py")):
        if not file.name.startswith("_"):
            try:
                found = _effects_in(load_module(file, f"labrig_user_effects_{file.stem}"), file)
            except LabrigError as error:
                found = [unreadable(file, str(error))]
            for effect in found:
                yield effect, file


def take_along(names: Collection[str], source: Path, target: Path) -> None:
    """Copy a user's effects of these names to the `effects` of another folder, with what lies beside them, which they
    may import; a file that is there already stays as it is.
    """
    for folder in (source, Path.cwd()) if set(names) - shipped().keys() else ():
        if {effect.name for effect, _ in _own_effects(folder)}.isdisjoint(names):
            continue
        there = target / USER_FOLDER
        there.mkdir(exist_ok=True)
        for file in (folder / USER_FOLDER).glob("*.py"):
            if not (there / file.name).exists():
                (there / file.name).write_bytes(file.read_bytes())


def get(name: str, *folders: Path) -> Effect:
    """The effect called `name`; raises `LabrigError` that lists what there is."""
    found = library(*folders)
    broken = [effect.meaning for effect in found.values() if isinstance(effect, Unreadable)]
    if name not in found:
        if broken:
            raise LabrigError(f"there is no effect {name!r}, and an effect's file can't be read: {broken[0]}")
        known = ", ".join(sorted(found))
        raise LabrigError(f"there is no effect {name!r}; choose one of: {known}{meant(name, found)}")
    return found[name]


def _effects_in(module: object, file: Path | None = None) -> list[Effect]:
    classes = [
        c
        for _, c in inspect.getmembers(module, inspect.isclass)
        if issubclass(c, Effect)
        and not inspect.isabstract(c)
        and c.__module__ == getattr(module, "__name__", "")
    ]
    for c in classes:
        for name in ("name", "meaning", "acts_on", "parameters", "reference", "signature", "experiment"):
            if not hasattr(c, name):
                raise LabrigError(f"{inspect.getfile(c)}: the effect {c.__name__} does not say its {name!r}")
        if c.acts_on not in get_args(Acts):
            there = f"there are {listed(get_args(Acts), 'and')}{meant(c.acts_on, get_args(Acts))}"
            raise LabrigError(
                f"{inspect.getfile(c)}: the effect {c.__name__}: acts_on is {c.acts_on!r}; {there}"
            )
        if not all(isinstance(p, Parameter) for p in c.parameters):
            raise LabrigError(
                f"{inspect.getfile(c)}: the effect {c.__name__}: `parameters` are no Parameters"
            )
        for p in c.parameters:
            if not all(isinstance(value, int | float) for value in (p.low, p.high, p.least)):
                what = f"the effect {c.__name__}: parameter {p.name!r}: low, high and least are numbers"
                raise LabrigError(f"{inspect.getfile(c)}: {what}")
    return [c() if file is None else checked(c, file)() for c in classes]
