"""Turns a rig's description into connected devices."""

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from labrig._errors import LabrigError
from labrig.rig._checked import CheckedMocap, CheckedPressure, CheckedScanner
from labrig.rig._config import DeviceConfig, RigConfig
from labrig.rig._guard import GuardedPressure
from labrig.rig._markers import twice
from labrig.rig._own_device import own_maker
from labrig.rig._rig import Rig
from labrig_drivers import Clock, Device, RealClock, build_device

_KINDS = {"pressure": ("openpneu", "modbus"), "mocap": ("vicon",), "scanner": ("artec",)}


def connect(
    config: RigConfig,
    clock: Clock,
    *,
    folder: Path | None = None,
    guard: bool | None = None,
    guard_log: Path | None = None,
) -> Rig:
    """Connect every device of a rig and ask who it is.

    `folder` is where a simulated rig looks for what it hides; by default the folder of rig.yaml. Markers that
    rig.yaml does not name are those of the motion capture. With `guard`, the pressure link lives in a process of
    its own that vents when this one is gone; by default so on the real clock, unless the rig is simulated in this
    process. `guard_log` is a file for what the guard does on its own.
    Raises `DeviceError` when a device does not answer, `LabrigError` when the description is wrong; what was
    opened is closed again.
    """
    simulated = _Simulated(config, clock, folder or config.folder)
    makers = _makers(config, clock, simulated)
    simulated_here = config.pressure.kind == "simulated"
    if guard if guard is not None else isinstance(clock, RealClock) and not simulated_here:
        if simulated_here:
            raise LabrigError(f"rig {config.name}: a simulated pressure controller cannot be guarded")
        link_clock = clock if isinstance(clock, RealClock) else None
        makers["pressure"] = lambda: GuardedPressure(config, "pressure", guard_log, link_clock)
    devices: dict[str, Any] = {}
    try:
        for role, make in makers.items():
            devices[role] = make()
            devices[role].connect()
        identity = {role: device.identify() for role, device in devices.items()}
        if "mocap" in devices and (name := twice(tuple(devices["mocap"].marker_names))) is not None:
            raise LabrigError(
                f"rig {config.name}: mocap names the marker {name} twice; give each a name of its own there"
            )
    except BaseException:
        _close(devices)
        raise
    if not config.markers and "mocap" in devices:
        config = config.model_copy(update={"markers": tuple(devices["mocap"].marker_names)})
    return Rig(config, clock, identity=identity, plant_rest_mm=simulated.rest_mm, **devices)


def _close(devices: dict[str, Device]) -> None:
    for device in reversed(list(devices.values())):
        device.close()


def device_makers(
    config: RigConfig, clock: Clock, *, folder: Path | None = None
) -> dict[str, Callable[[], Any]]:
    """For each role of a rig (`pressure`, `mocap`, `scanner`) a function that makes its device, not connected.

    Raises `LabrigError` when the description is wrong; making a device raises `DeviceError`.
    """
    return _makers(config, clock, _Simulated(config, clock, folder or config.folder))


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
    """A function that makes one device that is not simulated in this process; what it says is checked."""
    make = _unchecked_maker(config, role, device, clock)
    if role == "pressure":
        return lambda: CheckedPressure(make(), config, role, clock)
    if role == "mocap":
        return lambda: CheckedMocap(make(), config, role, clock)
    return lambda: CheckedScanner(make(), role, clock)


def _unchecked_maker(config: RigConfig, role: str, device: DeviceConfig, clock: Clock) -> Callable[[], Any]:
    if device.kind == "python":
        return own_maker(config, role, device, clock)
    if device.kind not in _KINDS[role]:
        known = ", ".join([*_KINDS[role], "simulated", "python"])
        raise LabrigError(f"rig {config.name}: {role}: no kind {device.kind!r}; there are {known}")
    return lambda: build_device(
        device.kind,
        {**driver_limits(config, role), **device.options},
        name=role,
        clock=clock,
        channels=config.channels,
        marker_names=config.markers,
        base=config.folder,
    )


def driver_limits(config: RigConfig, role: str) -> dict[str, float]:
    """What a pressure driver takes from the rig's section safety, unless its own section says otherwise."""
    safety = config.safety
    if role != "pressure":
        return {}
    return {"stale_after_s": safety.stale_pressure_s, "vent_below_kpa": safety.vented_kpa}


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
            simulated = importlib.import_module("labrig_drivers.simulated")
            if self._plant is None:
                try:
                    self._plant = simulated.build_plant(self.config.to_dict(), self.folder)
                except LabrigError as error:
                    said = str(error).removeprefix("rig: ")
                    raise LabrigError(f"rig {self.config.name}: {said}") from None
                except (TypeError, ValueError) as error:
                    raise LabrigError(f"rig {self.config.name}: simulated: {error}") from None
            kind = {
                "pressure": simulated.SimulatedPressure,
                "mocap": simulated.SimulatedMocap,
                "scanner": simulated.SimulatedScanner,
            }[role]
            try:
                return kind(self._plant, self.clock, role, **options)
            except (TypeError, ValueError) as error:
                raise LabrigError(f"rig {self.config.name}: {role} (simulated): {error}") from None

        return make
