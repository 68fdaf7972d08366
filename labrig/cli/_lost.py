"""What is said of the markers that a run lost."""

from pathlib import Path

from labrig._errors import LabrigError
from labrig._lost_markers import lost_of
from labrig.log import marker_places


def markers_lost(folder: Path) -> list[str]:
    """A line on each marker that a run lost; none for a run that cannot be opened."""
    try:
        return lost_of(*marker_places(folder))
    except LabrigError:
        return []
