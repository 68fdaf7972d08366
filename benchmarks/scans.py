"""Scans cleaned and registered, measured: writes the section "Scans" of the results.

    python benchmarks/scans.py [--turns 6] [--scans 10] [--out benchmarks/RESULTS.md]

Surfaces are made here: two membranes, two shells. Beside Open3D's features and RANSAC, with which scans are registered,
the two other starts are measured: its fast global registration (FGR), and the starts of the inverse kinematics. Times
are processor times of one core, without the process that Open3D has to itself; what that costs stands in a line of its
own.
"""

import argparse
import os
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import open3d as o3d

from labrig import LabrigError
from labrig.bench._report import markdown, write_section
from labrig.surface import Mesh, Target, grid, register
from labrig.surface import _align as align
from labrig.surface import _tidy as tidy
from labrig.surface._pose import rotation_of, spread_rotations
from labrig.surface._starts import COARSE, global_starts

HEADING = "## Scans"
NOISE_MM = 0.1
FOUND_MM = 3.0
WAYS = {
    "ransac": "Open3D: features and RANSAC",
    "fgr": "Open3D: fast global registration",
    "fast": "starts of the inverse kinematics",
}


def membrane(bulges: list[tuple[float, float, float]], n: int = 61) -> Mesh:
    """A sheet of 300 x 240 mm with bulges (height, u, v)."""
    uv, triangles = grid(n, n)
    u, v = uv.T
    edge = (1 - (2 * u - 1) ** 2) * (1 - (2 * v - 1) ** 2)
    z = edge * (5 * u + sum(h * np.exp(-((u - a) ** 2 + (v - b) ** 2) / 0.03) for h, a, b in bulges))
    return Mesh(np.stack([300 * u, 240 * v, z], axis=1), triangles)


def shell(opened: float, n: int = 61) -> Mesh:
    """An open shell of 300 x 400 mm, `opened` rad around, without a symmetry."""
    uv, triangles = grid(n, n + 10)
    u, v = uv.T
    angle = (u - 0.5) * opened
    radius = 120 + 18 * np.exp(-(((v - 0.7) / 0.15) ** 2) - ((u - 0.35) / 0.15) ** 2) + 12 * np.sin(3 * v) * u
    return Mesh(np.stack([radius * np.sin(angle), 0.8 * radius * np.cos(angle), 400 * v], 1), triangles)


SURFACES = {
    "three bulges": membrane([(40, 0.25, 0.25), (25, 0.75, 0.25), (50, 0.3, 0.8)]),
    "nearly flat": membrane([(8, 0.25, 0.25), (12, 0.75, 0.25)]),
    "open shell": shell(2.4),
    "wider shell": shell(3.6),
}


def part(mesh: Mesh, kept: np.ndarray) -> Mesh:
    """What is left of a surface with some of its vertices only."""
    return mesh.without(~kept)


def with_hand(mesh: Mesh) -> Mesh:
    """With a ball of 80 mm that touches its highest point."""
    uv, triangles = grid(26, 26)
    a, b = 2 * np.pi * uv[:, 0], np.pi * uv[:, 1]
    ball = 40 * np.stack([np.sin(b) * np.cos(a), np.sin(b) * np.sin(a), np.cos(b)], 1)
    top = mesh.vertices_mm[np.argmax(mesh.vertices_mm[:, 0])] + [25, 0, 0]
    points = np.concatenate([mesh.vertices_mm, ball + top])
    return Mesh(points, np.concatenate([mesh.triangles, triangles + len(mesh.vertices_mm)]))


CASES: dict[str, Callable[[Mesh], Mesh]] = {
    "whole": lambda m: m,
    "half": lambda m: part(m, m.vertices_mm[:, 0] > np.median(m.vertices_mm[:, 0])),
    "the other half": lambda m: part(m, m.vertices_mm[:, 2] > np.median(m.vertices_mm[:, 2])),
    "with a hand": with_hand,
}


def deviating(mesh: Mesh, seed: int, rms_mm: float) -> Mesh:
    """The surface as a model does not have it: smooth humps of `rms_mm`."""
    rng = np.random.default_rng(seed)
    x = mesh.vertices_mm
    height = np.zeros(len(x))
    for _ in range(6):
        height += rng.normal() * np.exp(-((x - x[rng.integers(len(x))]) ** 2).sum(axis=1) / 60.0**2)
    height *= rms_mm / np.sqrt(np.mean(height**2))
    return Mesh(x + mesh.normals * height[:, None], mesh.triangles)


def starts(way: str, source: Mesh, target: Mesh, size_mm: float) -> Iterator[Any]:
    """The motions (4, 4) of one way of finding them."""
    if way == "ransac":
        yield from RANSAC(source, target, size_mm)
    elif way == "fast":
        chosen = np.linspace(0, len(source.vertices_mm) - 1, COARSE).astype(int)
        points, normals = source.vertices_mm[chosen], source.normals[chosen]
        motion = np.eye(4)
        motion[:3, :3], motion[:3, 3], _ = global_starts(points, normals, Target(target))[0]
        yield motion
    else:
        cell_mm = size_mm / 40
        cloud, features = align._features(align._cloud(source.vertices_mm, source.normals), cell_mm)
        goal, wanted = align._features(align._cloud(target.vertices_mm, target.normals), cell_mm)
        registration = o3d.pipelines.registration
        o3d.utility.random.seed(0)
        options = registration.FastGlobalRegistrationOption(maximum_correspondence_distance=0.5 * cell_mm)
        found = registration.registration_fgr_based_on_feature_matching(
            cloud, goal, features, wanted, options
        )
        yield np.asarray(found.transformation)


RANSAC = align._from_anywhere


def searched(turns: int) -> list[list[str]]:
    """How many scans each way brings to where they belong, by case."""
    rows = []
    for case, change in CASES.items():
        for rms_mm in (0.0, 2.0):
            counts, taken = dict.fromkeys(WAYS, 0), {way: [] for way in WAYS}
            total = 0
            for mesh in SURFACES.values():
                for seed, turn in enumerate(spread_rotations(turns)):
                    real = deviating(mesh, seed, rms_mm) if rms_mm else mesh
                    scan = change(real)
                    noise = np.random.default_rng(seed).normal(0, NOISE_MM, scan.vertices_mm.shape)
                    lying = Mesh(scan.vertices_mm + noise, scan.triangles).moved(
                        turn, [200.0, -90.0, 30.0 * seed]
                    )
                    total += 1
                    for way in WAYS:
                        begin = time.process_time()
                        off_mm = _off(way, lying, mesh, scan, turn, seed)
                        taken[way].append(time.process_time() - begin)
                        counts[way] += off_mm < FOUND_MM + rms_mm
            words = f"{case}, {rms_mm:g} mm off the model" if rms_mm else case
            rows.append(
                [words, *(f"{counts[w]} of {total}, {1e3 * np.median(taken[w]):.0f} ms" for w in WAYS)]
            )
    return rows


def _off(way: str, lying: Mesh, mesh: Mesh, scan: Mesh, turn: Any, seed: int) -> float:
    """Mean distance, mm, of where the scan's points are brought from where they belong."""
    align._from_anywhere = lambda s, t, size_mm: starts(way, s, t, size_mm)
    try:
        motion = align.place(lying, mesh, None).motion
    except LabrigError:
        return np.inf
    finally:
        align._from_anywhere = RANSAC
    moved = scan.vertices_mm @ turn.T + [200.0, -90.0, 30.0 * seed]
    back = moved @ motion[:3, :3].T + motion[:3, 3]
    return float(np.linalg.norm(back - scan.vertices_mm, axis=1).mean())


def repeated(mesh: Mesh, scans: int) -> tuple[float, float, float]:
    """Of scans of one surface in other poses: spread, mm, at the worst point; its mean's distance, mm; time, s."""
    rng = np.random.default_rng(0)
    places, taken = [], []
    for _ in range(scans):
        turn, shift = rotation_of(0.4 * rng.normal(size=3)), 60.0 * rng.normal(size=3)
        noise = rng.normal(0.0, NOISE_MM, mesh.vertices_mm.shape)
        scan = Mesh(mesh.vertices_mm + noise, mesh.triangles).moved(turn, shift)
        _ = scan.normals, scan.border
        begin = time.process_time()
        motion = align.place(scan, mesh, None).motion
        taken.append(time.process_time() - begin)
        places.append((mesh.vertices_mm @ turn.T + shift) @ motion[:3, :3].T + motion[:3, 3])
    spread = np.linalg.norm(places - np.mean(places, axis=0), axis=-1).max()
    bias = np.linalg.norm(np.mean(places, axis=0) - mesh.vertices_mm, axis=-1).max()
    return float(spread), float(bias), float(np.median(taken))


def apart(mesh: Mesh) -> tuple[float, float]:
    """Wall time, s, of the first registration, with the start of its process, and of the next ones beside it."""
    times = []
    for _ in range(4):
        begin = time.perf_counter()
        register(mesh, mesh)
        times.append(time.perf_counter() - begin)
    return times[0], float(np.median(times[1:]))


def cleaned() -> float:
    """Processor time, s, of a scan of 295,000 triangles with 200 fragments."""
    mesh = shell(2.4, 380)
    rng = np.random.default_rng(0)
    bits = rng.normal(0, 300, (200, 1, 3)) + rng.normal(0, 1, (200, 3, 3)) + [0, 900, 0]
    points = np.concatenate([mesh.vertices_mm, bits.reshape(-1, 3)])
    more = np.arange(600).reshape(-1, 3) + len(mesh.vertices_mm)
    begin = time.process_time()
    _, triangles, _ = tidy.tidy_mesh(points, np.concatenate([mesh.triangles, more]), None)
    if len(triangles) != len(mesh.triangles):
        sys.exit("cleaning took part of the surface, or left fragments")
    return time.process_time() - begin


def main() -> None:
    """Measure everything and write the section."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--turns", type=int, default=6)
    parser.add_argument("--scans", type=int, default=10)
    parser.add_argument("--out", type=Path, default=Path("benchmarks/RESULTS.md"))
    given = parser.parse_args()
    o3d.utility.set_verbosity_level(o3d.utility.VerbosityLevel.Error)
    rows = []
    for words, mesh, asked in (
        ("4,331 points", shell(2.4), ""),
        ("22,500 points", shell(2.4, 145), "0.05 mm"),
    ):
        spread, bias, taken = repeated(mesh, given.scans)
        measured = f"repeatable to {spread:.3f} mm, mean {bias:.3f} mm off, {1e3 * taken:.0f} ms"
        rows.append([f"{given.scans} scans from any pose, {words}, {NOISE_MM} mm noise", measured, asked])
    first, later = apart(shell(2.4))
    rows.append(
        ["wall time with the process of its own: first scan, next ones", f"{first:.1f} s, {later:.2f} s", ""]
    )
    rows.append(["cleaning 295,000 triangles with 200 fragments", f"{cleaned():.1f} s", ""])
    how = (
        f"`python benchmarks/scans.py`: {len(SURFACES)} surfaces made in the script, in {given.turns} poses each. "
        "Processor time of one core, on a computer that was busy with other work."
    )
    table = markdown(["What", "Measured", "Asked for"], rows)
    ways = markdown(
        ["Scans brought to where they belong, with ICP after it", *WAYS.values()], searched(given.turns)
    )
    write_section(given.out, HEADING, [how, "", *table, "", *ways])


if __name__ == "__main__":
    main()
