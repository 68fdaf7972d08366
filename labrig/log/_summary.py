"""What a closed MCAP file says of itself at its end: how many messages there are on each channel."""

import struct
import zlib
from mmap import mmap

_RECORD = struct.Struct("<BQ")
_FOOTER = struct.Struct("<BQQQI")
_FOOTER_FROM_END = _FOOTER.size + 8
_FOOTER_OPCODE, _STATISTICS = 0x02, 0x0B
_COUNTS_OFFSET = 8 + 2 + 4 * 4 + 8 + 8


def read_counts(data: bytes | mmap, size: int) -> dict[int, int] | None:
    """Messages per channel id; None if the summary is absent or its checksum is wrong."""
    place = size - _FOOTER_FROM_END
    if place < 0:
        return None
    opcode, length, start, offsets_start, crc = _FOOTER.unpack_from(data, place)
    if opcode != _FOOTER_OPCODE or length != 20 or not 0 < start <= place:
        return None
    summary = data[start:place]
    ending = struct.pack("<BQQQ", opcode, length, start, offsets_start)
    if zlib.crc32(ending, zlib.crc32(summary)) != crc:
        return None
    position = 0
    while position + _RECORD.size <= len(summary):
        opcode, length = _RECORD.unpack_from(summary, position)
        if opcode == _STATISTICS:
            return _counts(summary[position + _RECORD.size : position + _RECORD.size + length])
        position += _RECORD.size + length
    return None


def _counts(statistics: bytes) -> dict[int, int]:
    (length,) = struct.unpack_from("<I", statistics, _COUNTS_OFFSET)
    entries = statistics[_COUNTS_OFFSET + 4 : _COUNTS_OFFSET + 4 + length]
    return dict(struct.iter_unpack("<HQ", entries))
