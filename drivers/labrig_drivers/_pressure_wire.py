"""What `WiredPressure` asks of one kind of device on a wire."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class WireError(Exception):
    """A device answered, but not what it should have; one line."""


class PressureWire(Protocol):
    """One kind of device; every call is bounded in time and raises `LinkError` or `WireError`."""

    def open(self) -> None:
        """Open the link and leave every set-point at ambient, with measurements coming."""
        ...

    def identify(self) -> tuple[str, dict[str, str]]:
        """What the device says of itself: a description, and details."""
        ...

    def write(self, pressure_kpa: NDArray[np.float64]) -> None:
        """Command set-points, kPa, (C,); what is unchanged need not be sent."""
        ...

    def poll(self, timeout_s: float) -> list[NDArray[np.float64]]:
        """Measurements, kPa, (C,) each, waiting about `timeout_s` at most for the first."""
        ...

    def stop(self) -> None:
        """Towards ambient by the shortest way: pumps off, valves open, set-points 0; measuring goes on."""
        ...

    def close(self) -> None:
        """Leave the device at rest and release the link; never raises."""
        ...
