"""Files that the system itself locks for a process: one that was killed leaves no lock behind."""

import errno
import os
import sys
from pathlib import Path
from typing import IO

SOMEBODYS = (errno.EACCES, errno.EAGAIN, errno.EDEADLK)
"""What the system says where another process has the lock; anything else: this disk knows none, or is full."""


def taken(path: Path) -> IO[bytes]:
    """The file, locked until it is closed or this process ends; raises `OSError` where another process has it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    while True:
        file = path.open("ab")
        try:
            _take(file)
            if os.path.samestat(os.fstat(file.fileno()), path.stat()):
                return file
        except FileNotFoundError:
            pass
        except OSError:
            file.close()
            raise
        file.close()  # whoever had it has just removed it


def _take(file: IO[bytes]) -> None:
    if sys.platform == "win32":
        import msvcrt

        file.seek(0)
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # unlike flock's, no child of this process has it
