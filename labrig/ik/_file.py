"""Solved targets as a file of plain values."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from labrig._durable import write_whole
from labrig.ik._batch import Solved
from labrig.shape_contents import SolvedTarget, UnsolvedTarget


def write_solved(solved: Sequence[Solved], model: str | Path, path: Path) -> None:
    """Write all results as JSON, in one piece or not at all: pressures in kPa, distances in mm, or what was wrong."""
    content = {"model": str(model), "targets": [_entry(one) for one in solved]}
    write_whole(path, json.dumps(content, indent=1) + "\n")


def _entry(one: Solved) -> SolvedTarget | UnsolvedTarget:
    if one.result is None:
        return {"target": one.job.target, "error": one.error}
    entry: SolvedTarget = {
        "target": one.job.target,
        **one.result.to_dict(),
        "measured_mm": {
            key.removesuffix("_mm"): round(value, 4) if np.isfinite(value) else None
            for key, value in (one.summary or {}).items()
        },
    }
    if one.path is not None:
        entry["path"] = {
            "name": one.path.name,
            "setpoints_kpa": np.round(one.path.setpoints_kpa, 4).tolist(),
            "holds_s": list(one.path.holds_s),
        }
    return entry
