"""The method of the source paper, to compare with: gradient steps on the pressures, ICP on the pose, in turns.

It minimises the sum of squared distances between the samples of the surface and their nearest points on the target
(Tian et al. 2024, arXiv 2405.08935): one gradient step with line search on the pressures, then one step of ICP.
"""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.ik._descent import NOWHERE, History
from labrig.ik._evaluate import ShapeModel, evaluator
from labrig.surface import Mesh, Target, grid

SAMPLES = 134
"""134 x 134 = 17,956 samples, the paper's 18,000."""
_FIRST_STEP = 0.1
_HALVINGS = 20
_ICP_BEFORE = 5


@dataclass(frozen=True)
class BaselineResult:
    """Pressures (C,), kPa; target to rig: x -> rotation @ x + translation_mm; and how the search went."""

    pressure_kpa: Floats
    rotation: Floats
    translation_mm: Floats
    iterations: int
    time_s: float
    prepare_s: float
    history: History


class GradientDescent:
    """The paper's search for one model; `samples` x `samples` points of the surface.

    `borders` says whether samples whose nearest point is on the target's border count, as they do in the paper; where
    the target is a part of what the surface can be, they pull it together.
    """

    def __init__(self, model: ShapeModel, samples: int = SAMPLES, borders: bool = True) -> None:
        self.model, self._borders = model, borders
        self.low, self.high = np.asarray(model.low_kpa, float), np.asarray(model.high_kpa, float)
        self.uv, _ = grid(samples, samples)
        self.evaluate = evaluator(model, self.uv)

    def solve(
        self,
        target: Mesh | Target,
        start_kpa: ArrayLike | None = None,
        iterations: int = 300,
        tolerance: float = 1e-4,
    ) -> BaselineResult:
        """Go down from half of every range until a round gains less than `tolerance` of the cost."""
        began = time.perf_counter()
        goal = target if isinstance(target, Target) else Target(target)
        _ = goal.mesh.border
        prepared = time.perf_counter()
        span = self.high - self.low
        x = np.full(len(span), 0.5) if start_kpa is None else (np.asarray(start_kpa, float) - self.low) / span
        R, t, step = np.eye(3), np.zeros(3), 0.0
        points = np.asarray(self.evaluate.points(self.low + x * span), float)
        cost, feet, count = self._cost(goal, points, R, t)
        for _ in range(_ICP_BEFORE):
            R, t = _icp(points, goal, feet, count)
            cost, feet, count = self._cost(goal, points, R, t)
        history = [(time.perf_counter() - prepared, np.sqrt(cost))]
        for _ in range(iterations):
            before = cost
            slope = self.gradient(self.low + x * span, goal, feet, R, t, count) * span
            step = _FIRST_STEP / np.abs(slope).max() if step == 0.0 else 2.0 * step
            for _ in range(_HALVINGS):
                trial = np.clip(x - step * slope, 0.0, 1.0)
                points = np.asarray(self.evaluate.points(self.low + trial * span), float)
                cost, feet, count = self._cost(goal, points, R, t)
                if cost < before:
                    break
                step *= 0.5
            else:
                break
            x = trial
            R, t = _icp(points, goal, feet, count)
            cost, feet, count = self._cost(goal, points, R, t)
            history.append((time.perf_counter() - prepared, np.sqrt(cost)))
            if (before - cost) / before < tolerance:
                break
        took = time.perf_counter() - prepared
        return BaselineResult(
            self.low + x * span, R, t, len(history) - 1, took, prepared - began, tuple(history)
        )

    def gradient(
        self, pressure_kpa: Floats, goal: Target, feet: NDArray[np.int64], R: Floats, t: Floats, count: Floats
    ) -> Floats:
        """Derivative of the mean squared distance by the pressures, (C,), the pairs held; `count` (P,) weights."""
        points, slope = self.evaluate(pressure_kpa)
        offset = np.asarray(points, float) - (goal.mesh.vertices_mm[feet] @ R.T + t)
        return 2.0 * np.einsum("pd,pdc,p->c", offset, slope, count, optimize=True) / count.sum()

    def _cost(
        self, goal: Target, points: Floats, R: Floats, t: Floats
    ) -> tuple[float, NDArray[np.int64], Floats]:
        feet, square = goal.nearest.one((points - t) @ R)
        count = np.ones(len(points)) if self._borders else (~goal.mesh.border[feet]).astype(float)
        if count.sum() < 0.02 * len(points):
            raise LabrigError(NOWHERE)
        return float((square * count).sum() / count.sum()), feet, count


def _icp(points: Floats, goal: Target, feet: NDArray[np.int64], count: Floats) -> tuple[Floats, Floats]:
    """The pose that brings the pairs together: least squares between points (Kabsch)."""
    w, c = count / count.sum(), goal.mesh.vertices_mm[feet]
    a, b = w @ c, w @ points
    U, _, Vt = np.linalg.svd((points - b).T @ ((c - a) * w[:, None]))
    R = U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt)) or 1.0]) @ Vt
    return R, b - R @ a
