"""Still pictures: written whole or not at all."""

from pathlib import Path
from typing import TYPE_CHECKING

from labrig._durable import aside, put_at

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def save_still(figure: "Figure", path: Path) -> Path:
    """Write a picture beside its place and move it there; returns the path. Nobody sees half of it."""
    with aside(path) as partial:
        figure.savefig(partial, format=path.suffix[1:])
        put_at(partial, path)
    return path
