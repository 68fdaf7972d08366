"""The source paper's P7-P9, shapes that are asked for and realised, on the simulated torso: writes "Paper P7–P9".

    python benchmarks/paper_shapes.py [--bodies BODIES.npz] [--paper 24] [--out benchmarks/RESULTS.md]
    python benchmarks/paper.py P7 [--bodies BODIES.npz]    # the same

Uses what benchmarks/ik.py keeps in benchmarks/out/ik. Times are processor times of one core.
"""

import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parent))

import numpy as np
from _ik import search
from _ik.setup import Bench, asked_for

from labrig.bench._report import markdown, write_section
from labrig.campaign import run
from labrig.campaign._scans import keep_scan
from labrig.ik import outcomes
from labrig.rig import connect, load_rig
from labrig_drivers import Scan, SimulatedClock
from labrig_procedures import Validate

HEADING = "## Paper P7–P9"
REFINE = 3
P8_COLUMNS = ["target", "model", "predicted", "realised", "realised – predicted", "refined (scans more)"]


def main() -> None:
    """Run the three and write the section."""
    parser = asked_for(__doc__.splitlines()[0], "bodies for the paper's own search")
    given = parser.parse_args()
    measure(Bench(given.folder, given.bodies, given.workers), given.paper, given.out)


def measure(bench: Bench, paper: int, out: Path) -> None:
    """P7-P9, the paper's own search on `paper` bodies, into the section of the results in `out`."""
    bench.folder.mkdir(parents=True, exist_ok=True)
    every = bench.bodies()
    rows = [*p7(bench), *p9(bench, paper)]
    lines = [
        "`python benchmarks/paper_shapes.py`: shell `torso`, plant on a finer mesh with parameters 15 % off, model "
        f"with a warp learned from 40 captures; {len(every)} synthetic bodies (the paper: CAESAR scans, another rig). "
        "The paper's method is run beside labrig's, with the same model.",
        "",
        *markdown(["", "What", "The paper", "Its method, here", "labrig"], rows),
        "",
        f"P8, three bodies realised on the rig and scanned, mm: mean / 95 % / maximum; refined with at most {REFINE} "
        "scans more. The paper shows error maps; `labrig validate` draws the same.",
        "",
        *markdown(P8_COLUMNS, p8(bench)),
    ]
    write_section(out, HEADING, lines)


def p7(bench: Bench) -> list[list[str]]:
    """Progress on one target: steps, time a step, distance reached."""
    found = search.progress(bench.warped, bench.bodies(5)[2])
    words = {}
    for name, history in found.items():
        time_s, distance = np.array(history).T
        words[name] = (
            f"{len(history) - 1} steps, {1e3 * time_s[-1] / max(len(history) - 1, 1):.1f} ms each, "
            f"to {distance[-1]:.2f} mm"
        )
    return [
        [
            "P7",
            "progress on one target",
            "~15 steps, < 0.5 s each",
            words["paper"] + " rms",
            words["ours"] + " mean",
        ]
    ]


def p8(bench: Bench) -> list[list[str]]:
    """Three bodies, realised with and without the warp, and refined."""
    bodies = bench.bodies()
    rng = np.random.default_rng(8)
    model = bench.folder / "sim2real.pt"
    assert bench.warped is not None
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        targets = []
        for k in sorted(rng.choice(len(bodies), 3, replace=False)):
            kept = keep_scan(Scan(0.0, bodies[k].vertices_mm, bodies[k].triangles, (), ""), folder)[0]
            targets.append(str((folder / kept).rename(folder / f"body {k}.ply")))
        chosen = Validate(
            targets=tuple(targets), model=str(model), unit="mm", without=("warp",), refine=REFINE
        )
        clock = SimulatedClock(0.0)
        with connect(load_rig(bench.rig_file()), clock) as rig:
            run(chosen, rig, folder / "run", clock)
        rows = []
        for outcome in outcomes(folder / "run"):
            one = outcome.summary()
            refined = [again["realised_mm"]["mean"] for again in one["refined"]]
            best = min([one["realised_mm"]["mean"], *refined])
            rows.append(
                [
                    one["target"].removesuffix(".ply"),
                    one["model"],
                    *(
                        _three(one[key])
                        for key in ("predicted_mm", "realised_mm", "realised_against_predicted_mm")
                    ),
                    f"{best:.2f} ({len(refined)})" if refined else "",
                ]
            )
    return rows


def _three(values: dict[str, float]) -> str:
    return " / ".join(f"{values[key]:.2f}" for key in ("mean", "p95", "max"))


def p9(bench: Bench, count: int) -> list[list[str]]:
    """All bodies through inverse kinematics: average time; the paper's search on some of them."""
    model = bench.warped
    ours = search.side_by_side(model, bench.bodies(), False)
    times_ms = 1e3 * np.array(ours["ours_time_s"])
    both = search.side_by_side(model, bench.bodies(count))
    asked = len(both["paper_time_s"])
    longer = np.median(np.array(both["paper_time_s"]) / np.array(both["ours_time_s"]))
    paper = f"{np.mean(both['paper_time_s']):.2f} s on average ({asked} of them), {longer:.0f} times labrig's (median)"
    closer = np.mean(np.array(both["ours_mean_mm"]) < np.array(both["paper_mean_mm"]))
    distance = f"{np.mean(both['paper_mean_mm']):.2f} mm; labrig's are closer on {closer:.1%}"
    return [
        [
            "P9",
            f"time for {len(bench.bodies())} bodies, each",
            "7.98 s on average (100 bodies)",
            paper,
            f"{times_ms.mean():.1f} ms on average, median {np.median(times_ms):.1f} ms",
        ],
        [
            "",
            "distance of the model's surface, mean",
            "",
            distance,
            f"{np.mean(both['ours_mean_mm']):.2f} mm",
        ],
    ]


if __name__ == "__main__":
    main()
