"""What is going to be realised: each target with each form of the model, as pressures, path and predicted surface."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from labrig._errors import LabrigError
from labrig._ranges import rounded
from labrig.arrays import Floats
from labrig.ik._after import after
from labrig.ik._batch import MEASURED, Job, Solved, solve_job, solver_of, target_of
from labrig.ik._load import load_shape_model
from labrig.ik._memory import Approach
from labrig.ik._refine import Refinement
from labrig.surface import Mesh, Registration, Target, distances, grid, read_mesh, register

SETTLE_S = 3.0
_FOREIGN = 0.1
"""Distance from the predicted surface, as a share of the target's size, beyond which something else was scanned."""
WHOLE = "the whole model"
_WORDS = {"": WHOLE, "warp": "without the warp", "effects": "without the effects"}


@dataclass(frozen=True)
class Trial:
    """One target realised by one form of the model; `number` counts from 0, `solved` is what is asked of the rig.

    Pressures of `solved`, `approach` and `along` are in the model's order; `order` (C,) are the places of the rig's
    chambers in it.
    """

    number: int
    solved: Solved
    target: Target
    order: tuple[int, ...]

    @property
    def name(self) -> str:
        """The target's name."""
        return Path(self.solved.job.target).name

    @property
    def form(self) -> str:
        """Which form of the model, in words."""
        return _WORDS[self.solved.job.without]

    @property
    def approach(self) -> Approach:
        """The set-points, rounded as they are commanded; straight from vented unless the model remembers."""
        result = self.solved.result
        assert result is not None
        path = self.solved.path or Approach("straight", result.pressure_kpa[None], (SETTLE_S,))
        job = self.solved.job
        low = np.asarray(-np.inf if job.low_kpa is None else job.low_kpa)
        high = np.asarray(np.inf if job.high_kpa is None else job.high_kpa)
        return Approach(path.name, rounded(low, high, path.setpoints_kpa), path.holds_s)

    def for_rig(self, approach: Approach) -> Approach:
        """A path of the model's chambers with its columns as the rig lists them."""
        return replace(approach, setpoints_kpa=approach.setpoints_kpa[:, list(self.order)])

    def of_rig(self, pressure_kpa: Floats) -> Floats:
        """Pressures (..., C) of the rig's chambers in the model's order."""
        return pressure_kpa[..., np.argsort(self.order)]

    def along(self, approach: Approach) -> "Trial":
        """The same target by another path, such as the one that a run's log holds: what the model expects of that."""
        same = self.approach.setpoints_kpa.shape == approach.setpoints_kpa.shape
        if same and np.array_equal(self.approach.setpoints_kpa, approach.setpoints_kpa):
            return self
        solver, memory = solver_of(self.solved.job)
        before = self.solved.result
        assert before is not None
        end = approach.setpoints_kpa[-1]
        shape, counts = solver.model, end
        if memory is not None:
            counts, displaced = memory.after(approach)
            shape = memory.displaced(displaced)
        found = after(self.target, shape, counts, before, end, (solver.low, solver.high))
        uv, triangles = grid(MEASURED, MEASURED)
        surface = found.to_target(np.asarray(shape.points(counts[None], uv), float)[0])
        solved = replace(self.solved, result=found, surface_mm=surface, triangles=triangles, path=approach)
        return replace(self, solved=solved)

    @cached_property
    def predicted(self) -> Mesh:
        """The surface that the model expects, in the target's frame."""
        assert self.solved.surface_mm is not None
        assert self.solved.triangles is not None
        return Mesh(self.solved.surface_mm, self.solved.triangles)

    def heights(self, surface: Mesh) -> Floats:
        """How far a surface stands out of the target at each of the target's vertices, mm, (V,); NaN: not opposite."""
        found = distances(self.target.mesh.vertices_mm, surface)
        return np.where(found.beyond | self.target.mesh.border, np.nan, -found.signed_mm)

    def read_scan(self, path: str | Path, unit: str = "mm") -> Mesh:
        """A scan of the realised surface, in mm, cleaned, and cut off what it stands on; `unit` is its file's."""
        return read_mesh(path, unit, Target(self.predicted).size_mm)

    def placed(self, scan: Mesh) -> tuple[Mesh, Registration]:
        """A scan in the target's frame, and its registration.

        A global start finds the predicted surface, which the scan looks like all over; ICP then ends on the target. A
        scan that is inside out is turned; what lies far from the predicted surface, such as a hand, is left out.
        """
        rough = register(scan, self.predicted)
        fine = register(scan, self.target, (rough.rotation, rough.translation_mm))
        lying = scan.turned() if rough.turned else scan
        off = np.abs(distances(rough.apply(scan.vertices_mm), self.predicted).signed_mm)
        foreign = off > _FOREIGN * self.target.size_mm
        if foreign.any():
            lying = lying.without(foreign)
        return lying.moved(fine.rotation, fine.translation_mm), fine

    def refinement(self, low: Floats, high: Floats) -> Refinement:
        """Broyden's method for this target, with the model's derivatives at the predicted surface.

        Its pressures, and the limits `low`, `high` (C,), kPa, are in the rig's order.
        """
        result, job = self.solved.result, self.solved.job
        assert result is not None
        solver, _ = solver_of(job)
        uv, _ = grid(MEASURED, MEASURED)
        index, _ = Target(self.predicted).nearest.one(self.target.mesh.vertices_mm)
        slope = np.asarray(solver.model.jacobian(result.pressure_kpa[None], uv[index]), float)[0]
        slope = slope[..., list(self.order)]
        normal = self.target.mesh.normals * (-1.0 if result.inverted else 1.0)  # heights count outwards
        turned = np.einsum("vd,ed->ve", normal, result.rotation)  # the normals in the rig's frame
        middle = self.target.mesh.vertices_mm.mean(axis=0)
        motions = np.concatenate([np.cross(self.target.mesh.vertices_mm - middle, normal), normal], axis=1)
        return Refinement(np.einsum("ve,vec->vc", turned, slope), motions, low, high)


def make_trials(
    targets: Sequence[str],
    model: str,
    unit: str | None,
    without: Sequence[str],
    chambers: tuple[str, ...],
    low_kpa: Floats,
    high_kpa: Floats,
) -> list[Trial]:
    """Every target with the whole model and without what is named in `without` (warp, effects), in order.

    `chambers` and the limits (C,) are the rig's; chambers are matched by name, in whatever order it lists them.
    Raises `LabrigError` for a model of another rig, a form that it does not have, or a target of no use.
    """
    trials: list[Trial] = []
    known = load_shape_model(model)[0].chamber_names
    if sorted(known) != sorted(chambers):
        raise LabrigError(
            f"{model}: its chambers ({', '.join(known)}) are not the rig's ({', '.join(chambers)})"
        )
    own = [chambers.index(name) for name in known]
    order = tuple(known.index(name) for name in chambers)
    low, high = tuple(low_kpa[own].tolist()), tuple(high_kpa[own].tolist())
    for target in targets:
        for left_out in ("", *without):
            job = Job(str(target), str(model), unit or None, low, high, left_out)
            solved = solve_job(job)
            if solved.error:
                raise LabrigError(solved.error)
            trials.append(Trial(len(trials), solved, target_of(job), order))
    return trials
