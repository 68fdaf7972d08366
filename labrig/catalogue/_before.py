"""What a rig did shortly before a run: it may remember that, and the run by itself does not know of it."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from labrig._errors import LabrigError
from labrig.catalogue._row import finite, read_row
from labrig.log import read_run_yaml

if TYPE_CHECKING:
    from xarray import Dataset

RECENT_S = 1800.0
"""How long before a run something may be remembered, at most: what creeps is hardly back after half an hour."""
_LONGEST_S = 86_400.0
"""Of a run: those that began a day before and earlier are not read."""


class Before(NamedTuple):
    """A run of the same rig that ended so long before; its folder."""

    folder: Path
    gap_s: float


def used_before(runs: "Sequence[Dataset]") -> Before | None:
    """The last run of the rig that ended within half an hour before the first of some runs, and lies beside it; None
    where there is none, where it is one of them, or where runs were not recorded by labrig on devices: a simulated rig
    begins each run anew.
    """
    recorded = [(Path(run.attrs["run"]), run) for run in runs if "run" in run.attrs]
    began = [(finite(run.attrs.get("start_s")), folder) for folder, run in recorded]
    dated = [(start_s, folder) for start_s, folder in began if start_s is not None]
    if not dated or len(dated) < len(runs):
        return None
    start_s, first = min(dated)
    rig = _rig(read_run_yaml(first))
    given = {folder.resolve() for folder, _ in recorded}
    if not rig:
        return None
    near: list[Before] = []
    for folder in _beside(first):
        own = read_run_yaml(folder)
        at_s = finite(own.get("start_s"))
        if _rig(own) == rig and at_s is not None and 0 < start_s - at_s < _LONGEST_S:
            gap_s = start_s - at_s - _length_s(folder)
            if gap_s < RECENT_S:
                near.append(Before(folder, max(gap_s, 0.0)))
    last = min(near, key=lambda before: before.gap_s, default=None)
    return None if last is None or last.folder.resolve() in given else last


def _beside(folder: Path) -> list[Path]:
    """The other folders with a run beside this one."""
    try:
        return [path.parent for path in sorted(folder.resolve().parent.glob("*/run.yaml"))]
    except OSError:
        return []


def _rig(facts: dict[str, Any]) -> str:
    """The name of a rig that is not simulated; empty where it is, or nobody knows."""
    rig = facts.get("rig")
    pressure = rig.get("pressure") if isinstance(rig, dict) else None
    if not isinstance(rig, dict) or (isinstance(pressure, dict) and pressure.get("kind") == "simulated"):
        return ""
    return str(rig.get("name", ""))


def _length_s(folder: Path) -> float:
    """How long a run took, s; 0 where its log can't be read."""
    try:
        return read_row(folder, folder.name).length_s or 0.0
    except (LabrigError, OSError):
        return 0.0
