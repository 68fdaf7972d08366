"""Opens a run as an xarray Dataset."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig._paths import path_of
from labrig.arrays import Floats
from labrig.log._dataset import CampaignArrays, to_dataset
from labrig.log._find import run_id
from labrig.log._notes import ruled_out_in
from labrig.log._rig_dataset import rig_arrays
from labrig.log._runs import state_of
from labrig.log._segments import LoadedSegment, load_segments, sessions
from labrig.log._table import table_arrays

if TYPE_CHECKING:
    import xarray as xr


def open_run(path: str | Path) -> xr.Dataset:
    """The campaign in a run folder or an .mcap file, as docs/reference/dataset.md describes it.

    Damaged files are read as far as they are whole; `attrs["warnings"]` is a list of what was lost, of what a run that
    was stopped did not measure, and of what its import remarked; empty when nothing was. Raises `LabrigError` when
    there is nothing to read.

    Example:
        >>> run = labrig.open_run("runs/first")
        >>> run.sizes["capture"]
        40
        >>> run["commanded"].dims, run["commanded"].attrs["units"]
        (('capture', 'chamber'), 'kPa')
    """
    path = path_of(path, "a run", "a run folder's path, or an .mcap file's")
    segments, warnings = load_segments(path)
    layout, arrays = segments[0].layout, _arrays(segments)
    warnings = [*warnings, *_not_complete(path, segments, len(arrays.commanded))]
    remarks = list(layout.attributes.get("import_remarks", ()))
    attributes = {"run": str(path), "run_id": run_id(path), "warnings": warnings + remarks}
    if layout.table:
        attributes["assumed"] = list(layout.attributes.get("assumed", ()))
    if procedure := segments[0].run.get("procedure"):
        attributes["procedure"] = procedure
    return to_dataset(replace(arrays, ruled_out=ruled_out_in(Path(path), arrays.session)), layout, attributes)


def _not_complete(path: Path, segments: list[LoadedSegment], captures: int) -> list[str]:
    """A line where a run ended before it had all of its captures: how many, why, and how it goes on."""
    run, state = segments[0].run, state_of(segments[-1])
    planned = 0 if segments[0].layout.table or run.get("closed_loop") else run.get("captures")
    if state == "completed" or not isinstance(planned, int) or captures >= planned:
        return []
    folder = path if path.is_dir() else path.parent
    how = goes_on(folder, run)
    why = state if " " in state else f"stopped by {state}"
    return [f"{captures} of {planned} captures: {why}; {how} goes on"]


def goes_on(folder: Path, run: Mapping[str, Any]) -> str:
    """What goes on with a run, by what its run.yaml says: the command that began it, or the call in Python."""
    by_command = "source" in run and "rig_file" in run
    return f"labrig run --resume {folder}" if by_command else f"labrig.run(..., out='{folder}', resume=True)"


def marker_places(path: str | Path) -> tuple[tuple[str, ...], Floats]:
    """The names of a run's markers, (M,), and their places as `open_run` gives them, (n, T, M, 3) mm, without what it
    takes to make a Dataset of them; none of a run without markers. Raises `LabrigError` as `open_run` does.
    """
    segments, _ = load_segments(Path(path))
    position = _arrays(segments).position_mm
    return ((), np.empty((0, 0, 0, 3))) if position is None else (segments[0].layout.markers, position)


def _arrays(segments: list[LoadedSegment]) -> CampaignArrays:
    return table_arrays(segments[0]) if segments[0].layout.table else rig_arrays(sessions(segments))
