"""Files that survive a power cut: their content is asked for with `os.fsync`, their names with `sync_folder`."""

import os
from pathlib import Path


def sync_folder(folder: Path) -> None:
    """Make the names in a folder durable. POSIX only: Windows has no way to ask for it, and no need."""
    if os.name != "posix":
        return
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)
