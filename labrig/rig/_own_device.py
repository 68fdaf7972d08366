"""A device whose class somebody else wrote: its faults are said with their place.

Whatever its code raises becomes a `DeviceError` that names the file, the line and the method. What its methods return
is checked as that of any driver is (`labrig.rig._checked`).
"""

import inspect
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from labrig._errors import LabrigError
from labrig._own_code import FAULTS, failed, load_module
from labrig.rig._config import DeviceConfig, RigConfig
from labrig_drivers import Clock, DeviceError

HOW_TO = "see docs/how-to/add-a-device.md"
_EVERY = ("connect", "identify", "close")
_METHODS = {"pressure": ("set", "samples", "vent"), "mocap": ("frames",), "scanner": ("scan",)}


def own_maker(config: RigConfig, role: str, device: DeviceConfig, clock: Clock) -> Callable[[], Any]:
    """Makes a user's device: its class gets `name`, `clock`, `channels` or `marker_names`, and its options."""
    options = device.options
    if not isinstance(options.get("file"), str) or not isinstance(options.get("class"), str):
        raise LabrigError(f"rig {config.name}: {role}: kind python needs `file` (a .py file) and `class`")
    path = config.folder / options["file"]
    try:
        module = load_module(path, f"labrig_device_{path.stem}")
    except LabrigError as error:
        raise LabrigError(f"rig {config.name}: {role}: {error}") from error
    kind = getattr(module, options["class"], None)
    if not callable(kind):
        raise LabrigError(f"rig {config.name}: {role}: {path} has no class {options['class']}")
    accepted = inspect.signature(kind).parameters
    offered = {"name": role, "clock": clock, "channels": config.channels, "marker_names": config.markers}
    settings = {key: value for key, value in options.items() if key not in ("file", "class")}
    arguments = {key: value for key, value in offered.items() if key in accepted} | settings
    try:
        inspect.signature(kind).bind(**arguments)
    except TypeError as error:
        raise LabrigError(f"rig {config.name}: {role} ({device.kind}): {error}") from None
    return lambda: OwnDevice(role, path, kind, arguments)


class OwnDevice:
    """Somebody's device; what labrig does not ask for by a method here is that of `device` itself."""

    def __init__(self, role: str, path: Path, kind: Any, arguments: Mapping[str, Any]) -> None:
        self.name, self._path, self._class = role, path, getattr(kind, "__name__", str(kind))
        self.called = f"{path.name}: {self._class}"
        self.device = self._do("__init__", kind, **arguments)
        for method in (*_EVERY, *_METHODS[role]):
            if not callable(getattr(self.device, method, None)):
                raise DeviceError(f"{role}: {self.called} has no method {method}; {HOW_TO}")

    def __getattr__(self, name: str) -> Any:
        if name == "device":  # while it is being made
            raise AttributeError(name)
        found = getattr(self.device, name)
        return partial(self._do, name, found) if callable(found) else found

    def _do(self, method: str, call: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
        try:
            return call(*arguments, **named)
        except (DeviceError, LabrigError):
            raise
        except FAULTS as error:
            said = failed(error, self._path, f"{self._class}.{method}")
            raise DeviceError(f"{self.name}: {said}") from error
