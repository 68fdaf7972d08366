"""rig.yaml: which chambers, markers and devices a rig has, checked before anything is connected."""

import math
from numbers import Integral, Real
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from labrig._errors import LabrigError
from labrig._fields import FieldError, check_fields
from labrig._near import meant
from labrig._paths import path_of
from labrig._yaml import line_of, read_yaml
from labrig_drivers import SETTINGS, Channel


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class ChamberConfig(_Section):
    """One chamber and the limits that are checked before every write."""

    name: str = Field(min_length=1)
    min_kpa: float = Field(default=0.0, ge=-100.0, le=1000.0)
    max_kpa: float = Field(ge=-100.0, le=1000.0)
    slew_kpa_s: float = Field(default=100.0, gt=0.0)

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.min_kpa <= 0.0 <= self.max_kpa:
            raise ValueError("0 kPa (vented) must lie between min_kpa and max_kpa")
        return self


class DeviceConfig(BaseModel):
    """One device: its kind, and whatever that kind asks for."""

    model_config = ConfigDict(extra="allow", frozen=True)

    kind: str

    @property
    def options(self) -> dict[str, Any]:
        """Everything but the kind."""
        return dict(self.model_extra or {})


class SafetyConfig(_Section):
    """When labrig gives up and vents. A time that was meant in milliseconds is beyond its range.

    `vents_alone` says in words what vents the chambers when this computer is gone, if something does: a relay, a
    controller of its own. Without it, or a device with a watchdog, a run is not left unattended.
    """

    vent_timeout_s: float = Field(default=10.0, gt=0.0, le=600.0)
    vent_patience_s: float = Field(default=60.0, gt=0.0, le=3600.0)
    vented_kpa: float = Field(default=3.0, gt=0.0)
    stale_pressure_s: float = Field(default=1.0, gt=0.0, le=120.0)
    over_pressure_kpa: float = Field(default=5.0, gt=0.0)
    lost_mocap_s: float = Field(default=30.0, gt=0.0, le=3600.0)
    heartbeat_s: float = Field(default=2.0, ge=0.2, le=60.0)
    guard_patience_s: float = Field(default=3600.0, gt=0.0, le=7 * 24 * 3600.0)
    think_s: float = Field(default=60.0, gt=0.0, le=4 * 3600.0)
    vents_alone: str = ""


class FollowConfig(_Section):
    """How far a chamber may be from its set-point while it is recorded, and what happens when it is farther.

    It may be `tolerance_kpa` and `tolerance_share` of the set-point off: what is within, a regulator that is not exact
    or a small leak, is measured, and a diagnosis can name it; what is beyond is a fault of the rig. A capture that
    misses is taken again `repeats` times. Then the run vents and waits for a person (`pause`; where nobody can answer,
    it ends), goes on without counting the capture (`skip`), or ends (`abort`).
    """

    tolerance_kpa: float = Field(default=3.0, gt=0.0)
    tolerance_share: float = Field(default=0.25, ge=0.0, lt=1.0)
    repeats: int = Field(default=1, ge=0)
    on_miss: Literal["pause", "skip", "abort"] = "pause"


class RigConfig(_Section):
    """A rig as rig.yaml describes it; `folder` is where the file lies, for the paths in it."""

    name: str = Field(min_length=1)
    chambers: tuple[ChamberConfig, ...]
    markers: tuple[str, ...] = ()
    rest_mm: dict[str, tuple[float, float, float]] | None = None
    pressure: DeviceConfig
    mocap: DeviceConfig | None = None
    scanner: DeviceConfig | None = None
    simulated: dict[str, Any] | None = None
    follow: FollowConfig = FollowConfig()
    safety: SafetyConfig = SafetyConfig()
    folder: Path = Field(default=Path(), exclude=True)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if not self.chambers:
            raise ValueError("a rig needs at least one chamber")
        for what, names in (("chamber", [c.name for c in self.chambers]), ("marker", list(self.markers))):
            if twice := sorted({name for name in names if names.count(name) > 1}):
                raise ValueError(f"{what} {twice[0]} is named twice")
        if self.markers and self.mocap is None:
            raise ValueError("markers are named but there is no mocap device")
        simulated = any(device is not None and device.kind == "simulated" for device in self.devices.values())
        if simulated and self.simulated is None:
            raise ValueError(
                "a device is simulated, so a section `simulated` is needed (seed, noise_mm, ...)"
            )
        if self.simulated is not None:
            _check_simulated(self.simulated, self.chambers, self.folder, simulated)
        return self

    @property
    def channels(self) -> tuple[Channel, ...]:
        """The chambers as the drivers know them."""
        return tuple(Channel(c.name, c.min_kpa, c.max_kpa, c.slew_kpa_s) for c in self.chambers)

    @property
    def devices(self) -> dict[str, DeviceConfig | None]:
        """The three devices by role."""
        return {"pressure": self.pressure, "mocap": self.mocap, "scanner": self.scanner}

    def to_dict(self) -> dict[str, Any]:
        """The content of rig.yaml with every default written out."""
        return self.model_dump(mode="json", exclude_none=True)


_SIMULATED = ("surface", "shell", "plant", "seed", "noise_mm", "repeatability_mm", "occlusion", "hidden")
_NUMBERS = {"seed": math.inf, "noise_mm": 1000.0, "repeatability_mm": 1000.0, "occlusion": 1.0}
"""Those that are numbers, from 0 to so much."""


def _check_simulated(
    simulated: dict[str, Any], chambers: tuple[ChamberConfig, ...], folder: Path, used: bool
) -> None:
    """Raise `ValueError` for a name that means nothing, and for a shell or a plant that cannot be made.

    `used`: a device is simulated; otherwise the section may as well go.
    """
    for name in simulated:
        if name not in _SIMULATED:
            hint = meant(name, _SIMULATED) or f"; there are {', '.join(_SIMULATED)}"
            raise ValueError(f"simulated: there is no such field as {name}{hint}")
    for name, most in _NUMBERS.items():
        _check_number(name, simulated.get(name), most)
    if "surface" in simulated:
        if "shell" in simulated:
            raise ValueError("simulated: either a surface (the reduced model) or a shell, not both")
        if "plant" in simulated:
            raise ValueError(
                "simulated.plant says how a shell differs from its model: not for a surface (the reduced model)"
            )
        if not isinstance(simulated["surface"], str):
            raise ValueError("simulated.surface: the name of a surface is needed")
        return
    from labrig.physics import plant_shell

    content = {"simulated": simulated, "chambers": [chamber.model_dump() for chamber in chambers]}
    try:
        plant_shell(content, folder)
    except LabrigError as error:
        rest = "" if used else "; no device is simulated, so the section `simulated` may go"
        raise ValueError(str(error).removeprefix("rig: ") + rest) from None


def _check_number(name: str, value: Any, most: float) -> None:
    """Raise `ValueError` for what is there and is no number from 0 on, or, as a seed, no whole one."""
    kind = Integral if name == "seed" else Real
    is_one = isinstance(value, kind) and not isinstance(value, bool)
    if value is None or (is_one and 0 <= value <= most and value < math.inf):  # type: ignore[operator]
        return
    wanted = "whole number from 0 on" if name == "seed" else f"number from 0 to {most:g}"
    raise ValueError(f"simulated.{name}: should be a {wanted}, not {value!r}")


def load_rig(path: str | Path) -> RigConfig:
    """Read and check a rig.yaml.

    Raises `LabrigError` naming the file, the field and what is wrong with it.

    Example:
        >>> rig = labrig.load_rig("rig.yaml")
        >>> [chamber.name for chamber in rig.chambers]
        ['c1', 'c2', 'c3', 'c4']
        >>> rig.chambers[0].max_kpa
        60.0
    """
    path = path_of(path, "a rig", "a rig.yaml's path")
    return check_rig(read_yaml(path, "rig"), str(path), path.resolve().parent, path)


def check_rig(content: dict[str, Any], where: str, folder: Path, path: Path | None = None) -> RigConfig:
    """What `load_rig` makes of the content of a file, which need not be written yet.

    `path` is the file, if it is there, for its lines. Raises `FieldError`, a `LabrigError`.
    """
    config = check_fields(RigConfig, {**content, "folder": folder}, where, path)
    for role, device in config.devices.items():
        if device is not None and device.kind in SETTINGS:
            check_fields(SETTINGS[device.kind], device.options, where, path, role)
    _check_vented(config, where, path)
    return config


def _check_vented(config: RigConfig, where: str, path: Path | None) -> None:
    """Raise `FieldError` where a vent would be confirmed of a chamber that is as full as it may be."""
    vented_kpa = config.safety.vented_kpa
    for c in config.chambers:
        fullest_kpa = max(c.max_kpa, -c.min_kpa)
        if 0 < fullest_kpa <= vented_kpa:
            place = ("safety", "vented_kpa")
            line = None if path is None else line_of(path, place)
            what = (
                f"{vented_kpa:g} kPa counts as vented, and {c.name} may be at {fullest_kpa:g} kPa: a full chamber "
                f"would be called vented; give less, such as {fullest_kpa / 10:.2g}"
            )
            raise FieldError(
                f"{where}{f', line {line}' if line else ''}: {': '.join(place)}: {what}", place, what
            )


def parse_rig(content: dict[str, Any], where: str, folder: Path) -> RigConfig:
    """A rig from the content of its file; raises `LabrigError` as `load_rig` does."""
    return check_fields(RigConfig, {**content, "folder": folder}, where)
