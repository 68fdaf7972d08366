"""A rig in this process whose devices stream at full rate: what is left is the runner's own cost."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from labrig.rig import Rig, RigConfig, parse_rig
from labrig_drivers import Clock, Identity, MarkerFrame, PressureSample, VentReport

MARKERS, CHAMBERS, FRAME_HZ, SAMPLE_HZ = 34, 10, 100.0, 30.0
MARKER_NAMES = [f"m{n + 1:02d}" for n in range(MARKERS)]
CHAMBER_NAMES = [f"c{n + 1}" for n in range(CHAMBERS)]


class Streaming:
    """Pressure and motion capture at full rate, in this process: only the runner's own cost is left."""

    def __init__(self, name: str, clock: Clock, config: RigConfig, rate_hz: float) -> None:
        self.name, self.clock, self.rate_hz = name, clock, rate_hz
        self.channels, self.marker_names = config.channels, config.markers
        self.target = np.zeros(len(config.channels))
        self.positions = np.random.default_rng(0).normal(scale=50.0, size=(500, len(config.markers), 3))
        self.status = np.zeros(len(config.markers), np.int8)
        self.start_s, self.count = clock.now_s(), 0

    def connect(self) -> None:
        """Nothing to open."""

    def close(self) -> None:
        """Nothing to release."""

    def identify(self) -> Identity:
        """A benchmark's device."""
        return Identity(self.name, "benchmark", "streams")

    def _new(self) -> Iterator[tuple[float, int]]:
        total = int((self.clock.now_s() - self.start_s) * self.rate_hz)
        while self.count < total:
            self.count += 1
            yield self.start_s + self.count / self.rate_hz, self.count

    def set(self, pressure_kpa: Any) -> None:
        """Reached at once."""
        self.target = np.array(pressure_kpa, float)

    def samples(self) -> list[PressureSample]:
        """Every measurement since the last call."""
        return [PressureSample(time_s, self.target) for time_s, _ in self._new()]

    def frames(self) -> list[MarkerFrame]:
        """Every frame since the last call."""
        return [
            MarkerFrame(time_s, number, self.positions[number % 500], self.status)
            for time_s, number in self._new()
        ]

    def vent(self, timeout_s: float = 10.0) -> VentReport:
        """At once."""
        self.target = np.zeros(len(self.channels))
        return VentReport(self.target, 0.0)


def make_rig(clock: Clock, frame_hz: float = FRAME_HZ, sample_hz: float = SAMPLE_HZ) -> Rig:
    """A rig of ten chambers without slew limits and 34 markers."""
    content = {
        "name": "benchmark",
        "chambers": [{"name": name, "max_kpa": 60, "slew_kpa_s": 1e6} for name in CHAMBER_NAMES],
        "markers": MARKER_NAMES,
        "pressure": {"kind": "benchmark"},
        "mocap": {"kind": "benchmark"},
    }
    config = parse_rig(content, "benchmark", Path())
    pressure = Streaming("pressure", clock, config, sample_hz)
    return Rig(config, clock, pressure, Streaming("mocap", clock, config, frame_hz))
