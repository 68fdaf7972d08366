"""In-process simulated devices: the protocols of `drivers`, over one shared plant, on any clock."""

import hashlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig_drivers._clock import Clock
from labrig_drivers._protocols import (
    Channel,
    DeviceError,
    Identity,
    MarkerFrame,
    PressureSample,
    Scan,
    VentNotConfirmedError,
    VentReport,
)
from labrig_drivers.simulated._plant import Plant

VENTED_KPA = 1.0
_LIMIT_SLACK_KPA = 1e-6


class _Linked:
    """What all simulated devices do alike: a link that must be open before anything is asked."""

    kind = ""

    def __init__(self, plant: Plant, clock: Clock, name: str) -> None:
        self.name = name
        self._plant = plant
        self._clock = clock
        self._open = False

    def connect(self) -> None:
        """Open the link."""
        self._open = True

    def identify(self) -> Identity:
        """Who this is."""
        self._need_link()
        return Identity(self.name, "simulated", f"simulated {self.kind}")

    def close(self) -> None:
        """Release the link."""
        self._open = False

    def _need_link(self) -> None:
        if not self._open:
            raise DeviceError(f"{self.name}: not connected")


class _Ticker:
    """Ticks of a fixed rate since the last time they were asked for."""

    def __init__(self, rate_hz: float) -> None:
        self.rate_hz = float(rate_hz)
        self._start_s: float | None = None
        self._count = 0

    def since_last(self, now_s: float) -> tuple[NDArray[np.int64], Floats]:
        """Numbers and times of the ticks up to `now_s` that were not given yet."""
        if self._start_s is None:
            self._start_s = now_s
        end = int(np.floor((now_s - self._start_s) * self.rate_hz + 1e-3)) + 1
        numbers = np.arange(self._count, max(end, self._count))
        self._count = max(end, self._count)
        return numbers, self._start_s + numbers / self.rate_hz


class SimulatedPressure(_Linked):
    """A pressure controller with a sensor per chamber: reads the true pressure with noise of 0.05 kPa."""

    kind = "pressure controller"

    def __init__(
        self,
        plant: Plant,
        clock: Clock,
        name: str = "pressure",
        rate_hz: float = 30.0,
        noise_kpa: float = 0.05,
        seed: int = 0,
    ) -> None:
        super().__init__(plant, clock, name)
        self.channels: Sequence[Channel] = plant.channels
        self._low = np.array([c.min_kpa for c in plant.channels])
        self._high = np.array([c.max_kpa for c in plant.channels])
        self._ticker = _Ticker(rate_hz)
        self._noise_kpa = noise_kpa
        self._random = np.random.default_rng([seed, 6])

    def set(self, pressure_kpa: Floats) -> None:
        """Command set-points, kPa, (C,); outside a channel's limits nothing moves and `DeviceError` is
        raised.
        """
        self._need_link()
        wanted = np.asarray(pressure_kpa, dtype=float)
        if wanted.shape != self._low.shape:
            raise DeviceError(f"{self.name}: {wanted.size} set-points given for {self._low.size} channels")
        for channel, value in zip(self.channels, wanted, strict=True):
            if not (channel.min_kpa - _LIMIT_SLACK_KPA <= value <= channel.max_kpa + _LIMIT_SLACK_KPA):
                raise DeviceError(
                    f"{self.name}: {channel.name}: {value:g} kPa is outside "
                    f"{channel.min_kpa:g}..{channel.max_kpa:g} kPa; nothing was moved"
                )
        self._plant.command(self._clock.now_s(), wanted)

    def samples(self) -> list[PressureSample]:
        """Every measurement since the last call, oldest first; 30 Hz."""
        self._need_link()
        _, times = self._ticker.since_last(self._clock.now_s())
        if not times.size:
            return []
        read = self._plant.pressures_kpa(times)
        read = read + self._noise_kpa * self._random.normal(size=read.shape)
        return [PressureSample(float(t), p) for t, p in zip(times, read, strict=True)]

    def vent(self, timeout_s: float = 10.0) -> VentReport:
        """Vent every chamber and wait until all read below 1 kPa; raises `VentNotConfirmedError`."""
        self._need_link()
        began_s = self._clock.now_s()
        self._plant.command(began_s, np.zeros(len(self.channels)))
        while True:
            now_s = self._clock.now_s()
            read = self._plant.pressure_kpa(now_s)
            if np.all(np.abs(read) < VENTED_KPA):
                return VentReport(read, now_s - began_s)
            if now_s - began_s >= timeout_s:
                worst = int(np.argmax(np.abs(read)))
                raise VentNotConfirmedError(
                    f"{self.name}: {self.channels[worst].name} still reads {read[worst]:.1f} kPa "
                    f"{timeout_s:g} s after venting"
                )
            self._clock.sleep(0.05)


class SimulatedMocap(_Linked):
    """Cameras at a fixed rate that see the plant `latency_s` late; frames carry the time of their arrival."""

    kind = "motion capture"

    def __init__(
        self, plant: Plant, clock: Clock, name: str = "mocap", rate_hz: float = 100.0, latency_s: float = 0.01
    ) -> None:
        super().__init__(plant, clock, name)
        self.marker_names: Sequence[str] = plant.marker_names
        self._ticker = _Ticker(rate_hz)
        self._latency_s = latency_s

    def frames(self) -> list[MarkerFrame]:
        """Every frame since the last call, oldest first."""
        self._need_link()
        numbers, times = self._ticker.since_last(self._clock.now_s())
        if not times.size:
            return []
        position, status = self._plant.observe_frames(times - self._latency_s)
        return [
            MarkerFrame(float(t), int(n), p, s)
            for t, n, p, s in zip(times, numbers, position, status, strict=True)
        ]


class SimulatedScanner(_Linked):
    """A scanner that delivers the whole surface after `takes_s`, with noise along the normals; writes no
    files.
    """

    kind = "scanner"

    def __init__(
        self,
        plant: Plant,
        clock: Clock,
        name: str = "scanner",
        noise_mm: float = 0.05,
        takes_s: float = 15.0,
        seed: int = 0,
    ) -> None:
        super().__init__(plant, clock, name)
        self._noise_mm, self._takes_s = noise_mm, takes_s
        self._random = np.random.default_rng([seed, 7])

    def scan(self, timeout_s: float = 120.0) -> Scan:
        """Scan the surface as it is now; raises `DeviceError` if that takes longer than `timeout_s`."""
        self._need_link()
        if self._takes_s > timeout_s:
            self._clock.sleep(timeout_s)
            raise DeviceError(f"{self.name}: no complete scan within {timeout_s:g} s")
        self._clock.sleep(self._takes_s)
        now_s = self._clock.now_s()
        vertices, triangles = self._plant.surface(now_s)
        vertices = vertices + self._noise_mm * self._random.normal(size=vertices.shape)
        digest = hashlib.sha256(vertices.tobytes() + triangles.tobytes()).hexdigest()
        return Scan(now_s, vertices, triangles, (), digest, registration_error_mm=0.1)
