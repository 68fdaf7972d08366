"""One search from one start: pressures and pose together, by damped Gauss-Newton on point-to-plane distances."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats, Ints
from labrig.ik._evaluate import Evaluator
from labrig.surface import Target, rotation_of

History = tuple[tuple[float, float], ...]
"""(time since the search began, s; mean distance, mm) at the start and after every step."""

NOWHERE = "the target lies nowhere opposite the surface: is it the right one, and its unit right?"

_LEAST_DAMPING = 1e-7
_FEW_TRIES, _TRIES = 2, 4
_FINE_DAMPING = 0.03
_EVEN_MM = 1.0
"""Distances well below this count by their squares, larger ones by their size."""
_MOST_MM, _MOST = 3.0, 20.0
"""From this, or this many times the median, on distances hardly count for more."""
_KEPT = 0.7
"""No fine step may leave less than this share of what was opposite when they began."""
_NEAR_LIMIT = 0.1
"""Share of its range within which a chamber's limit is tried."""
_PROGRESS, _PATIENCE = 1e-3, 2
"""So many steps in a row that each take less than this share of the mean distance away end the search."""
_STILL = 2e-3
"""A step that promises less than this share is not tried."""
_FAR = 0.08
"""Share of the target's size from which on a distance does not count for more."""
_HARDLY = 1e-3
"""A rough step that promises less than this share of the cost is not tried."""


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

    It goes on with these as long as each takes more than `enough` of the cost away. Steps that are damped more at first
    end at better shapes; fewer of them go a long way.
    """

    steps: int
    sliding: float
    enough: float
    damping: float


NEARBY = Rough(3, 0.05, 0.5, 0.1)
FAR_AWAY = Rough(10, 0.5, 0.1, 1e-3)


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
    drift: Floats
    index: Ints
    cost: float = np.inf

    def scale_mm(self) -> float:
        """Width of the robust cost: what is several times farther off than most counts for little."""
        from labrig.ik import _kernels

        return max(1.0, 6.0 * float(_kernels.median_of(self.plane, self.usable)))

    def mean_mm(self) -> float:
        """Mean distance of the samples that have the target opposite."""
        return float((np.abs(self.plane) * self.usable).sum() / max(self.usable.sum(), 1.0))

    def most_mm(self) -> float:
        """Beyond this a distance hardly counts for more: something foreign is opposite."""
        from labrig.ik import _kernels

        return max(_MOST_MM, _MOST * float(_kernels.median_of(self.plane, self.usable)))

    def size_mm(self, most_mm: float) -> float:
        """The mean distance, but smooth where one is zero and without much of what is foreign: what is minimised."""
        from labrig.ik import _kernels

        return float(_kernels.mean_size(self.plane, self.usable, _EVEN_MM, most_mm))

    def misfit(self, goal: Target, triangles: NDArray[np.int64]) -> float:
        """How badly the surfaces fit, as a share of the target's size; far is far, whatever lies opposite.

        The mean distance of all samples from the target, or of the target's points from the surface: the smaller one,
        for either may be a part of the other.
        """
        square = (self.offset**2).sum(axis=1)
        from_surface = float(np.minimum(np.sqrt(square) / goal.size_mm, _FAR).mean())
        return min(from_surface, self._from_target(goal, triangles))

    def _from_target(self, goal: Target, triangles: NDArray[np.int64]) -> float:
        from labrig.surface import vertex_normals
        from labrig.surface._coarse import matched

        few = goal.few[0][:, ::2].T
        found = matched(few, self.rotation[None], self.translation[None], self.points.T)
        moved, index, square = (each[0] for each in found)
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

    def look(
        self, goal: Target, pressure: Floats, rotation: Floats, translation: Floats, near: Ints | None = None
    ) -> State:
        """The pairs at some pressures and pose; `near` (P,) vertices that may be near, to find them quickly."""
        points, slope = self.evaluate(pressure)
        return self._paired(
            goal, pressure, rotation, translation, np.asarray(points, np.float64), slope, near
        )

    def _paired(
        self,
        goal: Target,
        pressure: Floats,
        rotation: Floats,
        translation: Floats,
        points: Floats,
        slope: NDArray,
        near: Ints | None = None,
    ) -> State:
        from labrig.ik import _kernels

        placed = (points - translation) @ rotation
        index = goal.near(placed, near)
        count, mesh = len(points), goal.mesh
        offset, normal, drift = (np.empty((count, 3)) for _ in range(3))
        plane, usable = np.empty(count), np.empty(count)
        _kernels.pairs(
            points, rotation, translation, index, mesh.vertices_mm, mesh.normals, mesh.inwardness,
            mesh.inward_slope, offset, plane, normal, usable, drift,
        )  # fmt: skip
        return State(
            pressure, rotation, translation, points, slope, offset, plane, normal, usable, drift, index
        )

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
        history: list[tuple[float, float]] = []

        def log(reached: State) -> State:
            history.append((time.perf_counter() - began, reached.mean_mm()))
            return reached

        log(state)
        damping, left = rough.damping, min(rough.steps, iterations)
        while left > 0:
            following, gain, damping = self._rough_step(goal, state, damping, rough.sliding)
            if following is None:
                break
            state, damping = log(following), max(damping / 5.0, _LEAST_DAMPING)
            left = left - 1 if gain > rough.enough else 0
        least = _KEPT * float(state.usable.sum())
        while True:
            state = self._fine_steps(goal, state, iterations + 1 - len(history), least, log)
            at_limits = self._at_limits(goal, state, least)
            if at_limits is None:
                break
            state = log(at_limits)
        state = self._paired(
            goal, state.pressure, state.rotation, state.translation, state.points, state.slope
        )
        state.cost = state.size_mm(state.most_mm())
        return state, tuple(history)

    def _moved(self, goal: Target, state: State, step: Floats, near: Ints | None = None) -> State:
        """What a step by pressures, rotation and translation leads to; `near` as of `look`."""
        turn = rotation_of(step[-6:-3])
        return self.look(
            goal,
            np.clip(state.pressure + step[:-6], self.low, self.high),
            turn @ state.rotation,
            turn @ (state.translation - self.middle) + self.middle + step[-3:],
            near,
        )

    def _cost(self, state: State, other: State, scale_mm: float, sliding: float) -> float:
        """The robust cost of a state over the pairs that are usable in another one, too."""
        from labrig.ik import _kernels

        both = state.offset, state.plane, state.usable, other.usable
        return float(_kernels.cost_of(*both, scale_mm, sliding))

    def _rough_step(
        self, goal: Target, state: State, damping: float, sliding: float
    ) -> tuple[State | None, float, float]:
        """The next state, None if no step is better; the share of the cost that it takes away; its damping."""
        from labrig.ik import _kernels

        scale = state.scale_mm()
        cost = self._cost(state, state, scale, sliding)
        H, g = self.equations(state, scale, sliding)
        for _ in range(_FEW_TRIES):
            step = _kernels.bounded_step(H, g, damping, state.pressure, self.low, self.high)
            promised = -(2.0 * g @ step + step @ H @ step) / (state.usable.sum() * cost + 1e-300)
            if promised < _HARDLY:
                break
            moved = self._moved(goal, state, step)
            # far away whole regions come and go: only pairs that both states have can be compared
            gain = 1.0 - self._cost(moved, state, scale, sliding) / self._cost(state, moved, scale, sliding)
            if gain > 0.0:
                return moved, gain, damping
            damping *= 10.0
        return None, 0.0, damping

    def _fine_steps(
        self, goal: Target, state: State, most_steps: int, least: float, log: Callable[[State], State]
    ) -> State:
        damping, waited = _FINE_DAMPING, 0
        for _ in range(most_steps):
            following, gain, damping = self._fine_step(goal, state, damping, least)
            if following is None:
                break
            waited = waited + 1 if gain < _PROGRESS else 0
            state, damping = log(following), max(damping / 5.0, _LEAST_DAMPING)
            if waited >= _PATIENCE:
                break
        return state

    def _at_limits(self, goal: Target, state: State, least: float) -> State | None:
        """The chambers that are nearly at a limit put there, and a step from that; None if it is no better.

        A chamber that is all but vented lies flat and hardly answers to its pressure, and steps get lost there.
        """
        near = _NEAR_LIMIT * (self.high - self.low)
        pressure = np.where(state.pressure < self.low + near, self.low, state.pressure)
        pressure = np.where(state.pressure > self.high - near, self.high, pressure)
        if (pressure == state.pressure).all():
            return None
        moved = self.look(goal, pressure, state.rotation, state.translation, state.index)
        further, _, _ = self._fine_step(goal, moved, _LEAST_DAMPING, least)
        moved = further or moved
        most = state.most_mm()
        better = moved.size_mm(most) < (1.0 - _PROGRESS) * state.size_mm(most) and moved.usable.sum() >= least
        return moved if better else None

    def _fine_step(
        self, goal: Target, state: State, damping: float, least: float
    ) -> tuple[State | None, float, float]:
        """The next state, None if no step is better; the share of the mean that it takes away; its damping."""
        from labrig.ik import _kernels

        most = state.most_mm()
        cost = state.size_mm(most)
        H, g = _kernels.mean_equations(
            state.points, state.slope, state.offset, state.plane, state.normal, state.usable, state.drift,
            _EVEN_MM, most, self.middle,
        )  # fmt: skip
        for _ in range(_TRIES):
            step = _kernels.bounded_step(H, g, damping, state.pressure, self.low, self.high)
            if -(g @ step + 0.5 * step @ H @ step) < _STILL * cost:
                break
            moved = self._moved(goal, state, step, state.index)
            gain = 1.0 - moved.size_mm(most) / max(cost, 1e-300)
            if gain > 0.0 and moved.usable.sum() >= least:
                return moved, gain, damping
            damping *= 10.0
        return None, 0.0, damping
