"""One search from one start: pressures and pose together, by damped Gauss-Newton on point-to-plane distances."""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.ik._evaluate import Evaluator
from labrig.surface import Target
from labrig.surface._pose import rotation_of

Floats = NDArray[np.float64]
History = tuple[tuple[float, float], ...]
"""(time since the search began, s; mean distance, mm) at the start and after every step."""

NOWHERE = "the target lies nowhere opposite the surface: is it the right one, and its unit right?"

_FIRST_DAMPING = 1e-3
_LEAST_DAMPING = 1e-7
_TRIES = 4
_PATIENCE, _PROGRESS = 2, 0.003
"""So many steps in a row that do not bring the mean distance down by this share end the search."""
_FAR = 0.08
"""Share of the target's size from which on a distance does not count for more."""
_STILL, _HARDLY = 1e-3, 1e-2
"""A step that promises, or gives, less than this share of the cost is the last; so is one that failed and promised

little more.
"""


@dataclass(frozen=True)
class Pose:
    """Target to rig: x -> rotation @ x + translation_mm."""

    rotation: Floats
    translation_mm: Floats

    @classmethod
    def identity(cls) -> "Pose":
        """The target lies where the rig's frame has it."""
        return cls(np.eye(3), np.zeros(3))


@dataclass(frozen=True)
class Rough:
    """How a search begins: up to `steps` in which sliding along the surface costs too, by the weight `sliding`.

    It goes on with these as long as each takes more than `enough` of the cost away.
    """

    steps: int
    sliding: float
    enough: float


NEARBY = Rough(3, 0.05, 0.5)
FAR_AWAY = Rough(10, 0.5, 0.1)


@dataclass
class State:
    """Where a search is: pressures (C,), the pose, and the pairs that they give; see `_kernels.pairs`."""

    pressure: Floats
    rotation: Floats
    translation: Floats
    points: Floats
    slope: NDArray
    offset: Floats
    plane: Floats
    normal: Floats
    usable: Floats
    cost: float = np.inf

    def scale_mm(self) -> float:
        """Width of the robust cost: what is several times farther off than most counts for little."""
        from labrig.ik import _kernels

        return float(_kernels.scale_of(self.plane, self.usable))

    def mean_mm(self) -> float:
        """Mean distance of the samples that have the target opposite."""
        return float((np.abs(self.plane) * self.usable).sum() / max(self.usable.sum(), 1.0))

    def misfit(self, goal: Target, triangles: NDArray[np.int64]) -> float:
        """How badly the surfaces fit, as a share of the target's size; far is far, whatever lies opposite.

        The mean distance of all samples from the target, or of the target's points from the surface: the smaller one,
        for either may be a part of the other.
        """
        square = (self.offset**2).sum(axis=1)
        from_surface = float(np.minimum(np.sqrt(square) / goal.size_mm, _FAR).mean())
        return min(from_surface, self._from_target(goal, triangles))

    def _from_target(self, goal: Target, triangles: NDArray[np.int64]) -> float:
        from labrig.surface._coarse import match
        from labrig.surface._kernels import vertex_normals

        few = np.ascontiguousarray(goal.few[0].T)
        moved, index, square = np.empty_like(few), np.empty(len(few), np.int64), np.empty(len(few))
        match(few, self.rotation, self.translation, np.ascontiguousarray(self.points.T), moved, index, square)
        normal = vertex_normals(self.points, triangles)[index]
        height = np.abs(np.einsum("pi,pi->p", moved - self.points[index], normal))
        aside = np.sqrt(np.maximum(square - height**2, 0.0))
        spacing = np.sqrt(np.median(square)) + 0.03 * goal.size_mm
        distance = np.where(aside < spacing, height, np.sqrt(square))
        return float(np.minimum(distance / goal.size_mm, _FAR).mean())


class Descent:
    """Searches with one evaluator, within limits (C,), kPa; `middle_mm` (3,) is what poses turn about."""

    def __init__(self, evaluate: Evaluator, low: Floats, high: Floats, middle_mm: Floats) -> None:
        self.evaluate, self.low, self.high, self.middle = evaluate, low, high, middle_mm

    def look(self, goal: Target, pressure: Floats, rotation: Floats, translation: Floats) -> State:
        """The pairs at some pressures and pose."""
        from labrig.ik import _kernels

        points, slope = self.evaluate(pressure)
        points = np.asarray(points, np.float64)
        index, _ = goal.nearest.one((points - translation) @ rotation)
        count, mesh = len(points), goal.mesh
        offset, normal = np.empty((count, 3)), np.empty((count, 3))
        plane, usable = np.empty(count), np.empty(count)
        _kernels.pairs(
            points, rotation, translation, index, mesh.vertices_mm, mesh.normals, mesh.inwardness,
            offset, plane, normal, usable,
        )  # fmt: skip
        return State(pressure, rotation, translation, points, slope, offset, plane, normal, usable)

    def equations(self, state: State, scale_mm: float, sliding: float = 0.0) -> tuple[Floats, Floats]:
        """Normal matrix and gradient by pressures, rotation and translation, (C + 6,)."""
        from labrig.ik import _kernels

        return _kernels.normal_equations(
            state.points, state.slope, state.offset, state.plane, state.normal, state.usable,
            scale_mm, sliding, self.middle,
        )  # fmt: skip

    def run(
        self, goal: Target, pressure: Floats, pose: Pose, iterations: int, rough: Rough = NEARBY
    ) -> tuple[State, History]:
        """Go down from a start until no step gives anything; raises `LabrigError` where nothing is opposite."""
        began = time.perf_counter()
        state = self.look(goal, pressure, pose.rotation, pose.translation_mm)
        if state.usable.sum() < 0.02 * len(state.usable):
            raise LabrigError(NOWHERE)
        damping, left = _FIRST_DAMPING, rough.steps
        best, lowest, waited = state, np.inf, 0
        history = [(time.perf_counter() - began, state.mean_mm())]
        for _ in range(iterations):
            following, gain, damping = self._step(goal, state, damping, rough.sliding if left > 0 else 0.0)
            if following is not None:
                state, damping = following, max(damping / 5.0, _LEAST_DAMPING)
                history.append((time.perf_counter() - began, state.mean_mm()))
                if left == 0 and history[-1][1] < (1.0 - _PROGRESS) * lowest:
                    best, lowest, waited = state, history[-1][1], 0
                elif left == 0:
                    waited += 1
            if waited >= _PATIENCE:
                break
            if gain < _STILL and left == 0:
                break
            left = max(0, left - 1) if gain > rough.enough else 0
        state = best if lowest < np.inf else state
        state.cost = self._cost(state, state, state.scale_mm(), 0.0)
        return state, tuple(history)

    def _cost(self, state: State, other: State, scale_mm: float, sliding: float) -> float:
        """The cost of a state over the pairs that are usable in another one, too."""
        from labrig.ik import _kernels

        both = state.offset, state.plane, state.usable, other.usable
        return float(_kernels.cost_of(*both, scale_mm, sliding))

    def _step(
        self, goal: Target, state: State, damping: float, sliding: float
    ) -> tuple[State | None, float, float]:
        """The next state, None if no step is better; the share of the cost that it takes away; its damping."""
        from labrig.ik import _kernels

        scale = state.scale_mm()
        cost = self._cost(state, state, scale, sliding)
        H, g = self.equations(state, scale, sliding)
        for number in range(2 if sliding > 0 else _TRIES):
            step = _kernels.bounded_step(H, g, damping, state.pressure, self.low, self.high)
            promised = -(2.0 * g @ step + step @ H @ step) / (state.usable.sum() * cost + 1e-300)
            if promised < (_STILL if number == 0 else _HARDLY):
                break
            turn = rotation_of(step[-6:-3])
            moved = self.look(
                goal,
                np.clip(state.pressure + step[:-6], self.low, self.high),
                turn @ state.rotation,
                turn @ (state.translation - self.middle) + self.middle + step[-3:],
            )
            # at borders pairs come and go: only those that both have can be compared
            gain = 1.0 - self._cost(moved, state, scale, sliding) / self._cost(state, moved, scale, sliding)
            if gain > 0.0:
                return moved, gain, damping
            damping *= 10.0
        return None, 0.0, damping
