"""How to get there: the path of set-points after which a surface that remembers has the shape that is wanted."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from labrig.arrays import Floats
from labrig.ik._after import after
from labrig.ik._descent import Pose
from labrig.ik._memory import Approach, Remembering, marker_uv
from labrig.ik._result import IkResult
from labrig.ik._solve import Solver
from labrig.surface import Mesh, Target

SETTLE_S = 3.0
DWELLS_S = (SETTLE_S, 10.0, 30.0)
OVERSHOOTS = (0.0, 0.15, 0.4)
"""How far above the set-point, as a share of the range, a chamber goes first; 0: it comes from below."""
_ROUNDS = 15
_CLOSE_KPA = 0.01
_WORTH_MM = 0.02
"""A longer path has to be better by this."""


@dataclass(frozen=True)
class Plan:
    """A path, and what the model expects at its end.

    Pressures that count, (C,), kPa; marker displacement (M, 3), mm; `error_mm`, the root-mean-square distance of the
    markers from where they are wanted.
    """

    path: Approach
    effective_kpa: Floats
    displaced_mm: Floats
    error_mm: float

    def shape_of(self, memory: Remembering) -> Any:
        """The surface as the model expects it after the path, to be asked at `effective_kpa`."""
        return memory.displaced(self.displaced_mm)


def paths_to(setpoint: Floats, low: Floats, high: Floats, overshoot: float, dwell_s: float) -> Approach:
    """From vented to a set-point: straight, or by way of one that lies above it by a share of the range."""
    if overshoot == 0.0:
        return Approach("straight", setpoint[None], (dwell_s,))
    above = np.minimum(setpoint + overshoot * (high - low), high)
    return Approach(f"from {100 * overshoot:.0f} % above", np.stack([above, setpoint]), (SETTLE_S, dwell_s))


def _in_words(path: Approach) -> str:
    """A path as a note: how it comes to the last set-point, and how long that is held before the shape is there."""
    *before, last_s = path.holds_s
    if not before:
        return f"path: straight from vented, held {last_s:g} s"
    return f"path: {path.name}, held {sum(before):g} s there, then {last_s:g} s"


def plan_path(
    wanted_kpa: ArrayLike,
    memory: Remembering,
    low_kpa: ArrayLike | None = None,
    high_kpa: ArrayLike | None = None,
    overshoots: tuple[float, ...] = OVERSHOOTS,
    dwells_s: tuple[float, ...] = DWELLS_S,
) -> Plan:
    """The shortest path at whose end the surface looks as it would at `wanted_kpa` (C,) if it remembered nothing.

    For every approach and dwell the last set-point is corrected until what counts after the path is what is wanted, as
    far as the limits allow. Among those that come as close as any, within 0.02 mm, it is the shortest.
    """
    wanted = np.asarray(wanted_kpa, float)
    low = np.asarray(memory.shape.low_kpa if low_kpa is None else low_kpa, float)
    high = np.asarray(memory.shape.high_kpa if high_kpa is None else high_kpa, float)
    slope = np.asarray(memory.shape.jacobian(wanted[None], marker_uv(memory.shape)))[0]
    plans: list[Plan] = []
    for dwell_s in dwells_s:
        for overshoot in overshoots:
            plans.append(_corrected(wanted, memory, slope, low, high, overshoot, dwell_s))
            if plans[-1].error_mm <= _WORTH_MM:  # what is tried after it takes longer
                return plans[-1]
    best = min(plan.error_mm for plan in plans)
    near = [plan for plan in plans if plan.error_mm <= best + _WORTH_MM]
    return min(near, key=lambda plan: (plan.path.duration_s, plan.error_mm))


def _corrected(
    wanted: Floats,
    memory: Remembering,
    slope: Floats,
    low: Floats,
    high: Floats,
    overshoot: float,
    dwell_s: float,
) -> Plan:
    """The best last set-point for one approach, by fixed-point steps that halve where they do not help."""
    setpoint, share = wanted.copy(), 1.0
    best: Plan | None = None
    for _ in range(_ROUNDS):
        path = paths_to(setpoint, low, high, overshoot, dwell_s)
        effective, displaced = memory.after(path)
        moved = slope @ (effective - wanted)
        error = float(np.sqrt((moved**2).sum(axis=-1).mean()))
        if best is None or error < best.error_mm:
            best = Plan(path, effective, displaced, error)
        else:
            share *= 0.5
        step = share * (wanted - best.effective_kpa)
        following = np.clip(best.path.setpoints_kpa[-1] + step, low, high)
        if np.abs(following - setpoint).max() < _CLOSE_KPA:
            break
        setpoint = following
    assert best is not None
    return best


def solve_with_path(
    target: Mesh | Target,
    memory: Remembering,
    low_kpa: ArrayLike | None = None,
    high_kpa: ArrayLike | None = None,
    pose: Pose | None = None,
) -> tuple[IkResult, Plan]:
    """Pressures, pose and path for a target, for a model that remembers.

    The result's pressures are the path's last set-points; its pose, its distances and what stands against it are those
    that the model expects after the path. Displacements of the markers are taken into the surface, and the search is
    done once more with them.
    """
    goal = target if isinstance(target, Target) else Target(target)
    static = Solver(memory.shape, low_kpa, high_kpa)
    result = static.solve(goal, pose)
    plan = plan_path(result.pressure_kpa, memory, static.low, static.high)
    if np.abs(plan.displaced_mm).max() > _WORTH_MM:
        shifted = Solver(plan.shape_of(memory), low_kpa, high_kpa)
        begin = Pose(result.rotation, result.translation_mm)
        result = shifted.solve(goal, begin, result.pressure_kpa)
        plan = plan_path(result.pressure_kpa, memory, static.low, static.high)
    notes = (*result.notes, _in_words(plan.path))
    result = after(
        goal,
        plan.shape_of(memory),
        plan.effective_kpa,
        replace(result, notes=notes),
        plan.path.setpoints_kpa[-1],
        (static.low, static.high),
    )
    return result, plan
