"""Inverse kinematics, measured: writes the section "Inverse kinematics" of the results.

    python benchmarks/ik.py [--bodies BODIES.npz] [--paper 24] [--shapes 24] [--best 16] [--out benchmarks/RESULTS.md]

`--bodies` names a file with `grid_mm` (B, rows, columns, 3); without it the eight examples are used. What is made on
the way (simulations of the torso, its forward model) is kept in benchmarks/out/ik. Times are processor times of one
core unless they are said to be wall times.
"""

import os
import sys
import tempfile
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from _ik import accuracy, evaluation, search
from _ik.setup import Bench, asked_for

from labrig.bench._report import markdown, write_section
from labrig.campaign._scans import keep_scan
from labrig_drivers import Scan

HEADING = "## Inverse kinematics"


def main() -> None:
    """Measure everything and write the section."""
    parser = asked_for(__doc__.splitlines()[0], "bodies for the paper's search, too")
    parser.add_argument(
        "--shapes", type=int, default=24, help="shapes that can be reached, for both searches"
    )
    parser.add_argument("--best", type=int, default=16, help="bodies on which the plant's own best is sought")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    bench = Bench(given.folder, given.bodies, given.workers)
    model = bench.model
    rows: list[list[str]] = []
    _evaluation(rows, evaluation.measure(model))
    shapes = search.reachable(bench.simulated, bench.unseen, given.shapes)
    truth = [pressure for _, pressure in shapes]
    _searches(
        rows, "shapes that can be reached", search.side_by_side(model, [m for m, _ in shapes], True, truth)
    )
    far = search.reachable(bench.simulated, bench.unseen, 2 * given.shapes, far=True)
    _anywhere(rows, search.side_by_side(model, [m for m, _ in far], False, [p for _, p in far]))
    every = bench.bodies()
    _searches(rows, "bodies", search.side_by_side(model, bench.bodies(given.paper)))
    _alone(rows, len(every), search.side_by_side(model, every, False))
    _batch(rows, bench, every)
    models = {"forward model": model, "with a warp of 40 captures": bench.warped}
    best = accuracy.against_the_best(models, bench.plant(), bench.bodies(given.best))
    _accuracy(rows, best)
    how = (
        f"`python benchmarks/ik.py`{' --bodies ...' if given.bodies else ''}: shell `torso`, 9 chambers, forward model "
        f"of {bench.simulations} simulations; {len(every)} synthetic bodies. Processor time of one core, on a computer "
        "that was busy with other work; preparing the target (normals, border, tree) is counted."
    )
    write_section(given.out, HEADING, [how, "", *markdown(["What", "Measured", "Asked for"], rows)])


def _evaluation(rows: list[list[str]], found: dict[str, float]) -> None:
    for name, words in (("plain", "forward model"), ("warped", "with a warp of 34 centers")):
        ratio = found[f"{name}_s"] / found[f"{name}_floor_s"]
        floor_ms = 1e3 * found[f"{name}_floor_s"]
        measured = f"{1e3 * found[f'{name}_s']:.2f} ms, {ratio:.1f} times the floor of {floor_ms:.2f} ms"
        rows.append([f"17,956 points with Jacobian, {words}", measured, "at most 4 times the floor"])
    rows.append(
        [
            "latent coordinates with Jacobian (Gaussian process, once a step); 729 points with Jacobian altogether",
            f"{1e3 * found['latent_s']:.2f} ms; {1e3 * found['few_s']:.2f} ms",
            "",
        ]
    )


def _searches(rows: list[list[str]], kind: str, found: dict[str, list[float]]) -> None:
    ours, paper = np.array(found["ours_time_s"]), np.array(found["paper_time_s"])
    closer = np.array(found["ours_mean_mm"]) < np.array(found["paper_mean_mm"])
    rows += [
        [
            f"{len(ours)} {kind}: time a target, median (worst)",
            f"{1e3 * np.median(ours):.1f} ms ({1e3 * ours.max():.0f} ms)",
            "at most 15 ms",
        ],
        [
            "the paper's method beside it; how many times longer, median",
            f"{1e3 * np.median(paper):.0f} ms; {np.median(paper / ours):.0f}",
            "at least 100",
        ],
        [
            "final distance, median: ours, the paper's; ours smaller on",
            ", ".join(f"{np.median(found[key]):.3f} mm" for key in ("ours_mean_mm", "paper_mean_mm"))
            + f"; {closer.mean():.0%}",
            "at least 95 %",
        ],
        [
            "steps, median (most): ours, the paper's",
            f"{np.median(found['ours_iterations']):.0f} ({max(found['ours_iterations']):.0f}), "
            f"{np.median(found['paper_iterations']):.0f} ({max(found['paper_iterations']):.0f})",
            "",
        ],
    ]
    if "ours_off_kpa" in found:
        rows.append(
            [
                "mean error of the pressures, median: ours, the paper's",
                f"{np.median(found['ours_off_kpa']):.2f} kPa, {np.median(found['paper_off_kpa']):.2f} kPa",
                "",
            ]
        )


def _anywhere(rows: list[list[str]], found: dict[str, list[float]]) -> None:
    ours, mean = np.array(found["ours_time_s"]), np.array(found["ours_mean_mm"])
    rows.append(
        [
            f"{len(ours)} reachable shapes turned and shifted anyhow: found to 0.3 mm; time, median (worst)",
            f"{(mean < 0.3).mean():.0%}; {1e3 * np.median(ours):.0f} ms ({1e3 * ours.max():.0f} ms)",
            "",
        ]
    )


def _alone(rows: list[list[str]], count: int, found: dict[str, list[float]]) -> None:
    ours, mean = np.array(found["ours_time_s"]), np.array(found["ours_mean_mm"])
    rows.append(
        [
            f"all {count} bodies: time, median (worst); distance of the model's surface, median (worst)",
            f"{1e3 * np.median(ours):.1f} ms ({1e3 * ours.max():.0f} ms); "
            f"{np.median(mean):.2f} mm ({mean.max():.2f} mm)",
            "at most 15 ms",
        ]
    )


def _batch(rows: list[list[str]], bench: Bench, bodies: list[Any]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        files = [
            Path(folder) / keep_scan(Scan(0.0, one.vertices_mm, one.triangles, (), ""), Path(folder))[0]
            for one in bodies
        ]
        took, solved = search.batch(files, bench.folder / "torso.pt", bench.workers)
    failed = sum(one.result is None for one in solved)
    rows.append(
        [
            f"{len(files)} bodies from their files, {bench.workers} processes, started and warmed up: wall time",
            f"{took:.1f} s, {failed} failed",
            "",
        ]
    )


def _accuracy(rows: list[list[str]], found: dict[str, list[float]]) -> None:
    best = np.array(found.pop("best"))
    rows.append(
        [
            f"{len(best)} bodies: the plant's own best (finer mesh, other parameters), median (worst)",
            f"{np.median(best):.2f} mm ({best.max():.2f} mm)",
            "",
        ]
    )
    for name, values in found.items():
        above = np.array(values) / best - 1.0
        rows.append(
            [
                f"realised on that plant, {name}: median; above the plant's own best, median (worst)",
                f"{np.median(values):.2f} mm; {np.median(above):.1%} ({above.max():.0%})",
                "at most 10 % on the median body",
            ]
        )


if __name__ == "__main__":
    main()
