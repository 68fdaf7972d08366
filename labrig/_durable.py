"""Files that are whole or not there, also after a power cut.

Their content is made durable with `os.fsync`, their names with `sync_folder`.
"""

import os
import secrets
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_WINDOWS = os.name == "nt"
_BUSY_S = 2.0
"""For how long a name that somebody reads is asked for again."""


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """What the system says while a file is written names that file: of a full disk it names none by itself."""
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error


@contextmanager
def aside(path: Path) -> Iterator[Path]:
    """A name beside `path` that nobody else has, to write a file under before it gets its own; nothing is left of it.

    Another thread, process or computer may be writing the same file.
    """
    partial = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        yield partial
    finally:
        partial.unlink(missing_ok=True)


def put_at(partial: Path, path: Path) -> None:
    """Give a file the name `path`, in place of the one that has it.

    Windows refuses that while somebody reads the other, such as a page or a virus scanner: it is asked again for two
    seconds.
    """
    until = time.monotonic() + _BUSY_S
    while True:
        try:
            partial.replace(path)
        except PermissionError:
            if not _WINDOWS or time.monotonic() >= until:
                raise
            time.sleep(_BUSY_S / 40)
        else:
            return


def write_whole(path: Path, text: str) -> None:
    """Write a text file durably, in one piece or not at all; an `OSError` names it, and nothing of it is left.

    After a power cut there is the file of before or the new one, never an empty one with its name.
    """
    with _written(path, text) as partial:
        put_at(partial, path)


def write_new(path: Path, text: str) -> None:
    """As `write_whole`, and never over a file that is there, whoever made it meanwhile: `FileExistsError`."""
    with _written(path, text) as partial:
        if os.name == "nt":
            partial.rename(path)  # which never replaces a file there
            return
        try:
            path.hardlink_to(partial)
        except FileExistsError:
            raise
        except OSError:  # a stick, or a share, that knows no links
            with path.open("x"):
                pass  # the name is taken
            try:
                put_at(partial, path)
            except BaseException:
                path.unlink(missing_ok=True)
                raise


@contextmanager
def _written(path: Path, text: str) -> Iterator[Path]:
    """The text in a file aside, durable; what is made of it is durable at the end."""
    with naming(path), aside(path) as partial:
        with partial.open("x", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        yield partial
        sync_folder(path.parent)


@contextmanager
def in_place_of(path: Path) -> Iterator[None]:
    """A file that lies at `path` waits beside it, as .NAME.before, until another is whole; where that fails, it comes
    back, and nothing is left of the other.
    """
    before = path.with_name(f".{path.name}.before")
    there = path.exists()
    if there:
        put_at(path, before)
    try:
        yield
    except BaseException:
        path.unlink(missing_ok=True)
        if there:
            put_at(before, path)
        raise
    if there:
        before.unlink(missing_ok=True)


def sync_folder(folder: Path) -> None:
    """Make the names in a folder durable. POSIX only: Windows has no way to ask for it, and no need."""
    if os.name != "posix":
        return
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)
