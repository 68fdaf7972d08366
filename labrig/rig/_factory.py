"""Turns a rig's description into connected devices."""

import importlib
import importlib.util
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

from drivers import Clock, Device
from labrig._errors import LabrigError
from labrig.rig._config import DeviceConfig, RigConfig
from labrig.rig._rig import Rig

KINDS: dict[str, dict[str, str]] = {
    "pressure": {"openpneu": "OpenPneu", "modbus": "ModbusPressure"},
    "mocap": {"vicon": "Vicon"},
    "scanner": {"artec": "ArtecFolder"},
}
"""Role -> kind -> class in `drivers`; besides these there are `simulated` and `python` (a user's own file)."""


def connect(config: RigConfig, clock: Clock, *, folder: Path | None = None) -> Rig:
    """Connect every device of a rig and ask who it is.

    `folder` is where a simulated rig keeps its files (what it hides, its scans); by default the rig's own folder.
    Raises `DeviceError` when a device does not answer, `LabrigError` when the description is wrong; what was
    opened is closed again.
    """
    simulated = _Simulated(config, clock, folder or config.folder)
    makers = _makers(config, clock, simulated)
    devices: dict[str, Any] = {}
    try:
        for role, make in makers.items():
            devices[role] = make()
            devices[role].connect()
        identity = {role: device.identify() for role, device in devices.items()}
    except BaseException:
        _close(devices)
        raise
    return Rig(config, clock, identity=identity, plant_rest_mm=simulated.rest_mm, **devices)


def _close(devices: dict[str, Device]) -> None:
    for device in reversed(list(devices.values())):
        device.close()


def _makers(config: RigConfig, clock: Clock, simulated: "_Simulated") -> dict[str, Callable[[], Any]]:
    makers: dict[str, Callable[[], Any]] = {}
    for role, device in config.devices.items():
        if device is None:
            continue
        if device.kind == "simulated":
            makers[role] = simulated.maker(role, device)
        else:
            makers[role] = device_maker(config, role, device, clock)
    return makers


def device_maker(config: RigConfig, role: str, device: DeviceConfig, clock: Clock) -> Callable[[], Any]:
    """A function that makes one device that is not simulated in this process."""
    kind = _device_class(config, role, device)
    options = {
        key: value for key, value in device.options.items() if device.kind != "python" or key not in _OWN
    }
    offered = {"name": role, "clock": clock, "channels": config.channels, "marker_names": config.markers}
    offered["folder_of_rig"] = config.folder
    accepted = inspect.signature(kind).parameters
    arguments = {key: value for key, value in offered.items() if key in accepted} | options
    for key in ("map", "folder"):
        if isinstance(arguments.get(key), str):
            arguments[key] = config.folder / arguments[key]
    try:
        inspect.signature(kind).bind(**arguments)
    except TypeError as error:
        raise LabrigError(f"rig {config.name}: {role} ({device.kind}): {error}") from None
    return lambda: kind(**arguments)


_OWN = ("file", "class")


def _device_class(config: RigConfig, role: str, device: DeviceConfig) -> Any:
    if device.kind == "python":
        return _users_class(config, role, device)
    names = KINDS[role]
    if device.kind not in names:
        known = ", ".join(sorted([*names, "simulated", "python"]))
        raise LabrigError(f"rig {config.name}: {role}: no kind {device.kind!r}; there are {known}")
    return getattr(importlib.import_module("drivers"), names[device.kind])


def _users_class(config: RigConfig, role: str, device: DeviceConfig) -> Any:
    """The class that `{kind: python, file: my_valve.py, class: MyValve}` names."""
    options = device.options
    if not isinstance(options.get("file"), str) or not isinstance(options.get("class"), str):
        raise LabrigError(f"rig {config.name}: {role}: kind python needs `file` (a .py file) and `class`")
    path = config.folder / options["file"]
    spec = importlib.util.spec_from_file_location(f"labrig_device_{path.stem}", path)
    if spec is None or spec.loader is None or not path.is_file():
        raise LabrigError(f"rig {config.name}: {role}: there is no file {path}")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    if not hasattr(module, options["class"]):
        raise LabrigError(f"rig {config.name}: {role}: {path} has no class {options['class']}")
    return getattr(module, options["class"])


class _Simulated:
    """Makes the simulated devices of one rig over one shared plant, which is built on first use."""

    def __init__(self, config: RigConfig, clock: Clock, folder: Path) -> None:
        self.config, self.clock, self.folder = config, clock, folder
        self._plant: Any = None

    @property
    def rest_mm(self) -> Any:
        """Where the plant's markers rest, (M, 3) mm; None if nothing is simulated."""
        return None if self._plant is None else self._plant.rest_mm

    def maker(self, role: str, device: DeviceConfig) -> Callable[[], Any]:
        """A function that makes the simulated device of a role."""
        options = device.options

        def make() -> Any:
            simulated = importlib.import_module("drivers.simulated")
            if self._plant is None:
                self._plant = simulated.build_plant(self.config.to_dict(), self.folder)
            if role == "pressure":
                return simulated.SimulatedPressure(self._plant, self.clock, role, **options)
            if role == "mocap":
                options.setdefault("rate_hz", 100.0)
                return simulated.SimulatedMocap(self._plant, self.clock, role, **options)
            return simulated.SimulatedScanner(self._plant, self.clock, self.folder / "scans", **options)

        return make
