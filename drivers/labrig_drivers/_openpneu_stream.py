"""What an OpenPneu board sends, taken apart: telemetry and replies, even where one lands inside the other.

The published firmware prints telemetry from an interrupt, so ``T1.00,...;`` can appear in the middle of
a reply's line. Nothing here does input or output: bytes in, events out.
"""

import math
import re
from dataclasses import dataclass

SENSORS = 10
MAX_LINE_BYTES = 256
MAX_TELEMETRY_BYTES = 200

_NUMBER = re.compile(rb"-?\d{1,7}\.\d\d|nan|inf|-inf|ovf", re.ASCII)
"""Two decimals: where the link lost a byte, 12.34 came as 1234."""
_TELEMETRY_BYTES = frozenset(b"0123456789.,-;\rnaifov")


@dataclass(frozen=True, slots=True)
class Telemetry:
    """One telemetry line: `SENSORS` pressures, kPa; NaN for what is no number."""

    pressure_kpa: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Reply:
    """One line that is not telemetry, without its end; bytes outside ASCII are shown as ``?``."""

    text: str


class StreamParser:
    """Turns bytes, in pieces of any size, into `Telemetry` and `Reply` events; holds less than 1 kB.

    Lines above `MAX_LINE_BYTES` are cut there and given out as replies, so that a flood of anything
    passes through in bounded memory.
    """

    def __init__(self) -> None:
        self._line = bytearray()
        self._candidate = bytearray()  # begins with T while it may still be telemetry

    def feed(self, data: bytes) -> list[Telemetry | Reply]:
        """Take in `data`; returns the events that it completes, in order."""
        events: list[Telemetry | Reply] = []
        for byte in data:
            if self._candidate:
                self._continue(byte, events)
            elif byte == 0x54:  # T
                self._candidate.append(byte)
            else:
                self._text(byte, events)
        return events

    def _continue(self, byte: int, events: list[Telemetry | Reply]) -> None:
        candidate = self._candidate
        if byte == 0x0A and candidate.endswith(b";\r"):
            values = _values(bytes(candidate[1:-2]))
            if values is not None:
                candidate.clear()
                events.append(Telemetry(values))
                return
        elif (
            byte in _TELEMETRY_BYTES
            and len(candidate) < MAX_TELEMETRY_BYTES
            and (byte != 0x0D or candidate.endswith(b";"))
        ):
            candidate.append(byte)
            return
        self._release(events)
        if byte == 0x54:
            candidate.append(byte)
        else:
            self._text(byte, events)

    def _release(self, events: list[Telemetry | Reply]) -> None:
        # It was no telemetry after all: a reply that begins with T.
        for byte in self._candidate:
            self._text(byte, events)
        self._candidate.clear()

    def _text(self, byte: int, events: list[Telemetry | Reply]) -> None:
        if byte == 0x0A:
            text = self._line.decode("ascii", "replace").replace("�", "?").strip("\r")
            self._line.clear()
            if text:
                events.append(Reply(text))
            return
        self._line.append(byte)
        if len(self._line) >= MAX_LINE_BYTES:
            self._text(0x0A, events)


def _values(body: bytes) -> tuple[float, ...] | None:
    fields = body.split(b",")
    if len(fields) != SENSORS:
        return None
    values: list[float] = []
    for text in fields:
        if _NUMBER.fullmatch(text) is None:
            return None
        values.append(math.nan if text[-1:].isalpha() else float(text))
    return tuple(values)


def telemetry_line(pressure_kpa: tuple[float, ...]) -> bytes:
    """The line that the firmware prints for these `SENSORS` pressures, kPa."""
    return b"T" + b",".join(b"%.2f" % value for value in pressure_kpa) + b";\r\n"
