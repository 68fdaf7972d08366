"""A file that is locked for as long as the process lives that holds it: how others know that it still does."""

import sys
from pathlib import Path
from typing import IO

if sys.platform == "win32":
    import msvcrt

    def _lock(file: IO[bytes], shared: bool = False) -> None:  # Windows has no shared one
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _lock(file: IO[bytes], shared: bool = False) -> None:
        fcntl.flock(file, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)


def hold(path: Path) -> IO[bytes]:
    """Lock a file until what is given back is closed or the process ends; `OSError` if another holds it."""
    file = path.open("ab")
    try:
        _lock(file)
    except OSError:
        file.close()
        raise
    return file


def is_held(path: Path) -> bool:
    """Whether a process holds the file."""
    try:
        with path.open("rb+") as file:
            _lock(file, shared=True)  # two that look at once do not take each other for the holder
    except FileNotFoundError:
        return False
    except OSError:
        return True
    return False
