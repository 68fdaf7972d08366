"""Searches side by side: labrig's and the paper's, on shapes that can be reached and on bodies that cannot quite."""

import time
from pathlib import Path
from typing import Any

import numpy as np

from labrig._executor import Executor
from labrig.ik import GradientDescent, Solver, solve_files
from labrig.surface import Mesh, Target, distances, grid
from labrig.surface._pose import rotation_of, spread_rotations

SCORED = 134


def reachable(simulated: Any, unseen: Any, count: int, far: bool = False) -> list[tuple[Mesh, Any]]:
    """Simulated surfaces that the model did not learn from, as scans: noise of 0.1 mm, turned by
    ~6 degrees and shifted by ~14 mm (or anywhere).
    """
    uv, triangles = grid(SCORED, SCORED)
    rng = np.random.default_rng(3)
    chosen = np.flatnonzero(simulated.converged)[unseen][:count]
    out = []
    for number, k in enumerate(chosen):
        points = simulated.spline.evaluate(np.asarray(simulated.control_mm[k], float), uv)
        R, t = rotation_of(0.06 * rng.normal(size=3)), 8.0 * rng.normal(size=3)
        if far:
            R, t = spread_rotations(count)[number], 300.0 * rng.normal(size=3)
        noisy = points + rng.normal(0.0, 0.1, points.shape)
        out.append((Mesh((noisy - t) @ R, triangles), np.asarray(simulated.pressure_kpa[k], float)))
    return out


def score(model: Any, found: Any, goal: Target) -> float:
    """Mean absolute distance, mm, of 17,956 samples of the surface that have the target opposite."""
    uv, _ = grid(SCORED, SCORED)
    points = np.asarray(model.points(found.pressure_kpa[None], uv), float)[0]
    placed = (points - found.translation_mm) @ found.rotation
    return distances(placed, goal.mesh, goal.nearest).summary()["mean_mm"]


def side_by_side(
    model: Any, targets: list[Mesh], paper: bool = True, truth: list[Any] | None = None
) -> dict[str, Any]:
    """Processor times with the target's preparation, s, iterations, distances and errors; the paper's beside them."""
    ours, theirs = Solver(model), GradientDescent(model, SCORED, borders=False)
    ours.solve(targets[0])
    rows: dict[str, list[float]] = {}
    for number, mesh in enumerate(targets):
        for name, search in (("ours", ours), ("paper", theirs)):
            if name == "paper" and not paper:
                continue
            fresh = Mesh(mesh.vertices_mm, mesh.triangles)  # nothing is prepared yet
            begin = time.process_time()
            goal = Target(fresh)
            found = search.solve(goal)
            took = time.process_time() - begin
            row = {"time_s": took, "iterations": found.iterations, "mean_mm": score(model, found, goal)}
            if truth is not None:
                row["off_kpa"] = float(np.abs(found.pressure_kpa - truth[number]).mean())
            for key, value in row.items():
                rows.setdefault(f"{name}_{key}", []).append(float(value))
    return rows


def progress(model: Any, mesh: Mesh) -> dict[str, list[tuple[float, float]]]:
    """Distance by time of both searches on one target: (s, mm); the paper's is a root mean square."""
    ours, theirs = Solver(model), GradientDescent(model, SCORED, borders=False)
    for search in (ours, theirs):
        search.solve(mesh, iterations=2)
    return {
        "ours": list(ours.solve(Target(mesh)).history),
        "paper": list(theirs.solve(Target(mesh)).history),
    }


def batch(
    files: list[Path], model: Path, workers: int, cluster: str | None = None
) -> tuple[float, list[Any]]:
    """Wall time, s, of all files through the executor, reading and exact measuring included; and the results.

    What its processes take to start and to load the compiled loops was spent before.
    """
    with Executor(workers, cluster) as executor:
        solve_files(files[: 4 * workers], model, "mm", executor=executor)
        begin = time.perf_counter()
        solved = solve_files(files, model, "mm", executor=executor)
        return time.perf_counter() - begin, solved
