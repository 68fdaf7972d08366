"""Reads one MCAP segment, whatever has happened to it: every whole chunk is kept, every loss is said."""

import mmap
import struct
import zlib
from dataclasses import dataclass, field
from pathlib import Path

from labrig._errors import LabrigError
from labrig.log._summary import read_counts
from labrig.log._topics import Topic, topic_table

_MAGIC = b"\x89MCAP0\r\n"
_METADATA, _CHUNK, _MESSAGE, _DATA_END = 0x0C, 0x06, 0x05, 0x0F
_LAST_OPCODE = 0x0F
_RECORD = struct.Struct("<BQ")
_MESSAGE_HEAD = struct.Struct("<BQHIQQ")
_CHUNK_HEAD = struct.Struct("<BQQQQII")
_CHUNK_MARK = b"\x04\x00\x00\x00zstd"
_MARK_OFFSET = _CHUNK_HEAD.size - 4
_MAX_CHUNK_BYTES = 1 << 31


@dataclass
class Messages:
    """The messages of one topic in the order in which they were written."""

    time_ns: list[int] = field(default_factory=list)
    payload: list[bytes] = field(default_factory=list)
    sequence: list[int] = field(default_factory=list)


@dataclass
class Segment:
    """What could be read of one file."""

    path: Path
    metadata: dict[str, dict[str, str]]
    topics: dict[Topic, Messages]
    warnings: list[str]
    closed: bool


def read_segment(path: Path) -> Segment:
    """Read a segment and check every checksum.

    Raises `LabrigError` if the file cannot be opened, is no MCAP, or holds nothing whole.
    """
    try:
        size = path.stat().st_size
        if size == 0:
            raise LabrigError(f"{path} is empty: nothing of this log was written")
        with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
            return _Scanner(path, data, size).run()
    except OSError as error:
        raise LabrigError(f"cannot read {path}: {error.strerror or error}") from None


class _Scanner:
    def __init__(self, path: Path, data: mmap.mmap, size: int) -> None:
        import zstandard

        self.path, self.data, self.size = path, data, size
        self.metadata: dict[str, dict[str, str]] = {}
        self.topics: dict[int, Messages] = {int(topic): Messages() for topic in Topic}
        self.warnings: list[str] = []
        self.decompressor = zstandard.ZstdDecompressor()
        self.error = zstandard.ZstdError
        self.good_end = 0
        self.read_end = 8
        self.chunks = 0

    def run(self) -> Segment:
        has_magic = self.data[:8] == _MAGIC
        position = 8 if has_magic else self._next_chunk(0)
        if not has_magic and position < 0:
            raise LabrigError(
                f"{self.path} is not an MCAP file, or nothing of it is whole; `labrig import` makes a run of a table"
            )
        if not has_magic:
            self.warnings.append(f"{self.path.name}: the first {position} bytes are damaged and were skipped")
        while 0 <= position < self.size:
            position = self._record(position)
        closed = self.size >= 16 and self.data[self.size - 8 : self.size] == _MAGIC
        if not closed:
            lost = self.size - self.read_end
            tail = f"; the last {lost} bytes hold no whole chunk" if self.chunks and lost else ""
            self.warnings.append(
                f"{self.path.name}: not closed (the run was killed or goes on, or the file was cut){tail}"
            )
        if not self.chunks:
            raise LabrigError(f"{self.path} holds no whole chunk: nothing of it can be read")
        self._count_lost(closed)
        topics = {topic: self.topics[topic] for topic in Topic if self.topics[topic].payload}
        return Segment(self.path, self.metadata, topics, self.warnings, closed)

    def _record(self, position: int) -> int:
        """Handle the record at `position`; returns where the next one begins, or -1 at the end."""
        if position + _RECORD.size > self.size:
            return -1
        opcode, length = _RECORD.unpack_from(self.data, position)
        end = position + _RECORD.size + length
        if not 0 < opcode <= _LAST_OPCODE or end > self.size:
            return self._resync(position)
        if opcode == _DATA_END and length == 4:
            return -1
        if opcode == _CHUNK:
            if self._chunk(position, end):
                self.chunks += 1
                self.good_end = self.read_end = end
                return end
            return self._lose(position) if position + _CHUNK_HEAD.size <= end else self._resync(position)
        if opcode == _METADATA:
            self._metadata(position + _RECORD.size, end)
        self.read_end = max(self.read_end, end)
        return end

    def _resync(self, position: int) -> int:
        start = max(self.good_end, 8)
        found = self._next_chunk(start)
        while 0 <= found < position:  # it was seen already, or it belongs to a chunk that is lost
            if self._chunk(found, self._end_of(found), keep=False):
                break
            found = self._next_chunk(found + 1)
        if found >= 0:
            self.warnings.append(
                f"{self.path.name}: damaged between bytes {self.good_end} and {found}; that part is lost"
            )
        return found

    def _lose(self, position: int) -> int:
        _, _, start_ns, end_ns, _, _, _ = _CHUNK_HEAD.unpack_from(self.data, position)
        seconds = f"{(end_ns - start_ns) * 1e-9:.1f} s" if 0 <= end_ns - start_ns < 10**14 else "some seconds"
        self.warnings.append(
            f"{self.path.name}: the chunk at byte {position} fails its checksum; {seconds} of log are lost"
        )
        return self._next_chunk(position + 1)

    def _end_of(self, position: int) -> int:
        return position + _RECORD.size + _RECORD.unpack_from(self.data, position)[1]

    def _next_chunk(self, start: int) -> int:
        """Where the next whole chunk begins at or after `start`, or -1."""
        found = self.data.find(_CHUNK_MARK, start)
        while found >= 0:
            position = found - _MARK_OFFSET
            if position >= start and self.data[position] == _CHUNK:
                end = self._end_of(position)
                if end <= self.size and self._chunk(position, end, keep=False):
                    return position
            found = self.data.find(_CHUNK_MARK, found + 1)
        return -1

    def _chunk(self, position: int, end: int, keep: bool = True) -> bool:
        """Read the chunk at `position`; false if it is damaged."""
        head_end = position + _CHUNK_HEAD.size
        if head_end + 12 > end:
            return False
        _, _, _, _, plain_size, crc, name_size = _CHUNK_HEAD.unpack_from(self.data, position)
        if name_size != 4 or self.data[head_end : head_end + 4] != b"zstd" or plain_size > _MAX_CHUNK_BYTES:
            return False
        (packed_size,) = struct.unpack_from("<Q", self.data, head_end + 4)
        if head_end + 12 + packed_size != end:
            return False
        try:
            plain = self.decompressor.decompress(self.data[head_end + 12 : end], max_output_size=plain_size)
        except (self.error, MemoryError):  # a damaged head may promise any size
            return False
        if len(plain) != plain_size or zlib.crc32(plain) != crc:
            return False
        if keep:
            self._messages(plain)
        return True

    def _messages(self, plain: bytes) -> None:
        position, size, topics = 0, len(plain), self.topics
        unpack, head = _MESSAGE_HEAD.unpack_from, _MESSAGE_HEAD.size
        while position + head <= size:  # shorter than a message's head: nothing that matters here
            opcode, length, channel, sequence, time_ns, _ = unpack(plain, position)
            end = position + 9 + length
            if opcode == _MESSAGE and (messages := topics.get(channel)) is not None:
                messages.time_ns.append(time_ns)
                messages.payload.append(plain[position + head : end])
                messages.sequence.append(sequence)
            position = end

    def _metadata(self, position: int, end: int) -> None:
        """Keep a metadata record: a name, then pairs of strings; a damaged one is left out."""
        try:
            name, position = self._string(position, end)
            position += 4
            pairs: dict[str, str] = {}
            while position < end:
                key, position = self._string(position, end)
                pairs[key], position = self._string(position, end)
        except (UnicodeDecodeError, struct.error, ValueError):
            self.warnings.append(f"{self.path.name}: a metadata record is damaged")
            return
        self.metadata[name] = pairs

    def _string(self, position: int, end: int) -> tuple[str, int]:
        (length,) = struct.unpack_from("<I", self.data, position)
        if position + 4 + length > end:
            raise ValueError("the string is longer than its record")
        return str(self.data[position + 4 : position + 4 + length], "utf-8"), position + 4 + length

    def _count_lost(self, closed: bool) -> None:
        """Compare what was read with the numbers of the messages, and with the counts at a closed file's end."""
        counts = read_counts(self.data, self.size) if closed else None
        if closed and counts is None:
            self.warnings.append(f"{self.path.name}: its summary is damaged; the end may be incomplete")
        for topic, info in topic_table().items():
            sequence = self.topics[topic].sequence
            total = sequence[-1] if counts is None and sequence else (counts or {}).get(topic, 0)
            if (lost := total - len(sequence)) > 0:
                self.warnings.append(f"{self.path.name}: {lost} of {total} messages on {info.name} are lost")
