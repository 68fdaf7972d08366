"""solve_ik: the pressures that make a surface take given shapes."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError
from labrig._paths import paths_of
from labrig.api._as_file import as_file
from labrig.api._inputs import AnyPath, rig_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from labrig._executor import Executor
    from labrig.api._as_file import ShapeModelGiven
    from labrig.ik import Solved

    Floats = NDArray[np.float64]


def solve_ik(
    targets: Any,
    model: "ShapeModelGiven",
    *,
    rig: Any = None,
    unit: str | None = None,
    executor: "Executor | None" = None,
    progress: Callable[[int], None] | None = None,
) -> "list[Solved]":
    """Inverse kinematics of target surfaces, in order.

    Args:
        targets: one file or several (OBJ, PLY, STL, or points in XYZ).
        model: of the shell, learnt, or corrected: its file, what `labrig.Model.load` gives, or what `train_forward` or
            `train_sim2real` has just given.
        rig: a rig.yaml's path, or what `labrig.load_rig` gives: its limits hold; by default the model's own.
        unit: of the targets, where their files do not say.
        executor: workers for many targets; they stay open.
        progress: told how many are done.

    Returns:
        for each target its `result` (pressures in kPa, pose), the surface in mm, signed distances in mm and their
        summary; or its `error`, where it could not be solved.

    Raises:
        LabrigError: a target does not exist, the model cannot be used, or the rig's chambers are not the model's.

    Example:
        >>> solved = labrig.solve_ik("body.ply", "forward.pt", rig="rig.yaml")[0]
        >>> solved.result.chamber_names
        ('c1', 'c2', 'c3', 'c4')
        >>> solved.summary["mean_mm"] < 0.5
        True
    """
    from labrig.ik import solve_files

    files = targets_of(targets)
    with as_file(model) as path:
        limits = limits_kpa(rig, path) if rig is not None else None
        return solve_files(files, path, unit, limits, executor, progress)


def targets_of(given: Any) -> list[Path]:
    """The files of target surfaces; raises `LabrigError` for anything else."""
    return paths_of(given, "a target", "a surface's file (OBJ, PLY, STL, XYZ), or a list of them")


def limits_kpa(rig: Any, model: AnyPath) -> "tuple[Floats, Floats]":
    """A rig's limits in the order of the model's chambers, kPa, (C,) each; raises `LabrigError` for other chambers."""
    import numpy as np

    from labrig.ik import load_shape_model

    shape, _ = load_shape_model(model)
    config = rig_of(rig)
    channels = {channel.name: channel for channel in config.channels}
    missing = [name for name in shape.chamber_names if name not in channels]
    if missing or len(channels) != len(shape.chamber_names):
        where = rig if isinstance(rig, str | Path) else f"rig {config.name}"
        raise LabrigError(
            f"{where}: its chambers ({', '.join(channels)}) are not the model's ({', '.join(shape.chamber_names)})"
        )
    chosen = [channels[name] for name in shape.chamber_names]
    return np.array([c.min_kpa for c in chosen]), np.array([c.max_kpa for c in chosen])
