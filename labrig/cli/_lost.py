"""What is said of the markers that a run lost."""

from pathlib import Path

from labrig._errors import LabrigError
from labrig._lost_markers import lost_markers
from labrig.log import open_run


def markers_lost(folder: Path) -> list[str]:
    """A line on each marker that a run lost; none for a run that cannot be opened."""
    try:
        return lost_markers(open_run(folder))
    except LabrigError:
        return []
