"""What is wrong with a rig that is being set up, and at which field: by the rules of `load_rig` and of the devices.

Devices are made as for a run, and not connected: no port is opened and nothing is sent.
"""

import re
from pathlib import Path
from typing import Any, NamedTuple

from labrig._errors import LabrigError
from labrig._fields import FieldError
from labrig._yaml import load_yaml
from labrig.rig import RigConfig, check_rig, device_makers
from labrig.workbench._desk import Desk
from labrig.workbench._rig_fields import kind_of
from labrig_drivers import DeviceError, SimulatedClock, register_maps, set_together

_FULL = (
    "build: full sets each channel on its own; say it only if your board's firmware does that: the published one "
    "sets both channels of a pair"
)
_WHERE = {
    "a rig needs at least one chamber": "chambers",
    "chamber ": "chambers",
    "chambers: ": "chambers",
    "marker ": "markers",
    "markers": "markers",
    "simulated: ": "simulated",
    "cannot read the shell": "simulated.body",
}
"""How what is wrong with a rig as a whole begins, and where in the form that is."""


class Fault(NamedTuple):
    """The first thing that is wrong: at which field of the form (`chambers.0.max_kpa`; empty: as a whole), and what."""

    at: str
    says: str


def fault_of(desk: Desk, text: str) -> Fault | None:
    """What is wrong with the text of a rig file in the desk's folder; None where it is a rig."""
    return _looked_at(desk, text)[1]


def looked_at(desk: Desk, text: str) -> tuple[Fault | None, list[str]]:
    """The same, and what is right and yet worth a second look, each in one line."""
    config, fault = _looked_at(desk, text)
    return fault, [] if config is None or fault is not None else _remarks(desk, config)


def _looked_at(desk: Desk, text: str) -> tuple[RigConfig | None, Fault | None]:
    content = load_yaml(text)
    try:
        check_paths(desk, content)
        config = check_rig(content, "the rig", desk.folder)
        _make_devices(config)
    except FieldError as error:
        return None, _of_field(error, content)
    except DeviceError as error:
        return None, _of_device(str(error), content)
    except LabrigError as error:
        return None, _of_words(str(error))
    return config, None


def check_paths(desk: Desk, content: dict[str, Any]) -> None:
    """Raise `FieldError` for a file that would be read and lies outside the desk's folder."""
    from labrig.physics import shipped_shells  # which computes: not before somebody asks

    read = {("pressure", "map"): register_maps(), ("simulated", "shell"): shipped_shells()}
    for (section, key), brought in read.items():
        part = content.get(section)
        name = part.get(key) if isinstance(part, dict) else None
        if isinstance(name, str) and name not in brought:
            try:
                desk.path(name)
            except LabrigError as error:
                raise FieldError(str(error), (section, key), str(error)) from None


def _make_devices(config: RigConfig) -> None:
    """Make each device, as what is wrong with its settings is found only then; what takes long to compute is not."""
    simulated = config.simulated is not None and "surface" in config.simulated
    for role, make in device_makers(config, SimulatedClock()).items():
        device = config.devices[role]
        if device is not None and (device.kind != "simulated" or simulated):
            make()


def _of_field(error: FieldError, content: dict[str, Any]) -> Fault:
    """A fault where `load_rig` finds it, by the names of the form."""
    place = [str(part) for part in error.place]
    if not place:
        return _of_words(error.what)
    if place[0] in ("markers", "rest_mm"):
        place = ["markers"]
    if place[:2] == ["pressure", "outputs"]:
        place = ["chambers", *place[2:3], *(["output"] if place[2:] else [])]
    if place[0] == "simulated" and place[1:2] in (["shell"], ["surface"]):
        place = ["simulated", "body"]
    return Fault(".".join(place), error.what)


def _of_words(words: str) -> Fault:
    """A fault of the rig as a whole, by how its words begin."""
    words = re.sub(r"^rig( [^:]*)?: ", "", words)
    if found := re.match(r"simulated\.(\w+): ", words):
        name = "body" if found[1] in ("shell", "surface") else found[1]
        return Fault(f"simulated.{name}", words[found.end() :])
    at = next((place for begin, place in _WHERE.items() if words.startswith(begin)), "")
    return Fault(at, words.removeprefix(f"{at}: "))


def _of_device(words: str, content: dict[str, Any]) -> Fault:
    """What a device says of its settings: `ROLE: SETTING: ...`, `ROLE: CHAMBER ...`, or `ROLE: ...`."""
    role, _, rest = words.partition(": ")
    device = content.get(role)
    if not isinstance(device, dict):
        return Fault("", words)
    kind = kind_of(role, str(device.get("kind")))
    key, _, said = rest.partition(": ")
    if kind is not None and said and key in {field.key for field in kind.fields}:
        return Fault(f"{role}.{key}", said)
    if role == "pressure" and rest.startswith("outputs"):
        return Fault("chambers", f"board channels: {rest}")
    for k, chamber in enumerate(content.get("chambers") or []):
        if role == "pressure" and rest.startswith(f"{chamber['name']} "):
            return Fault(f"chambers.{k}", rest)
    return Fault(role, rest)


def _remarks(desk: Desk, config: RigConfig) -> list[str]:
    pressure, remarks = config.pressure, []
    if together := set_together(pressure.kind, pressure.options, config.channels):
        remarks.append(f"{together}; or give each chamber a pair of its own: channels 0, 2, 4, ...")
    if pressure.kind == "openpneu" and pressure.options.get("build") == "full":
        remarks.append(_FULL)
    if config.scanner is not None and config.scanner.kind == "artec":
        remarks += _absent(desk, Path(str(config.scanner.options["folder"])))
    return remarks


def _absent(desk: Desk, folder: Path) -> list[str]:
    """That a folder of the desk's is not there yet; of others nothing is said."""
    try:
        found = desk.path(folder.as_posix())
    except LabrigError:
        return []
    name = desk.name(found) or "."
    return (
        []
        if found.is_dir()
        else [f"there is no folder {name} yet: make it before Artec Studio exports into it"]
    )
