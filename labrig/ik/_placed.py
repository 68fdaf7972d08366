"""A solved target of ik.json beside the model's surface again, without another search: for a picture of both."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.ik._batch import MEASURED, Job, measured, solver_of, target_of
from labrig.ik._memory import Approach
from labrig.shape_contents import SolvedTarget
from labrig.surface import Mesh, grid


@dataclass(frozen=True)
class Placed:
    """A target, and in its frame the surface that the model expects at the pressures that were found.

    `surface_mm` (P, 3) with `triangles` (T, 3); `signed_mm` (P,) distances, positive where the surface stands out of
    the target, NaN where nothing is opposite.
    """

    target: Mesh
    surface_mm: Floats
    triangles: Ints
    signed_mm: Floats


def placed(entry: SolvedTarget, model: str | Path, folder: Path) -> Placed:
    """What an entry of ik.json stands for; its target is looked for from `folder`, in which the command was typed.

    Raises `LabrigError` where the model or the target cannot be read any more.
    """
    names = list(entry["limits_kpa"])
    low, high = (tuple(entry["limits_kpa"][name][k] for name in names) for k in (0, 1))
    job = Job(str(folder / entry["target"]), str(model), entry["unit"], low, high)
    solver, memory = solver_of(job)
    goal, shape = target_of(job), solver.model
    counts = np.array([entry["pressure_kpa"][name] for name in shape.chamber_names])
    if memory is not None and (path := entry.get("path")) is not None:
        counts, displaced = memory.after(
            Approach(path["name"], np.array(path["setpoints_kpa"]), tuple(path["holds_s"]))
        )
        shape = memory.displaced(displaced)
    uv, triangles = grid(MEASURED, MEASURED)
    points = np.asarray(shape.points(counts[None], uv), float)[0]
    surface = (points - np.array(entry["translation_mm"])) @ np.array(entry["rotation"])
    signed, _ = measured(goal, surface, entry["inverted"])
    return Placed(goal.mesh, surface, triangles, signed)
