"""One plant behind several twins, each with a thread of its own."""

import threading
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from labrig_drivers._clock import Clock
from labrig_drivers._protocols import Channel


class WirePlant(Protocol):
    """What a twin asks of the plant behind it; times in s, pressures in kPa, positions in mm.

    `command` and `pressure_kpa` may be called while another thread is in `observe` or `surface`.
    """

    channels: tuple[Channel, ...]
    marker_names: tuple[str, ...]
    rest_mm: NDArray[np.float64]

    def command(self, time_s: float, pressure_kpa: NDArray[np.float64]) -> None:
        """Set-points (C,) from `time_s` on."""
        ...

    def pressure_kpa(self, time_s: float) -> NDArray[np.float64]:
        """True chamber pressures, (C,)."""
        ...

    def observe(self, time_s: float) -> tuple[NDArray[np.float64], NDArray[np.int8]]:
        """Marker positions (M, 3), NaN where not seen, and `MarkerStatus`, (M,)."""
        ...

    def surface(self, time_s: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Vertices (V, 3) and triangles (T, 3)."""
        ...


_HELD_S = 0.15


class SharedPlant:
    """Lets several threads use one plant, at times that never run backward.

    One at a time asks for pressures, and one at a time looks. Who asks for pressures never waits for who looks: no
    controller waits for cameras.

    A plant that takes long over the shape at a set-point (one that has `prepare`) is told of it as soon as it has been
    held for a moment, in a thread of its own, so that streams need not wait for it.
    """

    def __init__(self, plant: WirePlant, clock: Clock) -> None:
        self.plant = plant
        self.clock = clock
        self.marker_names = tuple(plant.marker_names)
        self.channels = tuple(plant.channels)
        self._lock = threading.Lock()
        self._eyes = threading.Lock()
        self._last_s = float("-inf")
        self._soon: threading.Timer | None = None

    def _time_s(self) -> float:
        self._last_s = max(self._last_s, self.clock.now_s())
        return self._last_s

    def _moment_s(self) -> float:
        with self._lock:
            return self._time_s()

    def command(self, pressure_kpa: NDArray[np.float64]) -> None:
        """Set-points (C,), kPa, from now on."""
        target = np.asarray(pressure_kpa, float)
        with self._lock:
            self.plant.command(self._time_s(), target)
        prepare = getattr(self.plant, "prepare", None)
        if prepare is None:
            return
        if self._soon is not None:
            self._soon.cancel()
        self._soon = threading.Timer(_HELD_S, prepare, (target.copy(),))
        self._soon.daemon = True
        self._soon.start()

    def pressure_kpa(self) -> NDArray[np.float64]:
        """True pressures (C,), kPa, now."""
        with self._lock:
            return np.array(self.plant.pressure_kpa(self._time_s()), float)

    def observe(self) -> tuple[NDArray[np.float64], NDArray[np.int8]]:
        """What the cameras see now: positions (M, 3), mm, and `MarkerStatus`, (M,)."""
        with self._eyes:
            position, status = self.plant.observe(self._moment_s())
            return np.array(position, float), np.array(status, np.int8)

    def surface(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """The surface now: vertices (V, 3), mm, and triangles (T, 3)."""
        with self._eyes:
            vertices_mm, triangles = self.plant.surface(self._moment_s())
            return np.array(vertices_mm, float), np.array(triangles, np.int64)
