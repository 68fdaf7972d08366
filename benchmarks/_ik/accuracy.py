"""What the hardware could do at best, and what a model makes of it."""

from typing import Any

import numpy as np

from labrig.ik import Pose, ShellModel, Solver
from labrig.surface import Mesh, Target, distances, grid


class Fixed:
    """A surface that cannot change: to find the best pose of what was realised."""

    def __init__(self, control: Any, spline: Any) -> None:
        self.chamber_names = ("none",)
        self.low_kpa, self.high_kpa = np.zeros(1), np.full(1, 1e-9)
        self._control, self._spline = control, spline

    def points(self, pressure_kpa: Any, uv: Any) -> Any:
        """Always the same."""
        return np.repeat(
            self._spline.evaluate(self._control, uv)[None], len(np.atleast_2d(pressure_kpa)), axis=0
        )

    def jacobian(self, pressure_kpa: Any, uv: Any) -> Any:
        """Nothing moves."""
        return np.zeros((len(np.atleast_2d(pressure_kpa)), len(uv), 3, 1))


def against_the_best(models: dict[str, Any], plant: Any, bodies: list[Mesh]) -> dict[str, list[float]]:
    """Mean distance, mm, on every body: the plant's own best, and the plant at each model's pressures."""
    own = Solver(ShellModel(plant))
    searches = {name: Solver(model) for name, model in models.items()}
    rows: dict[str, list[float]] = {"best": []} | {name: [] for name in models}
    for mesh in bodies:
        goal = Target(mesh)
        candidates = {name: search.solve(goal, Pose.identity()) for name, search in searches.items()}
        # the plant's own best is sought from what the models say and from half pressure: the best is kept
        starts = [None, *(found.pressure_kpa for found in candidates.values())]
        best = min(
            (own.solve(goal, Pose.identity(), start) for start in starts), key=lambda found: found.mean_mm
        )
        rows["best"].append(realised(plant, best.pressure_kpa, goal))
        for name, found in candidates.items():
            rows[name].append(realised(plant, found.pressure_kpa, goal))
    return rows


def realised(plant: Any, pressure_kpa: Any, goal: Target) -> float:
    """Mean distance, mm, of the plant's surface at some pressures, in its best pose, from the target."""
    surface = Fixed(plant.solve(pressure_kpa).control_mm, plant.spline)
    found = Solver(surface).solve(goal, Pose.identity())
    uv, _ = grid(134, 134)
    placed = found.to_target(surface.points(np.zeros((1, 1)), uv)[0])
    return distances(placed, goal.mesh, goal.nearest).summary()["mean_mm"]
