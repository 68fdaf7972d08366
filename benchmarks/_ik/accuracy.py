"""What the hardware could do at best, and what a model makes of it; how scans repeat."""

import time
from typing import Any

import numpy as np

from labrig.ik import Pose, ShellModel, Solver
from labrig.surface import Mesh, Target, distances, grid, register
from labrig.surface._pose import rotation_of


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


def registration(surface: Mesh, scans: int = 10, noise_mm: float = 0.1) -> dict[str, dict[str, float]]:
    """Scans of one surface in other poses: how far a point comes to lie from the mean of all scans at worst, mm, and

    processor time, s; with small_gicp's trees, with scipy's, and Open3D's point-to-plane ICP from the same start.
    """
    out = {}
    for name in ("small_gicp", "scipy", "open3d"):
        rng = np.random.default_rng(0)
        places, taken = [], []
        for _ in range(scans):
            R, t = rotation_of(0.4 * rng.normal(size=3)), 60.0 * rng.normal(size=3)
            noisy = surface.vertices_mm + rng.normal(0.0, noise_mm, surface.vertices_mm.shape)
            scan = Mesh(noisy @ R.T + t, surface.triangles)
            rough = register(scan, surface) if name == "open3d" else None
            begin = time.process_time()
            if rough is not None:
                found_R, found_t = _open3d(scan, surface, rough)
            else:
                found = register(scan, Target(surface, name == "small_gicp"))
                found_R, found_t = found.rotation, found.translation_mm
            taken.append(time.process_time() - begin)
            places.append((surface.vertices_mm @ R.T + t) @ found_R.T + found_t)
        spread = np.linalg.norm(places - np.mean(places, axis=0), axis=-1)
        bias = np.linalg.norm(np.mean(places, axis=0) - surface.vertices_mm, axis=-1)
        out[name] = {
            "worst_mm": float(spread.max()),
            "bias_mm": float(bias.max()),
            "time_s": float(np.median(taken[1:])),
        }
    return out


def _open3d(scan: Mesh, surface: Mesh, rough: Any) -> tuple[Any, Any]:
    """Open3D's robust point-to-plane ICP, begun two degrees and 3 mm beside where ours ended."""
    import open3d as o3d

    def cloud(mesh: Mesh) -> Any:
        made = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(mesh.vertices_mm))
        made.normals = o3d.utility.Vector3dVector(mesh.normals)
        return made

    start = np.eye(4)
    start[:3, :3] = rotation_of(np.array([0.02, 0.02, 0.02])) @ rough.rotation
    start[:3, 3] = rough.translation_mm + 3.0
    kernel = o3d.pipelines.registration.TukeyLoss(k=1.0)
    found = o3d.pipelines.registration.registration_icp(
        cloud(scan), cloud(surface), 20.0, start,
        o3d.pipelines.registration.TransformationEstimationPointToPlane(kernel),
        o3d.pipelines.registration.ICPConvergenceCriteria(1e-9, 1e-9, 60),
    ).transformation  # fmt: skip
    return found[:3, :3], found[:3, 3]
