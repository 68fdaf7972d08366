"""A rig of two chambers and three markers in a few lines, for tests of everything above the drivers.

The markers follow the pressures with a time constant of 0.5 s; every third frame does not see the last marker.
Faults are armed through `FakePressure.faults` and `FakeMocap.faults`.
"""

import math
from typing import Any

import numpy as np

from labrig_drivers import (
    Channel,
    Clock,
    DeviceError,
    Identity,
    MarkerFrame,
    MarkerStatus,
    PressureSample,
    Scan,
    VentNotConfirmedError,
    VentReport,
)

RATE_HZ = 20.0
TIME_CONSTANT_S = 0.5


class World:
    """The chambers' pressures over time, shared by the devices of one rig."""

    def __init__(self, chambers: int, clock: Clock) -> None:
        self.clock = clock
        self.start_kpa = np.zeros(chambers)
        self.target_kpa = np.zeros(chambers)
        self.since_s = clock.now_s()
        self.commands: list[tuple[float, tuple[float, ...]]] = []

    def command(self, target_kpa: Any) -> None:
        """Move towards a new target from now on."""
        now_s = self.clock.now_s()
        self.start_kpa, self.since_s = self.pressure(now_s), now_s
        self.target_kpa = np.array(target_kpa, float)
        self.commands.append((now_s, tuple(self.target_kpa.tolist())))

    def pressure(self, time_s: float) -> Any:
        """The pressures at a time, kPa."""
        share = math.exp(-max(0.0, time_s - self.since_s) / TIME_CONSTANT_S)
        return self.target_kpa + (self.start_kpa - self.target_kpa) * share


def world_of(clock: Any, chambers: int = 2) -> World:
    """The world that belongs to a clock, and lives as long."""
    if not hasattr(clock, "world"):
        clock.world = World(chambers, clock)
    return clock.world


class _Fake:
    version, port = "1", "A"

    def __init__(self, name: str, clock: Clock) -> None:
        self.name, self.clock = name, clock
        self.faults: dict[str, Any] = {}
        self.last_s = clock.now_s()
        self.closed = False

    def connect(self) -> None:
        self.last_s = self.clock.now_s()

    def identify(self) -> Identity:
        return Identity(
            self.name, "fake", f"a fake {self.name}", {"version": self.version, "port": self.port}
        )

    def close(self) -> None:
        self.closed = True

    def _ticks(self) -> list[float]:
        now_s = self.clock.now_s()
        first, last = math.floor(self.last_s * RATE_HZ) + 1, math.floor(now_s * RATE_HZ)
        self.last_s = now_s
        return [tick / RATE_HZ for tick in range(first, last + 1)]


class FakePressure(_Fake):
    """A pressure controller; `faults`: lost_until_s, stale (until it is connected anew), over_kpa
    (while a set-point is above ambient), creep_kpa (0.3 s after a vent), never_vents, and

    leaks: by chamber, how fast it empties for each kPa in it, kPa/s, against the filling that the world's time
    constant stands for; infinite where the tube is off. leaks_until_vents: the leaks end with so many vents.
    """

    def __init__(self, name: str, clock: Clock, channels: tuple[Channel, ...]) -> None:
        super().__init__(name, clock)
        self.channels = channels
        self.world = world_of(clock, len(channels))
        self.vents: list[float] = []

    def connect(self) -> None:
        super().connect()
        self.faults.pop("stale", None)

    def _check_link(self) -> None:
        if self.clock.now_s() < self.faults.get("lost_until_s", -math.inf):
            raise DeviceError(f"{self.name}: the link is lost")

    def set(self, pressure_kpa: Any) -> None:
        self._check_link()
        for channel, value in zip(self.channels, pressure_kpa, strict=True):
            if not channel.min_kpa <= value <= channel.max_kpa:
                raise DeviceError(f"{self.name}: {channel.name} {value:g} kPa is outside its limits")
        self.world.command(pressure_kpa)

    def samples(self) -> list[PressureSample]:
        self._check_link()
        if self.faults.get("stale"):
            return []
        return [
            PressureSample(time_s, self._left(self.world.pressure(time_s)) + self._over(time_s))
            for time_s in self._ticks()
        ]

    def _over(self, time_s: float) -> float:
        over = self.faults.get("over_kpa", 0.0) if self.world.target_kpa.any() else 0.0
        crept = bool(self.vents) and time_s > self.vents[-1] + 0.3
        return over + (self.faults.get("creep_kpa", 0.0) if crept else 0.0)

    def _left(self, pressure_kpa: Any) -> Any:
        """What a leak leaves of a pressure: filling and emptying through two conductances in balance."""
        left = np.array(pressure_kpa)
        if len(self.vents) < self.faults.get("leaks_until_vents", math.inf):
            for chamber, rate in self.faults.get("leaks", {}).items():
                left[chamber] /= 1.0 + rate * TIME_CONSTANT_S
        return left

    def vent(self, timeout_s: float = 10.0) -> VentReport:
        self._check_link()
        started_s = self.clock.now_s()
        self.world.command(np.zeros(len(self.channels)))
        while self.faults.get("never_vents") or np.abs(self.world.pressure(self.clock.now_s())).max() > 0.5:
            if self.clock.now_s() - started_s >= timeout_s:
                raise VentNotConfirmedError(f"{self.name}: not vented after {timeout_s:g} s")
            self.clock.sleep(0.1)
            self._check_link()
        self.vents.append(self.clock.now_s())
        return VentReport(self.world.pressure(self.clock.now_s()), self.clock.now_s() - started_s)


class FakeMocap(_Fake):
    """Motion capture; `faults`: lost (no frames), thinned (only one of so many arrives)."""

    def __init__(self, name: str, clock: Clock, marker_names: tuple[str, ...]) -> None:
        super().__init__(name, clock)
        self.marker_names = marker_names
        self.world = world_of(clock)
        self.number = 0

    def frames(self) -> list[MarkerFrame]:
        taken = [] if self.faults.get("lost") else [self._frame(time_s) for time_s in self._ticks()]
        return [frame for frame in taken if frame.number % self.faults.get("thinned", 1) == 0]

    def _frame(self, time_s: float) -> MarkerFrame:
        self.number += 1
        lift_mm = self.world.pressure(time_s).sum() / 10.0
        position = np.array([[10.0 * index, 0.0, lift_mm] for index in range(len(self.marker_names))])
        status = np.full(len(self.marker_names), MarkerStatus.SEEN, np.int8)
        if self.number % 3 == 0:
            position[-1] = np.nan
            status[-1] = MarkerStatus.OCCLUDED
        return MarkerFrame(time_s, self.number, position, status)


class FakeScanner(_Fake):
    """A scanner that takes 2 s; `faults`: never."""

    def scan(self, timeout_s: float = 120.0) -> Scan:
        """One triangle."""
        for _ in range(20):
            self.clock.sleep(0.1)
        if self.faults.get("never"):
            self.clock.sleep(timeout_s - 2.0)
            raise DeviceError(f"{self.name}: no scan within {timeout_s:g} s")
        return Scan(self.clock.now_s(), np.eye(3), np.array([[0, 1, 2]]), (), "0" * 64, 0.2)
