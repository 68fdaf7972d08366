"""What the shell simulator costs and how far it can be trusted: writes the section "Simulator" of the results.

    python benchmarks/simulate.py [--count 1000] [--runs 3] [--workers 2] [--out benchmarks/RESULTS.md]

Run it on a quiet computer. Verification figures against theory are those of tests/physics/test_shell_verification.py.
"""

import argparse
import os
import platform
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np
import yaml

from labrig.bench._report import write_section
from labrig.cli._demo_steps import MODEL, RIG
from labrig.physics import (
    Shell,
    ShellSurface,
    Simulations,
    load_body,
    load_shell,
    load_surface,
    plant_shell,
    simulate,
)

PAPER_S = 150.0
CALIBRATED: dict[str, float] = yaml.safe_load(MODEL)["base"]["parameters"]


def timed_set(shell: Shell, count: int, workers: int, jacobians: bool) -> tuple[float, float, Simulations]:
    """Wall time, s, of a set of simulations; processor time of its processes, s (0 if unknown); the set."""
    with tempfile.TemporaryDirectory() as folder:
        begin, before = time.perf_counter(), os.times()
        found = simulate(shell, Path(folder) / "set", count, jacobians=jacobians, workers=workers)
        wall, after = time.perf_counter() - begin, os.times()
    worked = sum(getattr(after, k) - getattr(before, k) for k in ("children_user", "children_system"))
    return wall, worked, found


def patterns(shell: Shell) -> list[np.ndarray]:
    """Some hard pressures: everything, one chamber, every other, a random one."""
    chambers = len(shell.max_kpa)
    full = np.ones(chambers)
    one, other = np.eye(chambers)[3 % chambers], np.arange(chambers) % 2
    return [p * shell.max_kpa for p in (full, one, other, np.random.default_rng(2).random(chambers))]


def convergence(name: str, counts: tuple[int, ...], finest: int) -> list[tuple[int, float, float, float]]:
    """(control points per direction, mean and largest distance from the finest, mm, processor time of a solve, s)."""
    uv = np.random.default_rng(0).random((4000, 2))

    def shapes(count: int) -> tuple[np.ndarray, float]:
        shell = load_shell(name).changed(count=(count, count))
        shell.solve(0.1 * shell.max_kpa)
        begin = time.process_time()
        solved = [shell.solve(p) for p in patterns(shell)]
        spent = (time.process_time() - begin) / len(solved)
        return np.array([shell.spline.evaluate(s.control_mm, uv) for s in solved]), spent

    reference, _ = shapes(finest)
    rows = []
    for count in counts:
        found, spent = shapes(count)
        off = np.linalg.norm(found - reference, axis=-1)
        rows.append((count, float(off.mean()), float(off.max()), spent))
    return rows


def starts_agree(shell: Shell, count: int = 8) -> float:
    """Largest distance, mm, between shapes found from rest, from another shape, and from half the way."""
    random, worst, other = np.random.default_rng(3), 0.0, shell.solve(0.5 * shell.max_kpa)
    for k in range(count):
        share = random.random(len(shell.max_kpa)) if k % 2 else (random.random(len(shell.max_kpa)) < 0.5)
        cold = shell.solve(share * shell.max_kpa)
        for start in (other.state, 0.5 * cold.state):
            worst = max(
                worst,
                float(np.abs(shell.solve(share * shell.max_kpa, start).layers_mm - cold.layers_mm).max()),
            )
        other = cold
    return worst


def jacobian_errors(shell: Shell, count: int = 4) -> tuple[float, float]:
    """Median and largest error of implicit derivatives by pressure, relative in the norm of a chamber's derivative.

    The largest are those of chambers where a contact opens or closes within the step: there shapes have a kink.
    """
    random, off = np.random.default_rng(5), []
    for _ in range(count):
        at = shell.solve(random.random(len(shell.max_kpa)) * 0.9 * shell.max_kpa + 1.0)
        exact = shell.jacobian(at)
        for chamber in range(len(shell.max_kpa)):
            step = 0.1 * np.eye(len(shell.max_kpa))[chamber]
            up, down = (shell.solve(at.pressure_kpa + sign * step, at).control_mm for sign in (1, -1))
            wrong = np.linalg.norm((up - down) / 0.2 - exact[..., chamber])
            off.append(wrong / np.linalg.norm(exact[..., chamber]))
    return float(np.median(off)), float(np.max(off))


def plant_lines() -> list[str]:
    """How far the plant of a simulated rig is from its model, and its quick shapes from solved ones."""
    rig = {"name": "mannequin", "simulated": {"shell": "mannequin", "seed": 0}}
    body, model = load_body(rig), load_surface(rig)
    random = np.random.default_rng(7)
    held = random.uniform(0, 1, (20, 9)) * body.shell.max_kpa
    near = np.clip(held + random.normal(0, 2.0, held.shape), 0, body.shell.max_kpa)
    solved, solved_near = (np.array([body.solved_mm(p) for p in some]) for some in (held, near))
    quick = body.shape_mm(body.deflection_mm(held))
    at_hold = quick + np.stack([body.correction_mm(p, body.deflection_mm(p[None]))[0] for p in held])
    deflection = body.deflection_mm(near)
    beside = body.shape_mm(deflection)
    beside = beside + np.stack(
        [body.correction_mm(p, d[None])[0] for p, d in zip(held, deflection, strict=True)]
    )
    off = np.linalg.norm(model.predict(held) - solved, axis=-1)

    def rms(difference: np.ndarray) -> str:
        return f"{np.sqrt(np.mean(difference**2)):.3f} mm"

    def distances(off: np.ndarray) -> str:
        return f"{off.mean():.2f}, {off.max():.2f} mm"

    return [
        f"| plant of the simulated mannequin (every parameter varied) against its model, markers: mean, largest | "
        f"{distances(off)} | millimetres |",
        *(
            f"| the demo's plant (other materials) against its model {how} | {distances(demo_off(held, known))} | |"
            for how, known in (("with the shell's moduli", {}), ("with its calibrated moduli", CALIBRATED))
        ),
        f"| its quick shapes between set-points against solved ones, rms per axis | {rms(quick - solved)} | |",
        f"| the same where it is held | {rms(at_hold - solved)} | |",
        f"| the same 2 kPa (rms) beside where it is held | {rms(beside - solved_near)} | 0.05-0.1 mm |",
    ]


def demo_off(pressure_kpa: np.ndarray, parameters: dict[str, float]) -> np.ndarray:
    """How far the markers of the demo's plant are from its model's, mm, (N, M)."""
    rig = yaml.safe_load(RIG)
    plant = ShellSurface(plant_shell(rig), rig["markers"])
    return np.linalg.norm(
        load_surface(rig, None, parameters).predict(pressure_kpa) - plant.predict(pressure_kpa), axis=-1
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("benchmarks/RESULTS.md"))
    given = parser.parse_args()
    shell = load_shell("mannequin")
    shell.solve(0.2 * shell.max_kpa)  # compiled from here on

    lines = []
    for jacobians, goal in ((False, 60), (True, 90)):
        runs = [timed_set(shell, given.count, given.workers, jacobians) for _ in range(given.runs)]
        wall = [seconds for seconds, _, _ in runs]
        worked = statistics.median(seconds for _, seconds, _ in runs) / given.workers
        cpu = statistics.median(float(found.cpu_s.mean()) for *_, found in runs)
        failed = sum(int((~found.converged).sum()) for *_, found in runs)
        same = all(np.array_equal(runs[0][2].control_mm, found.control_mm) for *_, found in runs[1:])
        bits = ("yes" if same else "no") if len(runs) > 1 else "one run"
        what = "with Jacobians by pressure" if jacobians else "shapes alone"
        lines.append(
            f"| {given.count:,} simulations, {given.workers} processes, {what}: wall time, median of {given.runs} "
            f"(least, most) | {statistics.median(wall):.0f} s ({min(wall):.0f}, {max(wall):.0f}) | at most {goal} s |"
        )
        lines.append(
            f"| processor time of each process, start and all: the wall time on {given.workers} cores of its own | "
            f"{worked:.0f} s | at most {goal} s |"
        )
        lines.append(
            f"| processor time of one, mean | {1e3 * cpu:.0f} ms ({PAPER_S / cpu:,.0f} times less than the paper's "
            f"{PAPER_S:.0f} s) | |"
        )
        lines.append(f"| not converged; runs bit-identical | {failed}; {bits} | 0; yes |")
    middle, worst = jacobian_errors(shell)
    lines.append(
        f"| implicit derivatives by pressure against differences over 0.2 kPa: median; worst (a contact opens) | "
        f"{100 * middle:.2f} %; {100 * worst:.1f} % | |"
    )
    lines.append(f"| the same shape from three kinds of start, worst | {starts_agree(shell):.4f} mm | |")
    lines += plant_lines()
    table = convergence("mannequin", (16, 22, 30, 34, 38), 48)
    load = f", load average {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    write_section(
        given.out,
        "## Simulator",
        [
            f"`python benchmarks/simulate.py --count {given.count} --runs {given.runs} --workers {given.workers}` on "
            f"{platform.machine()}, {os.cpu_count()} cores shared with other work{load} at the end, "
            f"Python {platform.python_version()}.",
            "",
            "| What | Measured | Asked for |",
            "|---|---|---|",
            *lines,
            "",
            "Mesh convergence of the mannequin, four pressures, 4,000 points, against 48 x 48 control points:",
            "",
            "| Control points | mean | largest | processor time of a solve from rest |",
            "|---|---|---|---|",
            *(
                f"| {n} x {n} | {mean:.3f} mm | {most:.2f} mm | {1e3 * cpu:.0f} ms |"
                for n, mean, most, cpu in table
            ),
        ],
    )


if __name__ == "__main__":
    main()
