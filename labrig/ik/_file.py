"""Solved targets as a file of plain values."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from labrig._json import EXACT, write_json
from labrig.ik._batch import Solved
from labrig.shape_contents import SolvedContent, SolvedTarget, UnsolvedTarget


def write_solved(solved: Sequence[Solved], model: str | Path, path: Path) -> None:
    """Write all results as JSON, in one piece or not at all: pressures in kPa, distances in mm, or what was wrong."""
    content: SolvedContent = {"model": str(model), "targets": [_entry(one) for one in solved]}
    write_json(content, path, EXACT)


def _entry(one: Solved) -> SolvedTarget | UnsolvedTarget:
    if one.result is None:
        return {"target": one.job.target, "error": one.error}
    low, high = one.limits_kpa if one.limits_kpa is not None else (np.zeros(0), np.zeros(0))
    limits = np.round([low, high], 4).T.tolist()
    entry: SolvedTarget = {
        "target": one.job.target,
        "unit": one.job.unit,
        "limits_kpa": dict(zip(one.result.chamber_names, limits, strict=False)),
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
