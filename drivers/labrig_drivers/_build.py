"""From the settings in a rig file to a device. Nothing heavy is imported before a device is asked for."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig_drivers._clock import Clock
from labrig_drivers._protocols import Channel, DeviceError

if TYPE_CHECKING:
    from labrig_drivers._recording import Recorder
    from labrig_drivers._settings import (
        ArtecSettings,
        ModbusSettings,
        OpenPneuSettings,
        PressureSettings,
        ViconSettings,
    )

KINDS = ("openpneu", "modbus", "vicon", "artec")
"""The kinds of devices that `build_device` knows."""


def build_device(
    kind: str,
    settings: Mapping[str, Any],
    *,
    name: str,
    clock: Clock,
    channels: Sequence[Channel] = (),
    marker_names: Sequence[str] = (),
    base: Path | None = None,
    record: Path | None = None,
) -> Any:
    """A device of this kind, not connected yet; relative paths in its settings start from `base`.

    `settings` are the entries of the rig file without `kind`. `record` names a new file that takes the raw
    bytes of the session. Raises `DeviceError` for settings that cannot be used.
    """
    from pydantic import ValidationError

    from labrig_drivers import _settings

    if kind not in KINDS:
        raise DeviceError(f"{name}: no kind of device is called {kind!r} (there are {', '.join(KINDS)})")
    try:
        checked = _settings.SETTINGS[kind].model_validate(dict(settings))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or "settings"
        raise DeviceError(f"{name}: {where}: {first['msg']}") from None
    recorder = _recorder(kind, name, record)
    if isinstance(checked, _settings.OpenPneuSettings):
        return _openpneu(checked, name, clock, channels, recorder)
    if isinstance(checked, _settings.ModbusSettings):
        return _modbus(checked, name, clock, channels, base, recorder)
    if isinstance(checked, _settings.ViconSettings):
        return _vicon(checked, name, clock, marker_names, recorder)
    assert isinstance(checked, _settings.ArtecSettings)
    return _artec(checked, name, clock, base)


def set_together(kind: str, settings: Mapping[str, Any], channels: Sequence[Channel]) -> str | None:
    """Two chambers that a pressure controller gives one set-point, in a line; None where each has its own.

    The settings are those that `build_device` takes.
    """
    check, _ = one_target(kind, settings, channels)
    # of set-points that all differ, the first pair is named
    return check(np.arange(len(channels), dtype=float))


def one_target(
    kind: str, settings: Mapping[str, Any], channels: Sequence[Channel]
) -> tuple[Callable[[NDArray[np.float64]], str | None], bool]:
    """What says of set-points (C,), kPa, in a line why a pressure controller refuses them, as two chambers have one;
    and whether that is certain before the controller has answered.

    The settings are those that `build_device` takes, which says what is wrong with them.
    """
    from pydantic import ValidationError

    from labrig_drivers import _settings

    if kind != "openpneu":
        return _accepts, True
    from labrig_drivers._openpneu import check_pairs

    try:
        checked = _settings.OpenPneuSettings.model_validate({"port": "", **settings})
    except ValidationError:
        return _accepts, True
    if not _paired(checked):
        return _accepts, True
    names = [channel.name for channel in channels]
    return check_pairs(_outputs(checked, kind, channels), names), checked.dialect == "published"


def _accepts(pressure_kpa: NDArray[np.float64]) -> None:
    """Any set-points."""


def _paired(settings: "OpenPneuSettings") -> bool:
    return settings.build == "published" and settings.dialect != "table"


def _recorder(kind: str, name: str, record: Path | None) -> "Recorder | None":
    if record is None or kind == "artec":
        return None
    from labrig_drivers._recording import Recorder

    try:
        return Recorder(record, kind, name)
    except FileExistsError:
        raise DeviceError(f"{name}: {record} exists already; record into a new file") from None
    except OSError as error:
        raise DeviceError(f"{name}: cannot record into {record}: {error.strerror}") from None


def _pressure_options(settings: "PressureSettings") -> Any:
    from labrig_drivers._wired_pressure import PressureOptions

    return PressureOptions(
        stale_after_s=settings.stale_after_s,
        over_kpa=settings.over_kpa,
        vent_below_kpa=settings.vent_below_kpa,
    )


def _outputs(settings: "PressureSettings", name: str, channels: Sequence[Channel]) -> tuple[int, ...]:
    outputs = tuple(range(len(channels))) if settings.outputs is None else settings.outputs
    if not channels:
        raise DeviceError(f"{name}: the rig has no chambers")
    if len(outputs) != len(channels):
        raise DeviceError(f"{name}: outputs: {len(outputs)} for {len(channels)} chambers")
    return outputs


def _openpneu(
    settings: "OpenPneuSettings",
    name: str,
    clock: Clock,
    channels: Sequence[Channel],
    recorder: "Recorder | None",
) -> Any:
    from labrig_drivers._openpneu import OpenPneuOptions, OpenPneuWire, check_limits, check_pairs
    from labrig_drivers._wired_pressure import WiredPressure

    outputs = _outputs(settings, name, channels)
    names = [channel.name for channel in channels]
    low, high = [c.min_kpa for c in channels], [c.max_kpa for c in channels]
    problem = check_limits(outputs, names, low, high)
    if problem is not None:
        raise DeviceError(f"{name}: {problem}")
    wire = OpenPneuWire(
        OpenPneuOptions(
            port=settings.port,
            outputs=outputs,
            dialect=settings.dialect,
            build=settings.build,
            baudrate=settings.baudrate,
            boot_s=settings.boot_s,
            timeout_s=settings.timeout_s,
        ),
        recorder,
    )
    paired = check_pairs(outputs, names) if _paired(settings) else _accepts

    def check(pressure_kpa: NDArray[np.float64]) -> str | None:
        """The other dialect sets each channel by itself, as is known once the board has answered."""
        return None if wire.dialect == "table" else paired(pressure_kpa)

    return WiredPressure(
        name, "openpneu", channels, clock, wire, _pressure_options(settings), check, recorder
    )


def _modbus(
    settings: "ModbusSettings",
    name: str,
    clock: Clock,
    channels: Sequence[Channel],
    base: Path | None,
    recorder: "Recorder | None",
) -> Any:
    from labrig_drivers._modbus import ModbusOptions, ModbusWire
    from labrig_drivers._modbus_map import RegisterMapError, load_map
    from labrig_drivers._wired_pressure import WiredPressure

    if (settings.host is None) == (settings.serial is None):
        raise DeviceError(f"{name}: give either host (Modbus TCP) or serial (RTU)")
    try:
        beside = base / settings.map if base is not None else Path(settings.map)
        registers = load_map(beside if beside.is_file() else settings.map)
    except RegisterMapError as error:
        raise DeviceError(f"{name}: map: {error}") from None
    outputs = _outputs(settings, name, channels)
    available = len(registers.setpoint.addresses)
    if len(set(outputs)) != len(outputs) or any(not 0 <= n < available for n in outputs):
        raise DeviceError(
            f"{name}: outputs {list(outputs)} are not different outputs from 0 to {available - 1} of "
            f"{registers.name}"
        )
    low, high = registers.range_kpa
    for channel in channels:
        if channel.min_kpa < low or channel.max_kpa > high:
            raise DeviceError(
                f"{name}: {channel.name} may not be set from {channel.min_kpa:g} to {channel.max_kpa:g} kPa: "
                f"{registers.name} does {low:g} to {high:g} kPa"
            )
    wire = ModbusWire(
        ModbusOptions(
            registers=registers,
            outputs=outputs,
            host=settings.host,
            tcp_port=settings.port or registers.tcp_port,
            serial=settings.serial,
            baudrate=settings.baudrate,
            parity=settings.parity,
            unit_id=registers.unit_id if settings.unit_id is None else settings.unit_id,
            timeout_s=settings.timeout_s,
            poll_hz=settings.poll_hz,
        ),
        recorder,
    )
    return WiredPressure(
        name, "modbus", channels, clock, wire, _pressure_options(settings), lambda _: None, recorder
    )


def _vicon(
    settings: "ViconSettings",
    name: str,
    clock: Clock,
    marker_names: Sequence[str],
    recorder: "Recorder | None",
) -> Any:
    from labrig_drivers._vicon import Vicon, ViconOptions

    options = ViconOptions(
        host=settings.host,
        port=settings.port,
        subject=settings.subject,
        up=settings.up,
        mm_per_unit=1000.0 if settings.unit == "m" else 1.0,
        rename=settings.rename,
        mode=settings.mode,
        timeout_s=settings.timeout_s,
        stale_after_s=settings.stale_after_s,
        lost_after_s=settings.lost_after_s,
    )
    return Vicon(name, marker_names, clock, options, recorder)


def _artec(settings: "ArtecSettings", name: str, clock: Clock, base: Path | None) -> Any:
    from labrig_drivers._artec import ArtecFolder, ArtecOptions

    folder = Path(settings.folder)
    return ArtecFolder(
        name,
        clock,
        ArtecOptions(
            folder=folder if base is None else base / folder,
            unit=settings.unit,
            formats=settings.formats,
            size_mm=settings.size_mm,
            settle_s=settings.settle_s,
            stall_s=settings.stall_s,
        ),
    )
