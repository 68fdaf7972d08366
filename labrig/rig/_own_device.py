"""A device whose class somebody else wrote: what it returns is checked, and its faults are said with their place.

Whatever its code raises becomes a `DeviceError` that names the file, the line and the method.
"""

import inspect
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig._own_code import failed, load_module
from labrig.arrays import Floats
from labrig.rig._config import DeviceConfig, RigConfig
from labrig.rig._markers import order_in
from labrig_drivers import (
    Clock,
    DeviceError,
    Identity,
    MarkerFrame,
    PressureSample,
    Scan,
    VentReport,
)

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
    checked = {"pressure": OwnPressure, "mocap": OwnMocap, "scanner": OwnScanner}[role]
    return lambda: checked(role, path, kind, arguments, config)


class OwnDevice:
    """What the three kinds have in common; attributes that labrig does not ask for are those of `device` itself."""

    def __init__(
        self, role: str, path: Path, kind: Any, arguments: Mapping[str, Any], config: RigConfig
    ) -> None:
        self.name, self._path, self._class = role, path, getattr(kind, "__name__", str(kind))
        self.channels, self.config = config.channels, config
        self.device = self._do("__init__", lambda: kind(**arguments))
        for method in (*_EVERY, *_METHODS[role]):
            if not callable(getattr(self.device, method, None)):
                raise self._wrong("", f"has no method {method}")

    def __getattr__(self, name: str) -> Any:
        if name == "device":  # while it is being made
            raise AttributeError(name)
        return getattr(self.device, name)

    def connect(self) -> None:
        """Open the link."""
        self._do("connect", self.device.connect)

    def identify(self) -> Identity:
        """Ask the device who it is."""
        who = self._do("identify", self.device.identify)
        try:
            details = {str(key): str(value) for key, value in dict(who.details).items()}
            return Identity(self.name, str(who.kind), str(who.description), details)
        except (AttributeError, TypeError, ValueError):
            raise self._wrong("identify", f"returns {_what(who)}, where an Identity is needed") from None

    def close(self) -> None:
        """Release the link."""
        try:
            self.device.close()
        except Exception:  # the others have to be closed, too
            return

    def _do(self, method: str, call: Callable[[], Any]) -> Any:
        try:
            return call()
        except (DeviceError, LabrigError):
            raise
        except Exception as error:
            said = failed(error, self._path, f"{self._class}.{method}")
            raise DeviceError(f"{self.name}: {said}") from error

    def _wrong(self, method: str, what: str) -> DeviceError:
        where = f"{self._path.name}: {self._class}{'.' if method else ''}{method}"
        return DeviceError(f"{self.name}: {where} {what}; {HOW_TO}")

    def _list(self, method: str, values: Any) -> list[Any]:
        if not isinstance(values, list | tuple):
            raise self._wrong(
                method, f"returns {_what(values)}, where a list is needed (empty if nothing came)"
            )
        return list(values)

    def _array(self, method: str, values: Any, shape: tuple[int, ...], what: str) -> NDArray[Any]:
        try:
            array = np.asarray(values, float)
        except (TypeError, ValueError):
            raise self._wrong(method, f"gives {what} that are no array of numbers") from None
        if array.shape != shape:
            raise self._wrong(method, f"gives {what} of shape {array.shape}, where {shape} is needed")
        return array

    def _number(self, method: str, value: Any, what: str) -> float:
        try:
            return float(value)
        except (TypeError, ValueError):
            raise self._wrong(method, f"gives {value!r} as {what}, where a number is needed") from None

    def _field(self, method: str, value: Any, name: str, kind: type) -> Any:
        if not hasattr(value, name):
            raise self._wrong(method, f"gives {_what(value)}, where a {kind.__name__} is needed")
        return getattr(value, name)


class OwnPressure(OwnDevice):
    """Somebody's pressure controller."""

    def set(self, pressure_kpa: Floats) -> None:
        """Command set-points, kPa, shape (C,)."""
        self._do("set", lambda: self.device.set(np.asarray(pressure_kpa, float)))

    def samples(self) -> list[PressureSample]:
        """Every measurement since the last call."""
        found = self._list("samples", self._do("samples", self.device.samples))
        return [self._sample(each) for each in found]

    def _sample(self, sample: Any) -> PressureSample:
        time_s = self._field("samples", sample, "time_s", PressureSample)
        values = self._field("samples", sample, "pressure_kpa", PressureSample)
        shape = (len(self.channels),)
        return PressureSample(
            self._number("samples", time_s, "time_s"),
            self._array("samples", values, shape, "pressures"),
        )

    def vent(self, timeout_s: float = 10.0) -> VentReport:
        """Bring every chamber to ambient."""
        report = self._do("vent", lambda: self.device.vent(timeout_s))
        values = self._field("vent", report, "pressure_kpa", VentReport)
        took_s = self._field("vent", report, "took_s", VentReport)
        shape = (len(self.channels),)
        return VentReport(
            self._array("vent", values, shape, "pressures"), self._number("vent", took_s, "took_s")
        )


class OwnMocap(OwnDevice):
    """Somebody's motion capture: its markers come in the order of rig.yaml, whatever its own order is."""

    _order: Sequence[int] | None = None
    _markers: tuple[str, ...] = ()

    def connect(self) -> None:
        """Open the link, and find each marker of rig.yaml among the driver's own."""
        super().connect()
        self._find()

    def _find(self) -> None:
        own = getattr(self.device, "marker_names", None)
        if own is None and not self.config.markers:
            raise self._wrong("", "has no marker_names, and rig.yaml names no markers")
        given = () if own is None else tuple(str(name) for name in own)
        names = given or self.config.markers  # one that names none keeps to the order of rig.yaml
        if not names:
            raise self._wrong("marker_names", "is empty, and rig.yaml names no markers")
        self._markers = names
        try:
            self._order = order_in(names, self.config.markers)
        except ValueError as error:
            raise self._wrong("marker_names", str(error)) from None

    @property
    def marker_names(self) -> Sequence[str]:
        """The markers, in the order of the frames."""
        return self.config.markers or self._markers or tuple(getattr(self.device, "marker_names", ()))

    def frames(self) -> list[MarkerFrame]:
        """Every frame since the last call."""
        found = self._list("frames", self._do("frames", self.device.frames))
        return [self._frame(each) for each in found]

    def _frame(self, frame: Any) -> MarkerFrame:
        time_s, number, position, status = (
            self._field("frames", frame, name, MarkerFrame)
            for name in ("time_s", "number", "position_mm", "status")
        )
        M = len(self._markers)
        position = self._array("frames", position, (M, 3), "positions")
        status = self._array("frames", status, (M,), "a status")
        if self._order is not None:
            position, status = position[list(self._order)], status[list(self._order)]
        return MarkerFrame(
            self._number("frames", time_s, "time_s"),
            int(self._number("frames", number, "number")),
            position,
            status.astype(np.int8),
        )


class OwnScanner(OwnDevice):
    """Somebody's scanner."""

    def scan(self, timeout_s: float = 120.0) -> Scan:
        """Wait for the next complete scan."""
        scan = self._do("scan", lambda: self.device.scan(timeout_s))
        for name in ("time_s", "vertices_mm", "triangles", "files", "sha256"):
            self._field("scan", scan, name, Scan)
        return scan


def _what(value: Any) -> str:
    return "None" if value is None else f"a {type(value).__name__}"
