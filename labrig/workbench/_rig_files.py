"""The rig files of the folder: how each is opened, and the form that stands for it where one can hold all of it."""

import re
from collections.abc import Sequence
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

from labrig._errors import LabrigError
from labrig._yaml import read_yaml
from labrig.rig import check_rig
from labrig.workbench._desk import Desk
from labrig.workbench._rig_check import check_paths
from labrig.workbench._rig_form import HEAD, Form, content_of, form_of, same
from labrig_drivers import register_maps

MAP = ("kpa_per_count", "setpoint")
"""Names at the beginning of lines by which a register map is known."""
SHELL = ("control_points", "layers", "chambers")
"""The same of a shell."""
_RIG = ("chambers", "pressure")
_PLACES = ("*.yaml", "*/rig.yaml")
_MOST_FILES = 30
_MOST_BYTES = 200_000


def files_like(desk: Desk, names: Sequence[str], places: Sequence[str] = _PLACES[:1]) -> list[str]:
    """The YAML files of the folder that have these names at the beginning of lines."""
    found = [path for place in places for path in sorted(desk.folder.glob(place)) if _is_like(path, names)]
    inside = [path for path in found if path.resolve().is_relative_to(desk.folder)]
    return [path.relative_to(desk.folder).as_posix() for path in inside[:_MOST_FILES]]


def is_rig(path: Path) -> bool:
    """Whether a file is meant as a rig's: it has chambers and what sets their pressure."""
    return _is_like(path, _RIG)


def is_simulated_file(path: Path) -> bool:
    """Whether a rig's file says what of it can be simulated."""
    return _is_like(path, ("chambers", "simulated"))


def _is_like(path: Path, names: Sequence[str]) -> bool:
    try:
        with path.open("rb") as file:
            head = file.read(_MOST_BYTES)
    except OSError:
        return False
    return all(re.search(rf"^{name}\s*:".encode(), head, re.MULTILINE) for name in names)


def commands(desk: Desk, name: str) -> dict[str, str]:
    """What is typed to look at the devices of a rig file, and to open the workbench for it."""
    return {
        "look": desk.command(["rig", "check", name, "--still"]),
        "open": desk.command(["workbench", ".", "--rig", name]),
    }


def rigs_of(desk: Desk) -> list[dict[str, str]]:
    """Every rig file of the folder: its name, its commands, and why the form cannot hold it, if it cannot."""
    return [{"file": name, "why": _why_not(desk, name), **commands(desk, name)} for name in rigs_in(desk)]


def rigs_in(desk: Desk) -> list[str]:
    """The rig files of the folder, by their names."""
    return files_like(desk, _RIG, _PLACES)


def _why_not(desk: Desk, name: str) -> str:
    try:
        _held(desk, name)
    except LabrigError as error:
        return str(error).removeprefix(str(desk.folder / name)).lstrip(":, ")
    except OSError as error:
        return error.strerror or "it cannot be read"
    return ""


def begun_from(desk: Desk, name: str) -> dict[str, Any]:
    """The form that stands for a rig file of the folder, as a file beside it in the folder itself would have it.

    Raises `LabrigError` where it is none of the folder's, or the form cannot hold all of it.
    """
    if name not in rigs_in(desk):
        raise LabrigError(f"{name or 'no file'}: is no rig file of {desk.folder}")
    return {"form": _held(desk, name), "remarks": _comments(desk.folder / name, name)}


def _held(desk: Desk, name: str) -> Form:
    """The form that stands for a rig file; raises `LabrigError` where something of it would be lost."""
    path = desk.folder / name
    if path.stat().st_size > _MOST_BYTES:
        raise LabrigError("it is larger than what the form holds")
    content = read_yaml(path, "rig")
    form = form_of(content)
    moved = _moved(form, PurePosixPath(name).parent, path.parent)
    check_paths(desk, content_of(moved))
    before = check_rig(content, str(path), path.resolve().parent, path)
    if not same(before, check_rig(content_of(form), str(path), path.resolve().parent)):
        raise LabrigError("the form would lose something of it")
    return moved


def _moved(form: Form, parent: PurePosixPath, folder: Path) -> Form:
    """The form with its relative paths, which start from the folder of its file, as the desk's folder has them."""
    from labrig.physics import shipped_shells  # which computes: not before somebody asks

    if parent == PurePosixPath("."):
        return form

    def moved(text: str) -> str:
        absolute = PurePosixPath(text).is_absolute() or PureWindowsPath(text).is_absolute()
        return text if absolute or not text else (parent / text.replace("\\", "/")).as_posix()

    pressure, scanner, simulated = dict(form["pressure"]), dict(form["scanner"]), dict(form["simulated"])
    brought = pressure.get("map") in register_maps() and not (folder / pressure["map"]).is_file()
    if "map" in pressure and not brought:
        pressure["map"] = moved(pressure["map"])
    if "folder" in scanner:
        scanner["folder"] = moved(scanner["folder"])
    kind, _, shell = simulated["body"].partition(":")
    if kind == "shell" and shell not in shipped_shells():
        simulated["body"] = f"shell:{moved(shell)}"
    return {**form, "pressure": pressure, "scanner": scanner, "simulated": simulated}


def _comments(path: Path, name: str) -> list[str]:
    """That what somebody wrote beside the settings does not come along."""
    lines = path.read_text(encoding="utf-8").removeprefix(HEAD).splitlines()
    has = any(re.search(r"(^|\s)#", line) for line in lines)
    return [f"the comments in {name} stay there: the new file has none of them"] if has else []
