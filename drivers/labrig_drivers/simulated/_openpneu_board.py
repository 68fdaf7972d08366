"""An OpenPneu board without its serial port: commands in, replies out, quirks included."""

import math
import re
from typing import Literal

import numpy as np

from labrig_drivers._openpneu_stream import SENSORS, telemetry_line
from labrig_drivers.simulated._wire_plant import SharedPlant

RANGE_KPA = 100.0
PUMP_LIMIT_KPA = 180.0
PUMP_KPA_S = 15.0
DRIVEN_WHEN_PUBLISHED = (2, 3)
MAX_LINE_BYTES = 128


class OpenPneuBoard:
    """The firmware. `build` `published` has its quirks, `full` the corrected behaviour.

    Published: one target for each even/odd pair, only channels 2 and 3 driven, odd channels show the even
    sensor, targets not clamped, and above 100 kPa the pumps stay on as they were. Full: each channel on
    its own, targets clamped to the range, pumps off above it. In both, V stops the pumps and opens the
    valves, and nothing watches the host. `outputs` are the board's channels of the plant's chambers.
    """

    def __init__(
        self,
        plant: SharedPlant,
        dialect: Literal["published", "table"] = "published",
        build: Literal["published", "full"] = "full",
        outputs: tuple[int, ...] | None = None,
        dead_band_kpa: float | None = None,
    ) -> None:
        count = len(plant.channels)
        self.outputs = tuple(range(count)) if outputs is None else outputs
        self.dialect = dialect
        self._plant = plant
        self._published = build == "published"
        self._default_dead_band_kpa = dead_band_kpa if dead_band_kpa is not None else 2.0
        self.reset()

    def reset(self) -> None:
        """What opening the port does: targets 0, everything at rest."""
        self.running = False
        self.selected = 0
        self.target_kpa = np.zeros(SENSORS)
        self.dead_band_kpa = self._default_dead_band_kpa
        self._effort_kpa = np.zeros(SENSORS)
        self._sent: np.ndarray | None = None
        self._line = bytearray()
        self.control(0.0)

    def sensors_kpa(self) -> np.ndarray:
        """What the sensors of all channels read, kPa, (10,)."""
        values = np.zeros(SENSORS)
        values[list(self.outputs)] = self._plant.pressure_kpa()
        if self._published:
            values[1::2] = values[0::2]
        return values

    def telemetry(self) -> bytes:
        """The line that the running timer prints."""
        return telemetry_line(tuple(self.sensors_kpa().tolist()))

    def feed(self, data: bytes) -> list[bytes]:
        """Bytes from the host; returns the replies that they cause, each with its line end."""
        replies: list[bytes] = []
        for byte in data:
            if byte != 0x0A:
                if len(self._line) < MAX_LINE_BYTES:
                    self._line.append(byte)
                continue
            line = bytes(self._line)
            self._line.clear()
            if not line.endswith(b"\r"):
                replies.append(b"Error end check\r\n")
                continue
            text = line[:-1].decode("ascii", "replace")
            answers = self._published_command(text) if self.dialect == "published" else self._table(text)
            replies += [answer.encode("ascii", "replace") + b"\r\n" for answer in answers]
        return replies

    def control(self, elapsed_s: float) -> None:
        """Let the control loop act for `elapsed_s`: set-points of the plant from targets and quirks."""
        actual = np.zeros(SENSORS)
        actual[list(self.outputs)] = self._plant.pressure_kpa()
        sensed = actual.copy()
        if self._published:
            sensed[1::2] = sensed[0::2]
        for channel in range(SENSORS):
            self._effort_kpa[channel] = self._drive(channel, float(sensed[channel]), elapsed_s)
        commanded = self._effort_kpa[list(self.outputs)]
        if self._sent is None or not np.array_equal(commanded, self._sent):
            self._plant.command(commanded)
            self._sent = commanded

    def _drive(self, channel: int, sensed_kpa: float, elapsed_s: float) -> float:
        effort = float(self._effort_kpa[channel])
        if not self.running or (self._published and channel not in DRIVEN_WHEN_PUBLISHED):
            return 0.0
        target = float(self.target_kpa[channel])
        if abs(sensed_kpa) > RANGE_KPA and self._published:
            # The loop returns here: whatever the pumps did, they go on doing.
            if abs(effort) <= RANGE_KPA:
                return effort
            return math.copysign(min(abs(effort) + PUMP_KPA_S * elapsed_s, PUMP_LIMIT_KPA), effort)
        if not self._published:
            low = -RANGE_KPA if channel % 2 == 0 else 0.0
            target = min(max(target, low), RANGE_KPA)
        target = min(max(target, -PUMP_LIMIT_KPA), PUMP_LIMIT_KPA)
        near = abs(target - effort) < self.dead_band_kpa and self._published
        return effort if near and target != 0.0 else target

    def _published_command(self, text: str) -> list[str]:
        if text == "AT":
            return ["OK;Successful"]
        if text == "AT+ADDRESS":
            return ["OpenPneu2.0"]
        if text == "AT+VERSION":
            return ["Version 2.0OK"]
        if text == "AT+PRESSURE":
            return [f"{self.sensors_kpa()[0]:.2f}"]
        if text.startswith("SC="):
            self.selected = int(_number(text[3:]))
            return [f"Select Channel {self.selected}"]
        if text.startswith("T="):
            self._set_target(self.selected, _number(text[2:]))
            return []
        if text.startswith("ST="):
            self.dead_band_kpa = abs(_number(text[3:]))
            return [f"Dead band {self.dead_band_kpa:.2f}"]
        if text == "C":
            self.running = True
            return ["Timer Starts..."]
        if text == "V":
            self.running = False
            return ["Timer Pauses...", "Stop All Motors"]
        if text in ("P", "PP"):
            self.running = False
            return ["Timer Pauses..."]
        return ["Error command"]

    def _set_target(self, channel: int, value_kpa: float) -> None:
        if not 0 <= channel < SENSORS:  # the firmware writes past its array here; the twin does nothing
            return
        if self._published:
            self.target_kpa[channel - channel % 2 : channel - channel % 2 + 2] = value_kpa
        else:
            self.target_kpa[channel] = value_kpa

    def _table(self, text: str) -> list[str]:
        if text == "AT":
            return ["OK"]
        if text == "AT+ADD":
            return ["ADD=01"]
        if match := re.fullmatch(r"PSET=(\d+),(\S+)", text):
            channel, value = int(match[1]), _number(match[2])
            self._set_target(channel, value)
            return [f"{channel}={value:.2f}"]
        if match := re.fullmatch(r"PSET:(.+)", text):
            for channel, value in enumerate(match[1].rstrip(";").split(",")[:SENSORS]):
                self._set_target(channel, _number(value))
            return ["OK"]
        if match := re.fullmatch(r"PREAD=(\d+)", text):
            channel = int(match[1])
            return [f"Val={self.sensors_kpa()[channel]:.2f}"] if channel < SENSORS else ["Error command"]
        if text in ("CON", "COFF"):
            self.running = text == "CON"
            return ["OK"]
        if text == "AT+RST":
            self.reset()
            return ["OK"]
        if text in ("VON", "VOFF") or text.startswith("PSPEED"):
            return ["OK"]
        return ["Error command"]


def _number(text: str) -> float:
    # As the firmware reads numbers: the leading digits count, and what is no number is 0.
    match = re.match(r"\s*([+-]?\d{1,9}(?:\.\d{0,9})?)", text, re.ASCII)
    return float(match[1]) if match else 0.0
