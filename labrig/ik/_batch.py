"""Many targets: each read, solved and measured by itself, here, in processes or on a cluster."""

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig._executor import Executor
from labrig._paths import check_there
from labrig.arrays import Floats
from labrig.ik._load import load_shape_model, state_of
from labrig.ik._memory import Approach, Remembering
from labrig.ik._path import solve_with_path
from labrig.ik._result import IkResult
from labrig.ik._solve import Solver
from labrig.surface import Target, distances, grid, read_mesh

MEASURED = 61
"""Results are measured on MEASURED x MEASURED points of the surface, exactly, to the target's triangles."""


@dataclass(frozen=True)
class Job:
    """One target, by file; `without` leaves the model's "warp" or its "effects" out."""

    target: str
    model: str
    unit: str | None = None
    low_kpa: tuple[float, ...] | None = None
    high_kpa: tuple[float, ...] | None = None
    without: str = ""


@dataclass(frozen=True)
class Solved:
    """One target's result, or the `error` where there is none.

    `result` is the search's; `surface_mm` (P, 3) the surface in the target's frame; `signed_mm` (P,) signed distances
    at a grid of (u, v), NaN where nothing is opposite; `summary` theirs; `path` the way there, if the model remembers;
    `limits_kpa` the lowest and the highest pressures, (C,) each, that were searched between.
    """

    job: Job
    result: IkResult | None = None
    surface_mm: Floats | None = None
    triangles: NDArray[np.int64] | None = None
    signed_mm: Floats | None = None
    summary: dict[str, float] | None = None
    path: Approach | None = None
    limits_kpa: tuple[Floats, Floats] | None = None
    error: str = ""

    def __repr__(self) -> str:
        return f"Solved {Path(self.job.target).name}: {self.error or repr(self.result)}"


def solve_job(job: Job) -> Solved:
    """Read, solve and measure one target; what is wrong with it becomes the result's `error`."""
    try:
        return _solve_job(job)
    except LabrigError as error:
        return Solved(job, error=str(error))


def _solve_job(job: Job) -> Solved:
    solver, memory = solver_of(job)
    goal = target_of(job)
    if memory is None:
        result, path = solver.solve(goal), None
        shape, pressure = solver.model, result.pressure_kpa
    else:
        result, plan = solve_with_path(goal, memory, job.low_kpa, job.high_kpa)
        path, shape, pressure = plan.path, plan.shape_of(memory), plan.effective_kpa
    result = replace(result, notes=(*goal.mesh.notes, *result.notes))
    uv, triangles = grid(MEASURED, MEASURED)
    surface = result.to_target(np.asarray(shape.points(pressure[None], uv), float)[0])
    signed, summary = measured(goal, surface, result.inverted)
    return Solved(job, result, surface, triangles, signed, summary, path, (solver.low, solver.high))


def measured(goal: Target, surface_mm: Floats, inverted: bool) -> tuple[Floats, dict[str, float]]:
    """Signed distances of a surface (P, 3), mm, in the target's frame: (P,), NaN where nothing is opposite; and theirs
    in short. `inverted` where the target's triangles face inwards.
    """
    found = distances(surface_mm, goal.mesh, goal.nearest)
    if inverted:
        found = replace(found, signed_mm=-found.signed_mm)
    return np.where(found.beyond, np.nan, found.signed_mm), found.summary()


def target_of(job: Job) -> Target:
    """The job's target, read and cleaned; the size of the model's surface tells the unit where the file does not."""
    solver, _ = solver_of(job)
    return Target(read_mesh(job.target, job.unit, Target(solver.half_shape).size_mm))


def solver_of(job: Job) -> tuple[Solver, Remembering | None]:
    """The search that a job asks for; the last few are kept. Raises `LabrigError` for a model without that form."""
    return _solver(job.model, state_of(job.model), job.low_kpa, job.high_kpa, job.without)


@lru_cache(maxsize=4)
def _solver(
    model: str,
    _state: tuple[tuple[str, int, int], ...],
    low: tuple[float, ...] | None,
    high: tuple[float, ...] | None,
    without: str,
) -> tuple[Solver, Remembering | None]:
    shape, memory = load_shape_model(model)
    if without == "effects":
        if memory is None:
            raise LabrigError(f"{model}: has no effects that could be left out")
        memory = None
    if without == "warp":
        if not hasattr(shape, "forward"):
            raise LabrigError(f"{model}: has no warp that could be left out")
        shape = shape.forward  # type: ignore[attr-defined]
        memory = Remembering(memory.model, shape) if memory is not None else None
    return Solver(shape, low, high), memory


def solve_files(
    targets: Sequence[str | Path],
    model: str | Path,
    unit: str | None = None,
    limits_kpa: tuple[Floats, Floats] | None = None,
    executor: Executor | None = None,
    progress: Callable[[int], None] | None = None,
) -> list[Solved]:
    """Inverse kinematics of every file, in order; `progress` is told how many are done.

    An `executor` that is handed in stays open: its workers, once started, are there for the next files.
    Raises `LabrigError` for a model that cannot be used, and for a target that is not there; what else is wrong with a
    target stands in its own result.
    """
    load_shape_model(model)
    check_there(targets)
    low, high = (tuple(x.tolist()) for x in limits_kpa) if limits_kpa is not None else (None, None)
    jobs = [Job(str(target), str(model), unit, low, high) for target in targets]
    done: list[Solved | None] = [None] * len(jobs)
    with nullcontext(executor) if executor is not None else Executor(1) as work:
        for count, (number, solved) in enumerate(work.map(solve_job, jobs), 1):
            done[number] = solved
            if progress is not None:
                progress(count)
    return [solved for solved in done if solved is not None]
