"""Vicon DataStream's wire format (CGStream): numbers of its objects, packets and blocks.

Little-endian, no padding. A packet is ``u32 0x1a2b0001, u32 length`` and then blocks of
``u32 object, u32 length, payload``. Nothing here does input or output: bytes in, values out.
"""

import struct
from collections.abc import Iterable, Iterator
from enum import IntEnum

MAGIC = 0x1A2B0001
MAX_PACKET_BYTES = 4 << 20  # 34 markers are 4 kB, a thousand 120 kB
CLOCK_HZ = 135e6  # StreamInfo's period counts these ticks

_HEADER = struct.Struct("<II")


class CgstreamError(ValueError):
    """Bytes that are no CGStream; the message says what was found and where."""


class CgObject(IntEnum):
    """Numbers of DataStream's objects; the client subscribes to those in `WANTED`."""

    STREAM_INFO = 1
    SUBJECT_INFO = 2
    FRAME_INFO = 5
    LABELED_RECONS = 6
    UNLABELED_RECONS = 7
    LOCAL_SEGMENTS = 8
    GLOBAL_SEGMENTS = 9
    TIMECODE = 23
    LATENCY_INFO = 26
    SUBJECT_TOPOLOGY = 28
    SUBJECT_HEALTH = 29
    HARDWARE_FRAME = 36
    APPLICATION_INFO = 37
    FRAME_RATE_INFO = 39
    OBJECT_QUALITY = 40
    PING = 42
    LIGHTWEIGHT_SEGMENTS = 901
    OBJECT_ENUMS = 100001
    REQUEST_FRAME = 100002
    KEEP_ALIVE = 100003
    CONTENTS = 100004
    FILTER = 100007
    REQUEST_NEXT_FRAME = 100008


STATIC_OBJECTS = frozenset(
    {CgObject.STREAM_INFO, CgObject.SUBJECT_INFO, CgObject.APPLICATION_INFO, CgObject.SUBJECT_TOPOLOGY}
)
"""Objects that describe the session; a packet that carries one replaces all of them (see Contents)."""

_NOT_DYNAMIC = STATIC_OBJECTS | {CgObject.PING}


def is_dynamic(number: int) -> bool:
    """Whether a block of this object makes its packet a frame."""
    return number < CgObject.OBJECT_ENUMS and number not in _NOT_DYNAMIC


class PacketReader:
    """Cuts a byte stream, in pieces of any size, into packet bodies; holds at most one packet.

    Raises `CgstreamError` on a wrong magic number or a length above `max_packet_bytes`. The stream has
    no way back into step after that: the connection has to be opened anew.
    """

    def __init__(self, max_packet_bytes: int = MAX_PACKET_BYTES) -> None:
        self._max_packet_bytes = max_packet_bytes
        self._buffer = bytearray()

    @property
    def pending_bytes(self) -> int:
        """Bytes held back for a packet that is not complete yet."""
        return len(self._buffer)

    def feed(self, data: bytes) -> list[bytes]:
        """Take in `data` and return the bodies (without header) of the packets that it completes."""
        buffer = self._buffer
        buffer += data
        bodies: list[bytes] = []
        start = 0
        while len(buffer) - start >= 8:
            magic, length = _HEADER.unpack_from(buffer, start)
            if magic != MAGIC:
                found = bytes(buffer[start : start + 8])
                raise CgstreamError(f"a packet begins with {found!r}, not with 0x{MAGIC:08x}")
            if length > self._max_packet_bytes:
                raise CgstreamError(
                    f"a packet of {length} bytes is above the cap of {self._max_packet_bytes}"
                )
            if len(buffer) - start < 8 + length:
                break
            bodies.append(bytes(memoryview(buffer)[start + 8 : start + 8 + length]))
            start += 8 + length
        if start:
            del buffer[:start]
        return bodies


def blocks(body: bytes) -> Iterator[tuple[int, bytes]]:
    """The (object number, payload) pairs of a packet body; a block that overruns it is a `CgstreamError`."""
    offset, end = 0, len(body)
    while offset < end:
        if end - offset < 8:
            raise CgstreamError(f"{end - offset} bytes are left after the last block")
        number, length = _HEADER.unpack_from(body, offset)
        offset += 8
        if length > end - offset:
            raise CgstreamError(f"block {number} claims {length} bytes, its packet has {end - offset} left")
        yield number, body[offset : offset + length]
        offset += length


def block(number: int, payload: bytes) -> bytes:
    """One encoded block."""
    return _HEADER.pack(number, len(payload)) + payload


def packet(encoded_blocks: Iterable[bytes]) -> bytes:
    """One encoded packet of blocks that are encoded already."""
    body = b"".join(encoded_blocks)
    return _HEADER.pack(MAGIC, len(body)) + body
