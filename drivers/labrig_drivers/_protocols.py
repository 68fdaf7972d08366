"""What labrig asks of a device: three small protocols and the values that pass through them.

Times are seconds since the Unix epoch on the clock that the device was given, pressures kPa (gauge),
positions mm. Every call is bounded in time and raises `DeviceError` naming the device.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from labrig_drivers._short_traceback import short_traceback


class DeviceError(Exception):
    """A device did not do what it was asked; the message is one line that begins with the device's name."""

    __module__ = "labrig_drivers"
    exit_code = 3

    def _render_traceback_(self) -> list[str]:
        """What IPython and Jupyter print of it."""
        return short_traceback(self)


class VentNotConfirmedError(DeviceError):
    """A vent was commanded, but the pressures read back did not fall below the threshold in time."""


class MarkerStatus(IntEnum):
    """Why a marker has a position, or has none."""

    SEEN = 0
    OCCLUDED = 1
    STALE = 2
    NOT_SUBSCRIBED = 3


@dataclass(frozen=True)
class Channel:
    """One chamber's line: its name and the limits that are checked before every write."""

    name: str
    min_kpa: float
    max_kpa: float
    slew_kpa_s: float = float("inf")


@dataclass(frozen=True)
class Identity:
    """Who answered: `kind` is the protocol, `description` what the device says of itself."""

    name: str
    kind: str
    description: str
    details: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class PressureSample:
    """Measured pressures at one moment, kPa, in channel order; shape (C,), NaN where there is no sensor."""

    time_s: float
    pressure_kpa: NDArray[np.float64]


@dataclass(frozen=True)
class MarkerFrame:
    """One motion capture frame: positions mm, shape (M, 3), NaN unless seen; `MarkerStatus`, shape (M,)."""

    time_s: float
    number: int
    position_mm: NDArray[np.float64]
    status: NDArray[np.int8]


def frames_missing(frames: Sequence[MarkerFrame]) -> int:
    """How many frames were taken between these, by their numbers, and did not arrive."""
    numbers = np.array([frame.number for frame in frames])
    return int(np.maximum(np.diff(numbers) - 1, 0).sum())


@dataclass(frozen=True)
class VentReport:
    """A confirmed vent: the last pressures read, kPa, shape (C,), and how long it took."""

    pressure_kpa: NDArray[np.float64]
    took_s: float


@dataclass(frozen=True)
class Scan:
    """One surface scan: vertices mm (V, 3), triangles (T, 3), and the files it came from, hashed together.

    `unit` is that of the numbers in the files (mm, cm, m, inch).
    """

    time_s: float
    vertices_mm: NDArray[np.float64]
    triangles: NDArray[np.int64]
    files: tuple[Path, ...]
    sha256: str
    registration_error_mm: float | None = None
    unit: str = "mm"


@runtime_checkable
class Device(Protocol):
    """What every device can do; all of it may be called again without harm."""

    name: str

    def connect(self) -> None:
        """Open the link; a device that does not answer within its timeout is a `DeviceError`."""
        ...

    def identify(self) -> Identity:
        """Ask the device who it is."""
        ...

    def close(self) -> None:
        """Release the link; never raises."""
        ...


@runtime_checkable
class PressureController(Device, Protocol):
    """Sets and reads chamber pressures."""

    channels: Sequence[Channel]

    def set(self, pressure_kpa: NDArray[np.float64]) -> None:
        """Command set-points, kPa, shape (C,); outside a channel's limits is a `DeviceError` and moves nothing."""
        ...

    def samples(self) -> list[PressureSample]:
        """Every measurement since the last call, oldest first; does not wait."""
        ...

    def vent(self, timeout_s: float = 10.0) -> VentReport:
        """Bring every chamber to ambient and confirm it by reading; raises `VentNotConfirmedError`."""
        ...


@runtime_checkable
class MotionCapture(Device, Protocol):
    """Streams marker positions."""

    marker_names: Sequence[str]

    def frames(self) -> list[MarkerFrame]:
        """Every frame since the last call, oldest first; does not wait."""
        ...


@runtime_checkable
class Scanner(Device, Protocol):
    """Delivers surface scans."""

    def scan(self, timeout_s: float = 120.0) -> Scan:
        """Wait for the next complete scan and return it; a scan that fails a check is a `DeviceError`."""
        ...
