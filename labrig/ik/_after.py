"""What is left between surface and target after a path, where other pressures count than were asked for."""

from dataclasses import replace

import numpy as np

from labrig.arrays import Floats
from labrig.ik._descent import Pose
from labrig.ik._evaluate import ShapeModel
from labrig.ik._gaps import limits_of
from labrig.ik._result import IkResult
from labrig.ik._solve import Solver
from labrig.surface import Target


class Held:
    """A shape model that stays at one set of pressures (C,), kPa, be it beyond the model's own limits."""

    def __init__(self, shape: ShapeModel, pressure_kpa: Floats) -> None:
        self.chamber_names = shape.chamber_names
        self.low_kpa = self.high_kpa = pressure_kpa
        self.points, self.jacobian = shape.points, shape.jacobian


def after(
    goal: Target,
    shape: ShapeModel,
    counts_kpa: Floats,
    search: IkResult,
    setpoint_kpa: Floats,
    limits: tuple[Floats, Floats],
) -> IkResult:
    """A search's result with what a path makes of it: pose, distances and gaps at the pressures that then count.

    `shape`: the surface after the path, to be asked at `counts_kpa` (C,). `setpoint_kpa` (C,), the path's last, are the
    result's pressures; whether they are at one of the `limits`, lowest and highest (C,), kPa, stands in the result.
    """
    pose = Pose(search.rotation, search.translation_mm)
    found = Solver(Held(shape, counts_kpa)).solve(goal, pose, counts_kpa)
    at_limits = limits_of(setpoint_kpa, *limits)
    points, influence, _ = found.gap_facts
    return replace(
        search,
        pressure_kpa=setpoint_kpa,
        rotation=found.rotation,
        translation_mm=found.translation_mm,
        mean_mm=found.mean_mm,
        p95_mm=found.p95_mm,
        max_mm=found.max_mm,
        share=found.share,
        signed_mm=found.signed_mm,
        inverted=found.inverted,
        limited=tuple(np.array(search.chamber_names)[at_limits.any(axis=0)].tolist()),
        gap_facts=(points, influence, at_limits),
    )
