"""The raw bytes of a session in a file, and links that write one as they are used.

The file is text: a header line of JSON, then one line per piece, ``seconds < hex`` for what the device
sent and ``seconds > hex`` for what was sent to it. Lines are written whole, so a file that was cut short
loses at most its last line.
"""

import json
import math
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from labrig_drivers._transport import Link

FORMAT = "labrig wire recording 1"
MAX_LINE_CHARACTERS = 4 << 20


class RecordingError(ValueError):
    """A file that is no recording; the message names it and the line."""


@dataclass(frozen=True)
class Piece:
    """Bytes that passed at `time_s` (s since the start); `sent` is True for host to device."""

    time_s: float
    sent: bool
    data: bytes


class Recorder:
    """Writes one recording; `FileExistsError` rather than overwriting one. Safe to use from threads."""

    def __init__(self, path: Path, kind: str, device: str) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file: TextIO | None = path.open("x", encoding="ascii", newline="\n")
        self._lock = threading.Lock()
        self._start = time.monotonic()
        header = {"format": FORMAT, "kind": kind, "device": device, "started_s": time.time()}
        self._file.write(json.dumps(header, ensure_ascii=True) + "\n")
        self._file.flush()

    def piece(self, sent: bool, data: bytes) -> None:
        """Add bytes that passed just now; does nothing once closed."""
        with self._lock:
            if self._file is not None and data:
                elapsed_s = time.monotonic() - self._start
                self._file.write(f"{elapsed_s:.6f} {'>' if sent else '<'} {data.hex()}\n")
                self._file.flush()

    def close(self) -> None:
        """Finish the file."""
        with self._lock:
            if self._file is not None:
                self._file.close()
                self._file = None


class RecordedLink:
    """A link that writes down what passes through it."""

    def __init__(self, link: Link, recorder: Recorder) -> None:
        self._link = link
        self._recorder = recorder

    def read(self, timeout_s: float) -> bytes:
        """As the link does."""
        data = self._link.read(timeout_s)
        self._recorder.piece(False, data)
        return data

    def write(self, data: bytes) -> None:
        """As the link does."""
        self._recorder.piece(True, data)
        self._link.write(data)

    def close(self) -> None:
        """Close the link; the recording goes on with the next one."""
        self._link.close()


def read_header(path: Path) -> dict[str, str]:
    """The header of a recording (`kind`, `device`); `RecordingError` when the file has none."""
    try:
        with path.open(encoding="ascii", errors="replace") as file:
            header = json.loads(file.readline(MAX_LINE_CHARACTERS))
    except (OSError, ValueError) as error:
        raise RecordingError(f"{path}: not a recording ({error})") from None
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise RecordingError(f"{path}: not a recording (its first line is not a {FORMAT!r} header)")
    return {key: str(value) for key, value in header.items()}


def read_pieces(path: Path) -> Iterator[Piece]:
    """The pieces of a recording in order; a last line that was cut off is left out."""
    read_header(path)
    with path.open(encoding="ascii", errors="replace") as file:
        file.readline(MAX_LINE_CHARACTERS)
        number = 1
        while line := file.readline(MAX_LINE_CHARACTERS):
            number += 1
            if not line.endswith("\n"):
                if len(line) >= MAX_LINE_CHARACTERS:
                    raise RecordingError(f"{path}: line {number} is longer than {MAX_LINE_CHARACTERS}")
                return
            yield parse_piece(line, path, number)


def parse_piece(line: str, path: Path, number: int) -> Piece:
    """One line of a recording; `RecordingError` names the file and the line's number."""
    try:
        time_text, arrow, data_text = line.split()
        time_s, data = float(time_text), bytes.fromhex(data_text)
        if arrow not in ("<", ">") or not 0 <= time_s < math.inf:
            raise ValueError
    except ValueError:
        raise RecordingError(f"{path}: line {number} is not 'seconds < hex' or 'seconds > hex'") from None
    return Piece(time_s, arrow == ">", data)
