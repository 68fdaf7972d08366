"""All twins of a rig over one plant, and the rig file that reaches them."""

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypedDict

from labrig_drivers._clock import Clock
from labrig_drivers._modbus_map import RegisterMapError, load_map
from labrig_drivers._openpneu_stream import SENSORS
from labrig_drivers._protocols import DeviceError
from labrig_drivers.simulated._artec_twin import ArtecTwin
from labrig_drivers.simulated._modbus_twin import ModbusTwin
from labrig_drivers.simulated._openpneu_board import OpenPneuBoard
from labrig_drivers.simulated._openpneu_twin import OpenPneuTwin
from labrig_drivers.simulated._vicon_server import ViconServer
from labrig_drivers.simulated._wire_plant import SharedPlant, WirePlant

KEPT_SCANS = 20
PRESSURE_KINDS = ("openpneu", "openpneu-table", "modbus")


DeviceSection = dict[str, str | float]
"""How a rig file names a device: its kind, and what that is reached by."""


class ChamberSection(TypedDict):
    """A chamber as a rig file has it."""

    name: str
    min_kpa: float
    max_kpa: float
    slew_kpa_s: float


class TwinFile(TypedDict, total=False):
    """The content of the rig file that reaches the twins."""

    name: str
    chambers: list[ChamberSection]
    markers: list[str]
    rest_mm: dict[str, list[float]]
    pressure: DeviceSection
    mocap: DeviceSection
    scanner: DeviceSection


@dataclass(frozen=True)
class TwinOptions:
    """What the twins are like. Ports: 0 takes free ones. `scan_every_s` None: no scans are exported."""

    host: str = "127.0.0.1"
    pressure: str = "openpneu"
    pressure_port: int = 0
    mocap_port: int = 0
    build: Literal["published", "full"] = "full"
    register_map: str = "festo-vtem.yaml"
    pty: bool = False
    boot_s: float = 0.5
    subject: str = "mannequin"
    rate_hz: float = 100.0
    up: str = "z"
    scan_every_s: float | None = None
    scan_formats: tuple[str, ...] = ("obj",)
    scan_unit: str = "mm"


class TwinRig:
    """The running twins; a context manager that ends them. `rig` is the content of their rig file."""

    def __init__(
        self, plant: WirePlant, name: str, folder: Path, clock: Clock, options: TwinOptions | None = None
    ) -> None:
        self.options = options or TwinOptions()
        self.plant = SharedPlant(plant, clock)
        self._name = name
        self._folder = folder
        self._stack = ExitStack()
        self.rig = TwinFile()
        self.listening: dict[str, str] = {}

    def __enter__(self) -> "TwinRig":
        with ExitStack() as stack:
            self._stack = stack
            self.rig = self._start()
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def _start(self) -> TwinFile:
        plant = self.plant
        return {
            "name": self._name,
            "chambers": [
                {
                    "name": channel.name,
                    "min_kpa": channel.min_kpa,
                    "max_kpa": channel.max_kpa,
                    "slew_kpa_s": channel.slew_kpa_s if channel.slew_kpa_s < 1e9 else 100.0,
                }
                for channel in plant.channels
            ],
            "markers": list(plant.marker_names),
            "rest_mm": {
                marker: [round(float(value), 3) for value in row]
                for marker, row in zip(plant.marker_names, plant.plant.rest_mm, strict=True)
            },
            "pressure": self._pressure(),
            "mocap": self._mocap(),
            "scanner": self._scanner(),
        }

    def _pressure(self) -> DeviceSection:
        options = self.options
        if options.pressure == "modbus":
            try:
                registers = load_map(options.register_map)
            except RegisterMapError as error:
                raise DeviceError(f"pressure: map: {error}") from None
            _enough(registers.name, len(registers.setpoint.addresses), len(self.plant.channels))
            twin = ModbusTwin(self.plant, registers, host=options.host, port=options.pressure_port)
            _started(twin, "pressure", options.host, options.pressure_port)
            self._stack.callback(twin.stop)
            self.listening["pressure"] = f"{registers.name}: Modbus TCP on {options.host}:{twin.port}"
            return {
                "kind": "modbus",
                "host": _reach(options.host),
                "port": twin.port,
                "map": options.register_map,
            }
        dialect: Literal["published", "table"] = (
            "table" if options.pressure == "openpneu-table" else "published"
        )
        _enough("an OpenPneu board", SENSORS, len(self.plant.channels))
        board = OpenPneuBoard(self.plant, dialect, options.build)
        twin = OpenPneuTwin(
            board,
            host=options.host,
            tcp_port=options.pressure_port,
            pty=options.pty,
            boot_s=options.boot_s,
        )
        _started(twin, "pressure", options.host, options.pressure_port)
        self._stack.callback(twin.stop)
        self.listening["pressure"] = f"OpenPneu ({dialect} dialect, {options.build} build) on {twin.port}"
        return {
            "kind": "openpneu",
            "port": twin.port.replace(f"//{options.host}:", f"//{_reach(options.host)}:"),
            "dialect": "auto",
            "build": options.build,
            "boot_s": options.boot_s + 0.2,
        }

    def _mocap(self) -> DeviceSection:
        options = self.options
        twin = ViconServer(
            self.plant,
            subject=options.subject,
            rate_hz=options.rate_hz,
            up=options.up,
            host=options.host,
            port=options.mocap_port,
        )
        _started(twin, "mocap", options.host, options.mocap_port)
        self._stack.callback(twin.stop)
        self.listening["mocap"] = (
            f"Vicon DataStream on {options.host}:{twin.port}, {options.rate_hz:g} Hz, subject {options.subject}"
        )
        return {
            "kind": "vicon",
            "host": _reach(options.host),
            "port": twin.port,
            "subject": options.subject,
            "up": "z",
        }

    def _scanner(self) -> DeviceSection:
        options = self.options
        folder = self._folder / "scans"
        twin = ArtecTwin(
            self.plant,
            folder,
            formats=options.scan_formats,
            unit=options.scan_unit,
            every_s=options.scan_every_s,
            keep=KEPT_SCANS,
        ).start()
        self._stack.callback(twin.stop)
        every = (
            "none unless asked for" if options.scan_every_s is None else f"every {options.scan_every_s:g} s"
        )
        self.listening["scanner"] = f"Artec exports into {folder}, {every}"
        return {"kind": "artec", "folder": "scans", "unit": options.scan_unit}


def _enough(what: str, outputs: int, chambers: int) -> None:
    if outputs < chambers:
        raise DeviceError(f"pressure: {what} has {outputs} outputs, the rig has {chambers} chambers")


def _started(twin: Any, role: str, host: str, port: int) -> None:
    try:
        twin.start()
    except (OSError, RuntimeError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise DeviceError(f"{role}: the twin cannot listen on {host}:{port}: {why}") from None


def _reach(host: str) -> str:
    # A server on every address is reached at the machine's own.
    return "127.0.0.1" if host in ("0.0.0.0", "::", "") else host
