"""The source paper's experiments on the simulated rig, beside the paper's own figures.

    python benchmarks/paper.py [P1 ... P9 FORWARD] [--seeds 3] [--networks] [--simulations FOLDER] [--bodies BODIES.npz]
        [--out RESULTS.md]

P1-P6 need the `learn` extra. What was simulated, captured and measured is kept in benchmarks/out/paper and used
again; tables of the experiments that were run, now or before, go to the sections "Paper P1-P6" and "Forward model".
P7, P8 and P9 are one run, of paper_shapes.py.
"""

import argparse
import json
import os
import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parent))

import paper_shapes
from _ik.setup import Bench as ShapeBench
from _paper import fixed, forward
from _paper.rig import Bench

from labrig.bench._report import markdown, write_section

EXPERIMENTS: dict[str, Callable[[Bench, int], dict[str, Any]]] = {
    "P1": forward.p1,
    "P2": forward.p2,
    "P3": fixed.p3,
    "P4": fixed.p4,
    "P5": fixed.p5,
    "P6": fixed.p6,
    "FORWARD": forward.compare,
}
SHAPES = ("P7", "P8", "P9")
PAPERS_BODIES = 24
PAPER, MODEL = "## Paper P1–P6", "## Forward model"


def main() -> None:
    """Run the experiments that were asked for, and write what is known of all of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("experiments", nargs="*", default=[*EXPERIMENTS, *SHAPES])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--simulations", type=Path, help="a folder of labrig simulate, with --jacobians")
    parser.add_argument("--networks", action="store_true", help="FORWARD: labrig's network ensembles as well")
    parser.add_argument("--bodies", type=Path, help="P7-P9: a file with grid_mm (B, rows, columns, 3)")
    parser.add_argument("--folder", type=Path, default=Path("benchmarks/out/paper"))
    parser.add_argument("--out", type=Path, default=Path("benchmarks/RESULTS.md"))
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    bench = Bench(given.folder, given.workers, given.simulations, given.networks)
    asked = [name.upper() for name in given.experiments]
    if set(asked) & set(SHAPES):
        shapes = ShapeBench(given.folder.parent / "ik", given.bodies, given.workers)
        paper_shapes.measure(shapes, PAPERS_BODIES, given.out)
    for name in [name for name in asked if name not in SHAPES]:
        started = time.perf_counter()
        result = EXPERIMENTS[name](bench, given.seeds)
        result["seconds"] = round(time.perf_counter() - started, 1)
        (given.folder / f"{name}.json").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        print(f"{name}: {result['seconds']:.0f} s")
        for line in _lines(result):
            print(line)
    write(given.folder, given.out)


def write(folder: Path, out: Path) -> None:
    """Write the sections from what was measured so far."""
    known = {name: folder / f"{name}.json" for name in EXPERIMENTS}
    found = {name: json.loads(path.read_text("utf-8")) for name, path in known.items() if path.is_file()}
    about = [
        "`python benchmarks/paper.py`: plants are the shipped mannequin shell on 34 x 34 control points with every "
        "parameter changed by chance (15 %), models its nominal self on 30 x 30; captures and scans go through "
        "campaign and log.",
        "",
    ]
    parts = [name for name in found if name != "FORWARD"]
    pictures = out.parent / "pictures"
    pictures.mkdir(exist_ok=True)
    lines = []
    for name in parts:
        shutil.copyfile(folder / found[name]["picture"], pictures / f"paper-{found[name]['picture']}")
        lines += [*_lines(found[name]), "", f"![{name}](pictures/paper-{found[name]['picture']})", ""]
    if parts:
        write_section(out, PAPER, [*about, *lines[:-1]])
    if "FORWARD" in found:
        how = [
            "`python benchmarks/paper.py FORWARD`: 1,000 simulations of the mannequin shell, nine chambers.",
            "",
        ]
        write_section(out, MODEL, [*how, *_lines(found["FORWARD"])])


def _lines(result: dict[str, Any]) -> list[str]:
    title = [f"**{result['title']}**", ""] if result["title"] else []
    return [*title, *markdown(result["head"], result["rows"]), "", *result["notes"]]


if __name__ == "__main__":
    main()
