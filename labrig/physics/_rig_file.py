"""The part of a rig.yaml that its simulator is made of, checked as far as that goes; devices are not looked at."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict

from labrig._errors import LabrigError
from labrig._fields import check_fields
from labrig._yaml import read_yaml


class _Open(BaseModel):
    model_config = ConfigDict(extra="allow")


class _Chamber(_Open):
    name: str
    max_kpa: float = 60.0


class _Simulated(_Open):
    surface: str | None = None


class _Rig(_Open):
    chambers: list[str | _Chamber] | None = None
    markers: list[str | int] | None = None
    simulated: _Simulated | None = None


def read_rig_file(path: Path) -> dict[str, Any]:
    """The content of a rig.yaml for `load_surface` and `rig_shell`; raises `LabrigError` with file, line and field."""
    content = read_yaml(path, "rig of the simulator")
    check_fields(_Rig, content, str(path), path)
    return content


@contextmanager
def of_rig_file(path: Path) -> Iterator[None]:
    """Complaints about a rig's content name the file that it was read from."""
    try:
        yield
    except LabrigError as error:
        said = str(error)
        if not said.startswith("rig: "):
            raise
        raise LabrigError(f"{path}: {said.removeprefix('rig: ')}") from None


def has_shell(rig: dict[str, Any]) -> bool:
    """Whether a rig's simulator is a shell: unless `simulated: {surface: ...}` names a reduced one."""
    return "surface" not in (rig.get("simulated") or {})


def places_of(names: Sequence[str], own: Sequence[str]) -> list[int]:
    """Which of a simulator's `own` chambers each of a rig's is: by name where all names are the same, else in order."""
    return [own.index(name) for name in names] if sorted(names) == sorted(own) else list(range(len(own)))
