"""Still pictures: written whole or not at all."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def save_still(figure: "Figure", path: Path) -> Path:
    """Write a picture beside its place and move it there; returns the path. Nobody sees half of it."""
    temporary = path.with_name(f".{os.getpid()}-{path.name}")
    try:
        figure.savefig(temporary)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    return path
