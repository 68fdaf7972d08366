"""Text files that are packed: gzip, or a zip with one file in it. They are read as they are."""

import gzip
import io
import zipfile
import zlib
from pathlib import Path
from typing import IO, TextIO, cast

from labrig._errors import LabrigError

DAMAGED = (EOFError, zlib.error, zipfile.BadZipFile, gzip.BadGzipFile)
"""What is raised while a packed file is read that was cut off, or is damaged."""
_GZIP, _ZIP = b"\x1f\x8b", b"PK\x03\x04"


def open_bytes(path: Path) -> IO[bytes]:
    """A file for reading, unpacked."""
    with path.open("rb") as file:
        head = file.read(4)
    if head.startswith(_GZIP):
        return cast(IO[bytes], gzip.open(path, "rb"))
    if head == _ZIP and (name := _only_one(path)):
        return zipfile.ZipFile(path).open(name)
    return path.open("rb")


def open_text(path: Path, encoding: str | None, errors: str = "strict") -> TextIO:
    """The same as text; ends of lines are those of this computer or of any other."""
    return io.TextIOWrapper(open_bytes(path), encoding=encoding or "utf-8", errors=errors, newline=None)


def is_packed(path: Path) -> bool:
    """Whether a file is packed. Raises `LabrigError` for a zip that has several files and is no workbook."""
    with path.open("rb") as file:
        head = file.read(4)
    return head.startswith(_GZIP) or (head == _ZIP and bool(_only_one(path)))


def _only_one(path: Path) -> str:
    """The only file in a zip; empty for workbooks and arrays, which are zips too, and one that was cut off."""
    if not zipfile.is_zipfile(path):
        return ""
    with zipfile.ZipFile(path) as archive:
        names = [n for n in archive.namelist() if not n.endswith("/") and not n.startswith("__MACOSX/")]
    if any(n.endswith(".npy") or n in {"[Content_Types].xml", "mimetype"} for n in names):
        return ""
    if len(names) != 1:
        raise LabrigError(f"{path}: has {len(names)} files in it; unpack it, and name the tables")
    return names[0]
