"""Shell files: the geometry, materials and chambers of an inflated surface, in YAML, checked."""

from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from labrig._errors import LabrigError
from labrig._fields import check_fields
from labrig._yaml import read_yaml
from labrig.physics._geometry import grid_points, spread_points
from labrig.physics._quantity import Unit, convert
from labrig.physics._shell_core import Core, Millimetres, Section

Kilopascal = Annotated[float, Unit("kPa")]
Stiffness = Annotated[float, Unit("kPa/mm")]


class Layer(Section):
    """One sheet: shear modulus, thickness, the stretch it was put on with, stiffening with strain, density."""

    modulus: Kilopascal = Field(gt=0)
    thickness: Millimetres = Field(gt=0)
    prestretch: float = Field(default=1.0, gt=0.5, lt=2.0)
    stiffening: float = Field(default=1.0, gt=0.0, le=20.0)
    density: Annotated[float, Unit("kg/m^3")] = Field(default=1100.0, ge=0)


class Gravity(Section):
    """Which way is down, and how strongly."""

    acceleration: Annotated[float, Unit("m/s^2")] = 9.81
    direction: tuple[float, float, float] = (0.0, 0.0, -1.0)

    @field_validator("direction")
    @classmethod
    def _pointing(cls, value: tuple[float, float, float]) -> tuple[float, float, float]:
        if not np.linalg.norm(value) > 0:
            raise ValueError("a direction must not be zero")
        return value


class ShellChamber(Section):
    """A soft-edged patch of the unit square under layer 1 (on the core) or layer 2 (between the layers).

    `share` is the part of the patch's area that the air bears on; `edge` the width of its soft edge in (u, v).
    """

    name: str = Field(min_length=1)
    layer: Literal[1, 2] = 1
    u: tuple[float, float]
    v: tuple[float, float]
    edge: float = Field(default=0.012, gt=0)
    share: float = Field(default=1.0, gt=0, le=1.0)
    max: Kilopascal = Field(default=60.0, gt=0)

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not (self.u[0] < self.u[1] and self.v[0] < self.v[1]):
            raise ValueError("u and v are ranges, from low to high")
        for name, (low, high) in (("u", self.u), ("v", self.v)):
            width = min(high, 1.0) - max(low, 0.0)
            if width <= 0.0:
                raise ValueError(
                    f"{name} from {low:g} to {high:g} lies off the surface, which goes from 0 to 1: no air bears on it"
                )
            if width < self.edge:
                raise ValueError(
                    f"{name} from {low:g} to {high:g}: {width:.3g} of it lies on the surface, less than its soft "
                    f"edge of {self.edge:g}: make it wider, or its edge narrower"
                )
        return self


class MarkerGrid(Section):
    """`columns` x `rows` markers, or `spread` of them evenly spread, m01 first; `margin` away from the border."""

    columns: int = Field(default=0, ge=0)
    rows: int = Field(default=0, ge=0)
    spread: int = Field(default=0, ge=0)
    margin: float = Field(default=0.08, ge=0, lt=0.5)

    def places(self) -> dict[str, tuple[float, float]]:
        """(u, v) by name."""
        if self.spread:
            points = spread_points(self.spread, self.margin)
        else:
            points = grid_points(self.columns, self.rows, self.margin)
        return {f"m{i + 1:02d}": (float(u), float(v)) for i, (u, v) in enumerate(points)}


class ShellFile(Section):
    """All of a shell. Bare numbers are mm, kPa and their kin; texts carry a unit (`0.525 MPa`)."""

    name: str = Field(min_length=1)
    control_points: tuple[int, int] = (30, 30)
    degree: int = Field(default=2, ge=2, le=3)
    border: Literal["hinged", "clamped"] = "hinged"
    core: Core
    core_offset: Millimetres = 0.0
    layers: tuple[Layer, ...] = Field(min_length=1, max_length=2)
    seam: Stiffness = Field(default=45.0, ge=0)
    adhesion: Stiffness = Field(default=0.15, ge=0)
    contact: Stiffness = Field(default=75.0, ge=0)
    gravity: Gravity = Gravity()
    chambers: tuple[ShellChamber, ...] = Field(min_length=1)
    markers: MarkerGrid | dict[str, tuple[float, float]] = MarkerGrid(spread=34)
    bounds: dict[str, tuple[Any, Any]] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = [chamber.name for chamber in self.chambers]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"chamber {twice[0]} is named twice")
        for chamber in self.chambers:
            if chamber.layer > len(self.layers):
                raise ValueError(
                    f"chamber {chamber.name} lies under layer {chamber.layer}, there is one layer"
                )
        if min(self.control_points) < self.degree + 4:
            raise ValueError(f"control_points: at least {self.degree + 4} in each direction are needed")
        if not self.marker_places:
            raise ValueError(
                "markers: there are none: columns and rows are one or more each, or spread is; or name some places"
            )
        for name, place in self.marker_places.items():
            if not all(0.0 <= x <= 1.0 for x in place):
                raise ValueError(f"marker {name} lies outside the unit square")
        return self

    @property
    def marker_places(self) -> dict[str, tuple[float, float]]:
        """(u, v) of each marker."""
        return self.markers.places() if isinstance(self.markers, MarkerGrid) else dict(self.markers)

    def content(self) -> dict[str, Any]:
        """What a YAML file of this shell holds, every default and unit written out, files included."""
        return self.model_dump(mode="json")


def shipped_shells() -> tuple[str, ...]:
    """The names of the shells that come with labrig."""
    folder = resources.files("labrig.physics") / "shells"
    return tuple(sorted(f.name.removesuffix(".yaml") for f in folder.iterdir() if f.name.endswith(".yaml")))


def read_shell(source: str | Path | dict[str, Any]) -> ShellFile:
    """A shell from a shipped name, the path of a YAML file, or the content of one.

    Raises `LabrigError` naming the file, the field and what is wrong with it.
    """
    if isinstance(source, dict):
        return _parse(source, "shell", Path(), None)
    if str(source) in shipped_shells():
        path = Path(str(resources.files("labrig.physics") / "shells" / f"{source}.yaml"))
    else:
        path = Path(source)
    content = read_yaml(path, "shell", f" (shipped shells: {', '.join(shipped_shells())})")
    return _parse(content, str(path), path.resolve().parent, path)


def _parse(content: dict[str, Any], where: str, folder: Path, path: Path | None) -> ShellFile:
    core = content.get("core")
    if isinstance(core, dict) and isinstance(core.get("control_points"), str):
        content = {**content, "core": _with_points(core, where, folder)}
    return check_fields(ShellFile, content, where, path)


def _with_points(core: dict[str, Any], where: str, folder: Path) -> dict[str, Any]:
    """A spline core with the control points of its file written out."""
    path = folder / core["control_points"]
    try:
        with np.load(path, allow_pickle=False) as arrays:
            points = np.asarray(arrays["control_points"], dtype=float)
    except (OSError, KeyError, ValueError) as error:
        raise LabrigError(
            f"{where}: core.control_points: {path} holds no array 'control_points' ({error})"
        ) from None
    if points.ndim != 3 or points.shape[-1] != 3:
        raise LabrigError(
            f"{where}: core.control_points: {path}: control_points are {points.shape}, not (n_u, n_v, 3)"
        )
    return {"kind": "spline", **core, "control_points": points.tolist()}


__all__ = ["Layer", "ShellChamber", "ShellFile", "convert", "read_shell", "shipped_shells"]
