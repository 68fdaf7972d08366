"""Payloads of the CGStream objects, decoded. Every count is checked against the bytes that are there.

All functions raise `CgstreamError` for a payload that is too short for what it claims.
"""

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from labrig_drivers._cgstream import CgstreamError

LABELED_DTYPE = np.dtype(
    [
        ("subject", "<u4"),
        ("marker", "<u4"),
        ("radius", "<f8"),
        ("position", "<f8", 3),
        ("covariance", "<f8", 9),
        ("trajectory", "<u4"),
    ]
)
UNLABELED_DTYPE = np.dtype(
    [("radius", "<f8"), ("position", "<f8", 3), ("covariance", "<f8", 9), ("trajectory", "<u4")]
)

_U32 = struct.Struct("<I")
_U64 = struct.Struct("<Q")
_F64 = struct.Struct("<d")
_TIMECODE = struct.Struct("<BBBBHHIIB")


@dataclass(frozen=True)
class Subject:
    """A tracked object: its markers' and segments' names by number, and each segment's parent (0: root)."""

    id: int
    name: str
    markers: dict[int, str]
    segments: dict[int, str]
    parents: dict[int, int]


@dataclass(frozen=True)
class Timecode:
    """SMPTE time of a frame, as the server sent it."""

    hours: int
    minutes: int
    seconds: int
    frames: int
    subframe: int
    subframes_per_frame: int
    standard: int
    user_bits: int
    field: int


class _Cursor:
    """Reads a payload front to back and never past its end."""

    def __init__(self, payload: bytes, what: str) -> None:
        self._payload = payload
        self._offset = 0
        self._what = what

    def take(self, count: int) -> bytes:
        end = self._offset + count
        if end > len(self._payload):
            raise CgstreamError(f"{self._what} ends after {len(self._payload)} of at least {end} bytes")
        piece = self._payload[self._offset : end]
        self._offset = end
        return piece

    def u32(self) -> int:
        return _U32.unpack(self.take(4))[0]

    def f64(self) -> float:
        return _F64.unpack(self.take(8))[0]

    def count(self, item_bytes: int) -> int:
        """A number of items, each of at least `item_bytes`, that the rest of the payload can hold."""
        number = self.u32()
        left = len(self._payload) - self._offset
        if number * item_bytes > left:
            raise CgstreamError(f"{self._what} claims {number} items, {left} bytes are left")
        return number

    def string(self) -> str:
        return self.take(self.count(1)).decode("utf-8", "replace")


def _fixed(layout: struct.Struct, payload: bytes, what: str) -> tuple:
    if len(payload) < layout.size:
        raise CgstreamError(f"{what} has {len(payload)} bytes, needs {layout.size}")
    return layout.unpack_from(payload)


def decode_u32(payload: bytes, what: str) -> int:
    """A single u32 (FrameInfo, HardwareFrame)."""
    return _fixed(_U32, payload, what)[0]


def decode_set(payload: bytes, what: str) -> frozenset[int]:
    """set<u32> (ObjectEnums)."""
    cursor = _Cursor(payload, what)
    count = cursor.count(4)
    return frozenset(struct.unpack(f"<{count}I", cursor.take(4 * count)))


def decode_contents(payload: bytes) -> tuple[dict[int, int], frozenset[int]]:
    """Contents: how many blocks of each object the packet carries, and the objects that are unchanged."""
    cursor = _Cursor(payload, "Contents")
    count = cursor.count(8)
    pairs = struct.unpack(f"<{2 * count}I", cursor.take(8 * count))
    unchanged_count = cursor.count(4)
    unchanged = struct.unpack(f"<{unchanged_count}I", cursor.take(4 * unchanged_count))
    return dict(zip(pairs[::2], pairs[1::2], strict=True)), frozenset(unchanged)


def decode_stream_period(payload: bytes) -> int:
    """StreamInfo: ticks of 1/135e6 s from frame to frame."""
    return _fixed(struct.Struct("<q"), payload, "StreamInfo")[0]


def decode_y_up(payload: bytes) -> bool:
    """ApplicationInfo: whether the server's y axis points up (otherwise z does)."""
    return _fixed(struct.Struct("<b"), payload, "ApplicationInfo")[0] == 1


def decode_subject(payload: bytes) -> Subject:
    """SubjectInfo."""
    cursor = _Cursor(payload, "SubjectInfo")
    number = cursor.u32()
    name = cursor.string()
    segments: dict[int, str] = {}
    parents: dict[int, int] = {}
    for _ in range(cursor.count(36)):
        parent, segment = cursor.u32(), cursor.u32()
        cursor.take(24)  # bounds
        parents[segment] = parent
        segments[segment] = cursor.string()
    markers: dict[int, str] = {}
    for _ in range(cursor.count(8)):
        marker = cursor.u32()
        markers[marker] = cursor.string()
    return Subject(number, name, markers, segments, parents)


def _records(payload: bytes, dtype: np.dtype, what: str) -> NDArray[np.void]:
    if len(payload) < 4:
        raise CgstreamError(f"{what} has {len(payload)} bytes, needs 4")
    count = _U32.unpack_from(payload)[0]
    if 4 + count * dtype.itemsize > len(payload):
        raise CgstreamError(f"{what} claims {count} items, {len(payload) - 4} bytes are left")
    return np.frombuffer(payload, dtype, count, 4)


def decode_labeled(payload: bytes) -> NDArray[np.void]:
    """LabeledRecons: a record array of `LABELED_DTYPE`, positions in mm; occluded markers are not in it."""
    return _records(payload, LABELED_DTYPE, "LabeledRecons")


def decode_unlabeled(payload: bytes) -> NDArray[np.void]:
    """UnlabeledRecons: a record array of `UNLABELED_DTYPE`, positions in mm."""
    return _records(payload, UNLABELED_DTYPE, "UnlabeledRecons")


def decode_latency(payload: bytes) -> float:
    """LatencyInfo: s from the exposure to the sending, the sum of what the server lists; never below 0."""
    cursor = _Cursor(payload, "LatencyInfo")
    total = 0.0
    for _ in range(cursor.count(12)):
        cursor.string()
        total += cursor.f64()
    return total if 0.0 <= total < 3600.0 else 0.0


def decode_timecode(payload: bytes) -> Timecode:
    """Timecode."""
    return Timecode(*_fixed(_TIMECODE, payload, "Timecode"))


def decode_ping(payload: bytes) -> int:
    """Ping: the number that comes back."""
    return _fixed(_U64, payload, "Ping")[0]
