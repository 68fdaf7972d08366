"""A board, tubes and chambers for tests of `labrig rig check`, with faults put in by hand.

The air of each line flows in through a regulator and out through a hole, both as orifices do: with the root of the
difference of pressures, not in proportion to it. A chamber has one tube to the board; the sensor sits at the chamber.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from labrig_drivers import Channel, Clock, DeviceError, Identity, PressureSample, VentReport

STEP_S = 0.002


@dataclass
class Faults:
    """What is wrong: by chamber, the hole in it, its sensor's zero and scale, its volume; and which tube goes where.

    `tube[n]` is the chamber that output n fills, None: it is off. `joint` are pairs whose lines are connected.
    """

    hole: dict[int, float] = field(default_factory=dict)
    zero_kpa: dict[int, float] = field(default_factory=dict)
    scale: dict[int, float] = field(default_factory=dict)
    volume: dict[int, float] = field(default_factory=dict)
    tube: dict[int, int | None] = field(default_factory=dict)
    joint: tuple[tuple[int, int], ...] = ()
    shut_in: bool = False


class Board:
    """A pressure controller over such lines; samples at 30 Hz with 0.05 kPa of noise."""

    def __init__(self, name: str, clock: Clock, channels: tuple[Channel, ...], faults: Faults) -> None:
        self.name, self.clock, self.faults = name, clock, faults
        self.channels: Sequence[Channel] = channels
        self.air_kpa = np.zeros(len(channels))
        self.target_kpa = np.zeros(len(channels))
        self._time_s = self._sampled_s = clock.now_s()
        self._since_s = 0.0
        self._random = np.random.default_rng(1)

    def connect(self) -> None: ...

    def close(self) -> None: ...

    def identify(self) -> Identity:
        return Identity(self.name, "board", "a board of a test")

    def set(self, pressure_kpa: np.ndarray) -> None:
        self._flow(self.clock.now_s())
        self.target_kpa, self._since_s = np.array(pressure_kpa, float), 0.0

    def samples(self) -> list[PressureSample]:
        found = []
        while self._sampled_s + 1 / 30 <= self.clock.now_s():
            self._sampled_s += 1 / 30
            self._flow(self._sampled_s)
            found.append(PressureSample(self._sampled_s, self._read()))
        return found

    def vent(self, timeout_s: float = 10.0) -> VentReport:
        self.set(np.zeros(len(self.channels)))
        self.clock.sleep(4.0)
        self._flow(self.clock.now_s())
        read = self._read()
        if np.abs(read).max() > 3.0:
            raise DeviceError(f"{self.name}: not vented")
        return VentReport(read, 4.0)

    def _read(self) -> np.ndarray:
        count = len(self.channels)
        scale = np.array([self.faults.scale.get(n, 1.0) for n in range(count)])
        zero = np.array([self.faults.zero_kpa.get(n, 0.0) for n in range(count)])
        return scale * self.air_kpa + zero + 0.05 * self._random.normal(size=count)

    def _flow(self, until_s: float) -> None:
        while self._time_s + STEP_S <= until_s:
            self._time_s += STEP_S
            self._since_s += STEP_S
            change = np.zeros(len(self.channels))
            for output in range(len(self.channels)):
                chamber = self.faults.tube.get(output, output)
                closed = self.faults.shut_in and self.target_kpa[output] != 0 and self._since_s > 1.0
                if chamber is not None and not closed:
                    change[chamber] += 40.0 * _orifice(self.target_kpa[output] - self.air_kpa[chamber])
            for chamber, hole in self.faults.hole.items():
                change[chamber] -= 40.0 * hole * _orifice(self.air_kpa[chamber])
            for first, second in self.faults.joint:
                across = 20.0 * _orifice(self.air_kpa[first] - self.air_kpa[second])
                change[first] -= across
                change[second] += across
            volume = np.array([self.faults.volume.get(n, 1.0) for n in range(len(self.channels))])
            self.air_kpa = self.air_kpa + STEP_S * change / volume


def _orifice(difference_kpa: float) -> float:
    """Flow through an orifice, laminar below 1 kPa."""
    return (
        math.copysign(math.sqrt(abs(difference_kpa)), difference_kpa)
        if abs(difference_kpa) > 1
        else difference_kpa
    )
