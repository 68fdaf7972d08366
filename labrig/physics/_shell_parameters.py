"""The physical parameters of a shell: their names, units, bounds, and where in its file they stand."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from labrig._errors import LabrigError
from labrig.physics._shell_file import ShellFile, convert


@dataclass(frozen=True)
class ShellParameter:
    """One physical parameter: its value, unit ("" for none), and the bounds within which it makes sense."""

    value: float
    unit: str
    low: float
    high: float


@dataclass(frozen=True)
class _Kind:
    """Where a parameter stands in a file, its unit, and its bounds: of its value, or absolute."""

    path: tuple[str | int, ...]
    unit: str
    factors: tuple[float, float] | None = (0.5, 2.0)
    range: tuple[float, float] = (0.0, 0.0)


def _kinds(file: ShellFile) -> dict[str, _Kind]:
    kinds: dict[str, _Kind] = {}
    for i in range(len(file.layers)):
        kinds[f"modulus_{i + 1}_kpa"] = _Kind(("layers", i, "modulus"), "kPa")
        kinds[f"thickness_{i + 1}_mm"] = _Kind(("layers", i, "thickness"), "mm")
        kinds[f"prestretch_{i + 1}"] = _Kind(("layers", i, "prestretch"), "", None, (1.0, 1.25))
        kinds[f"stiffening_{i + 1}"] = _Kind(("layers", i, "stiffening"), "", (0.2, 3.0))
    kinds["core_offset_mm"] = _Kind(("core_offset",), "mm", None, (-5.0, 5.0))
    kinds["seam_kpa_per_mm"] = _Kind(("seam",), "kPa/mm", (0.1, 10.0))
    kinds["adhesion_kpa_per_mm"] = _Kind(("adhesion",), "kPa/mm", (0.1, 10.0))
    kinds["contact_kpa_per_mm"] = _Kind(("contact",), "kPa/mm", (0.1, 10.0))
    kinds["gravity_m_per_s2"] = _Kind(("gravity", "acceleration"), "m/s^2", None, (-20.0, 20.0))
    for i, chamber in enumerate(file.chambers):
        kinds[f"share_{chamber.name}"] = _Kind(("chambers", i, "share"), "", None, (0.2, 1.0))
    return kinds


def read_parameters(file: ShellFile) -> dict[str, ShellParameter]:
    """All parameters of a shell by name; raises `LabrigError` for bounds of a parameter that it has not."""
    kinds = _kinds(file)
    for name in file.bounds:
        if name not in kinds:
            raise LabrigError(f"shell {file.name}: bounds: {_unknown(name, kinds)}")
    found = {}
    for name, kind in kinds.items():
        value: Any = file
        for step in kind.path:
            value = value[step] if isinstance(step, int) else getattr(value, step)
        low, high = (f * value for f in kind.factors) if kind.factors else kind.range
        if name in file.bounds:
            try:
                low, high = (convert(x, kind.unit or "1") for x in file.bounds[name])
            except ValueError as error:
                raise LabrigError(f"shell {file.name}: bounds.{name}: {error}") from None
        found[name] = ShellParameter(float(value), kind.unit, float(low), float(high))
    return found


def with_parameters(content: dict[str, Any], file: ShellFile, values: Mapping[str, float]) -> dict[str, Any]:
    """The content of a shell file with some parameters at other values; raises `LabrigError` for unknown ones."""
    kinds = _kinds(file)
    for name, value in values.items():
        if name not in kinds:
            raise LabrigError(f"shell {file.name}: {_unknown(name, kinds)}")
        *above, last = kinds[name].path
        place: Any = content
        for step in above:
            place = place[step]
        place[last] = float(value)
    return content


def _unknown(name: str, known: Mapping[str, object]) -> str:
    return f"there is no parameter '{name}' (it has {', '.join(known)})"
