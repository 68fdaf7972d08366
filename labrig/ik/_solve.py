"""Inverse kinematics of one model: starts where they are needed, the search, and what it says of the result."""

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.ik._alike import turns_onto_itself
from labrig.ik._descent import FAR_AWAY, NOWHERE, Descent, History, Pose, State
from labrig.ik._evaluate import Evaluator, ShapeModel, evaluator
from labrig.ik._gaps import limits_of
from labrig.ik._poses import lies_near, likeliest, spread_actuations
from labrig.ik._result import IkResult
from labrig.ik._said import INSIDE_OUT, not_fixed, sizes_apart
from labrig.ik._stopwatch import stopwatch
from labrig.surface import Mesh, Target, grid
from labrig.surface._pose import angle_deg

SAMPLES = 27
"""The search looks at SAMPLES x SAMPLES points of the surface."""
ITERATIONS = 40
_MARGIN = 0.01
_FITS, _FITS_ANEW = 0.02, 0.008
"""Misfits, shares of the target's size: above the larger one its own pose is given up, below the smaller one any is
good. Between them other poses are tried too, for a sheet that is upside down, and have to be much better."""
_MUCH_BETTER = 0.5
_OTHER_SHARES = (0.15, 0.85)
_FAR = 0.02
_FREE = 0.35


class Solver:
    """Inverse kinematics of one model; keeps what does not depend on the target.

    `low_kpa`, `high_kpa` (C,) narrow the model's own limits to the rig's; `samples` x `samples` points of the surface
    are compared with the target. Raises `LabrigError` where the limits have nothing in common, or are not C.
    """

    def __init__(
        self,
        model: ShapeModel,
        low_kpa: ArrayLike | None = None,
        high_kpa: ArrayLike | None = None,
        samples: int = SAMPLES,
    ) -> None:
        self.model = model
        for given in (low_kpa, high_kpa):
            if given is not None and np.shape(given) not in ((), np.shape(model.low_kpa)):
                chambers = ", ".join(model.chamber_names)
                raise LabrigError(
                    f"limits of {np.size(given)} chambers are given, the model's are {chambers}"
                )
        self.low = np.maximum(model.low_kpa, -np.inf if low_kpa is None else np.asarray(low_kpa, float))
        self.high = np.minimum(model.high_kpa, np.inf if high_kpa is None else np.asarray(high_kpa, float))
        if (self.low > self.high).any():
            worst = model.chamber_names[int(np.argmax(self.low - self.high))]
            raise LabrigError(f"chamber {worst}: the rig's limits and the model's have nothing in common")
        uv, self.triangles = grid(samples, samples)
        self.uv = _MARGIN + (1.0 - 2.0 * _MARGIN) * uv
        self.half_kpa = 0.5 * (self.low + self.high)
        self.evaluate = _Cached(evaluator(model, self.uv), self.half_kpa)
        self.half_shape = self._shape(self.half_kpa)
        self.descent = Descent(self.evaluate, self.low, self.high, self.half_shape.vertices_mm.mean(axis=0))

    def solve(
        self,
        target: Mesh | Target,
        pose: Pose | None = None,
        start_kpa: ArrayLike | None = None,
        iterations: int = ITERATIONS,
    ) -> IkResult:
        """The best pressures within the limits, and the pose.

        `pose` is where to begin (left out: where the target lies, or from a global search where that is nowhere
        near); `start_kpa` (C,) the pressures to begin with (left out: half of each range). Raises `LabrigError` when
        the target has nothing in common with the surface.
        """
        with stopwatch() as so_far:
            goal = target if isinstance(target, Target) else Target(target)
            _ = goal.mesh.normals, goal.mesh.border
            prepare_s, _ = so_far()
            first = self.half_kpa if start_kpa is None else np.asarray(start_kpa, float)
            first = np.clip(first, self.low, self.high)
            placed = pose is not None or lies_near(self.half_shape, goal)
            try:
                best, history, starts = self._from_poses(goal, first, pose, iterations, placed)
                self._check_enough(best)
            except LabrigError as error:
                size = sizes_apart(goal.size_mm, Target(self.half_shape).size_mm)
                raise LabrigError("; ".join([str(error), *size])) from None
            if start_kpa is None and self._stuck(best, goal):
                for share in _OTHER_SHARES:
                    second = self.low + share * (self.high - self.low)
                    again, more = self.descent.run(
                        goal, second, Pose(best.rotation, best.translation), iterations
                    )
                    starts, history = starts + 1, history + more
                    best = min(best, again, key=lambda state: state.cost)
            others = [] if placed else self._turned(goal, first, best, iterations)
            work_s, compile_s = so_far()
        result = self._result(goal, best, history, starts, work_s - prepare_s, prepare_s)
        notes = (
            *sizes_apart(goal.size_mm, Target(self.half_shape).size_mm),
            *((INSIDE_OUT,) if result.inverted and not goal.mesh.is_cloud else ()),
            *not_fixed(self.model.chamber_names, result.sd_kpa, self.low, self.high),
            *self._other_ways(best, others),
        )
        return replace(result, compile_s=compile_s, notes=(*result.notes, *notes))

    def _check_enough(self, state: State) -> None:
        """Raise `LabrigError` where fewer points have the target opposite than there are numbers to find."""
        unknown, points = 6 + np.count_nonzero(self.high > self.low), round(float(state.usable.sum()))
        if points < unknown:
            raise LabrigError(
                f"the target lies opposite {points} of the surface's {len(state.usable)} points, which is too little "
                f"for {unknown - 6} pressures and its place: is it the right one, and its unit right?"
            )

    def _shape(self, pressure: Floats) -> Mesh:
        return Mesh(np.asarray(self.evaluate(pressure)[0], float), self.triangles)

    def _from_poses(
        self, goal: Target, first: Floats, pose: Pose | None, iterations: int, placed: bool
    ) -> tuple[State, History, int]:
        """The best of the searches from where the target lies, if it is `placed`, or else from the likeliest poses."""
        found: list[tuple[float, State]] = []
        history: History = ()
        passes: tuple[bool, ...] = (False, True)
        if placed:
            state, history = self.descent.run(goal, first, pose or Pose.identity(), iterations)
            misfit = 0.0 if pose is not None else state.misfit(goal, self.triangles)
            if misfit < _FITS_ANEW:
                return state, history, 1
            if misfit < _FITS:
                misfit, passes = _MUCH_BETTER * misfit, (False,)
            found.append((misfit, state))
        starts = len(found)
        for more_shapes in passes:
            tried = spread_actuations(self.low, self.high) if more_shapes else first[None]
            for _, R, t, pressure in likeliest([(p, self._shape(p)) for p in tried], goal, not more_shapes):
                try:
                    state, steps = self.descent.run(goal, pressure, Pose(R.T, -R.T @ t), iterations, FAR_AWAY)
                except LabrigError:
                    continue
                misfit = state.misfit(goal, self.triangles)
                starts, history = starts + 1, history + steps
                if misfit < min([_FITS_ANEW, *(other for other, _ in found)]):
                    return state, history, starts
                found.append((misfit, state))
        if not found:
            raise LabrigError(NOWHERE)
        return min(found, key=lambda entry: entry[0])[1], history, starts

    @cached_property
    def _turns(self) -> list[tuple[Floats, Floats]]:
        """How the surface at half pressure can be turned onto itself."""
        return turns_onto_itself(self.half_shape)

    def _turned(self, goal: Target, first: Floats, best: State, iterations: int) -> list[State]:
        """Other ways in which the target lies on a surface that can be turned onto itself, not much worse."""
        found = []
        for R, t in self._turns:
            pose = Pose(R @ best.rotation, R @ best.translation + t)
            try:
                state, _ = self.descent.run(goal, first, pose, iterations)
            except LabrigError:
                continue
            if _MUCH_BETTER * state.mean_mm() <= best.mean_mm():
                found.append(state)
        return found

    def _other_ways(self, best: State, others: list[State]) -> tuple[str, ...]:
        ways = []
        for other in others:
            turned = angle_deg(other.rotation @ best.rotation.T)
            pressures = zip(self.model.chamber_names, other.pressure, strict=True)
            kpa = ", ".join(f"{name} {value:.1f}" for name, value in pressures)
            ways.append(f"turned by {turned:.0f} deg, {other.mean_mm():.2f} mm on the mean, with {kpa} kPa")
        fits = (
            "the target fits the surface in other ways too, which its place in the rig's frame would decide: "
        )
        return (fits + "; ".join(ways),) if ways else ()

    def _stuck(self, state: State, goal: Target) -> bool:
        """Whether another start could help: much of the target is far off although most chambers are free."""
        far = np.abs(state.plane[state.usable > 0])
        free = (state.pressure > self.low) & (state.pressure < self.high)
        return bool(far.mean() > _FAR * goal.size_mm and free.mean() > _FREE)

    def _result(
        self, goal: Target, state: State, history: History, starts: int, time_s: float, prepare_s: float
    ) -> IkResult:
        from labrig.surface import vertex_normals

        names = self.model.chamber_names
        usable = state.usable > 0
        outwards = vertex_normals(state.points, self.triangles)
        inverted = bool(np.einsum("pi,pi,p->", outwards, state.normal, state.usable) < 0.0)
        signed = np.where(usable, -state.plane if inverted else state.plane, np.nan)
        absolute = np.abs(state.plane[usable])
        H, _ = self.descent.equations(state, state.scale_mm())
        limits = limits_of(state.pressure, self.low, self.high)
        outwards_by = np.einsum("pi,pik->pk", state.normal, state.slope)
        placed = (state.points - state.translation) @ state.rotation
        return IkResult(
            chamber_names=names,
            pressure_kpa=state.pressure,
            rotation=state.rotation,
            translation_mm=state.translation,
            mean_mm=float(absolute.mean()),
            p95_mm=float(np.quantile(absolute, 0.95)),
            max_mm=float(absolute.max()),
            share=float(usable.mean()),
            signed_mm=signed,
            uv=self.uv,
            sd_kpa=_deviations(H, float((absolute**2).mean()), self.high > self.low),
            limited=tuple(np.array(names)[limits.any(axis=0)].tolist()),
            iterations=len(history) - starts,
            starts=starts,
            time_s=time_s,
            prepare_s=prepare_s,
            history=history,
            inverted=inverted,
            gap_facts=(placed, -outwards_by if inverted else outwards_by, limits),
        )


class _Cached:
    """An evaluator that keeps what it gave at the pressures that searches begin with."""

    def __init__(self, evaluate: Evaluator, pressure_kpa: Floats) -> None:
        self._evaluate, self._pressure = evaluate, pressure_kpa
        self._given = evaluate(pressure_kpa)

    def __call__(self, pressure_kpa: Floats) -> tuple[Floats, NDArray[Any]]:
        if np.array_equal(pressure_kpa, self._pressure):
            return self._given
        return self._evaluate(pressure_kpa)

    def points(self, pressure_kpa: Floats) -> NDArray[Any]:
        return self._evaluate.points(pressure_kpa)


def _deviations(H: Floats, variance: float, free: NDArray[np.bool_]) -> Floats:
    """Standard deviations of the pressures, kPa, if distances of neighbouring samples were independent.

    Zero for chambers that are not `free` (C,): nothing else was possible.
    """
    moving = np.concatenate([free, np.ones(len(H) - len(free), bool)])
    inner = H[np.ix_(moving, moving)]
    deviation = np.zeros(len(free))
    try:
        covariance = np.linalg.inv(inner + 1e-12 * np.trace(inner) * np.eye(len(inner)))
    except np.linalg.LinAlgError:
        deviation[free] = np.nan
        return deviation
    deviation[free] = np.sqrt(np.maximum(np.diag(covariance)[: free.sum()], 0.0) * variance)
    return deviation


def solve(
    target: Mesh | Target,
    model: ShapeModel,
    low_kpa: ArrayLike | None = None,
    high_kpa: ArrayLike | None = None,
    pose: Pose | None = None,
) -> IkResult:
    """`Solver(model, low_kpa, high_kpa).solve(target, pose)`: for one target."""
    return Solver(model, low_kpa, high_kpa).solve(target, pose)
