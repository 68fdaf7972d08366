"""What the first shell and the first inverse kinematics on a computer wait for: compilation; and searches after that.

    python benchmarks/first_use.py [--against CHECKOUT] [--repeats 5] [--out benchmarks/RESULTS.md]

Processor time of one core, in processes of their own: once with nothing compiled yet, then in turn with what was kept.
`--against` is another checkout of labrig, which needs the same packages. Writes the section "First use" of the results.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import labrig
from labrig.bench._report import markdown, write_section
from labrig.physics import load_shell, simulate
from labrig.surrogate import save_model

HERE = Path(__file__).resolve().parents[1]
PACKAGES = ("", "drivers", "procedures", "logs_schema")
SHELL, NEAR, ANY = "a shape of a shell", "a search from near", "a search from any pose"
ASK = """
import json, sys, time
import numpy as np
from scipy.spatial.transform import Rotation
import labrig
from labrig.ik import solve
from labrig.physics import load_shell
from labrig.surface import Mesh, grid
from labrig.surrogate import load_model

assert labrig.__file__.startswith(sys.argv[2]), labrig.__file__

def took(work):
    began = time.process_time()
    work()
    return time.process_time() - began

shell = load_shell("membrane4")
model = load_model(sys.argv[1] + "/forward.pt")
random, (uv, triangles) = np.random.default_rng(1), grid(31, 31)
shapes = [model.points(random.uniform(5, 55, 4), uv)[0] for _ in range(15)]
turned = [p @ Rotation.random(random_state=k).as_matrix().T + 100.0 for k, p in enumerate(shapes)]
out = {"shell": [took(lambda: shell.solve(np.full(4, k + 5.0))) for k in range(4)]}
for name, points in (("near", shapes), ("any", turned)):
    out[name] = [took(lambda p=p: solve(Mesh(p, triangles), model)) for p in points]
print(json.dumps(out))
"""


def asked(checkout: Path, folder: Path, kept: Path) -> dict[str, list[float]]:
    """Seconds of each shape and each search of one process, the first of a kind first."""
    paths = os.pathsep.join(str(checkout / package) for package in PACKAGES)
    environment = os.environ | {"PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(kept), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-c", ASK, str(folder), str(checkout)]
    done = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def measured(checkouts: list[Path], folder: Path, repeats: int) -> dict[Path, dict[str, tuple[float, float]]]:
    """For each checkout the first and the later seconds (medians, all in turn) of each kind."""
    kept = {checkout: folder / f"kept{n}" for n, checkout in enumerate(checkouts)}
    first = {checkout: asked(checkout, folder, kept[checkout]) for checkout in checkouts}
    later: dict[Path, list[dict[str, list[float]]]] = {checkout: [] for checkout in checkouts}
    for _ in range(repeats):
        for checkout in checkouts:
            later[checkout].append(asked(checkout, folder, kept[checkout]))
    return {
        checkout: {
            kind: (seconds[0], statistics.median(s for run in later[checkout] for s in run[kind][1:]))
            for kind, seconds in first[checkout].items()
        }
        for checkout in checkouts
    }


def main() -> None:
    """Measure, and write the section."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--against", type=Path, help="another checkout, measured beside this one")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    checkouts = [HERE, *([given.against.resolve()] if given.against else [])]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        simulate(load_shell("membrane4").changed(count=(10, 10)), folder / "simulations", 40, workers=1)
        save_model(labrig.train_forward(folder / "simulations").model, folder / "forward.pt")
        found = measured(checkouts, folder, given.repeats)
    rows = []
    for kind, words in (("shell", SHELL), ("near", NEAR), ("any", ANY)):
        first = [f"{found[checkout][kind][0]:.1f} s" for checkout in checkouts]
        rows.append([words, *first, *(f"{1e3 * found[checkout][kind][1]:.1f} ms" for checkout in checkouts)])
    names = ["this version", "the other"][: len(checkouts)]
    head = ["", *(f"first, {n}" for n in names), *(f"later, {n}" for n in names)]
    beside = f" The other: commit {_commit(given.against)}." if given.against else ""
    how = (
        f"`python benchmarks/first_use.py` on {platform.machine()}, Python {platform.python_version()}: processor time "
        f"of one core, four chambers, one first time, medians of {given.repeats} processes in turn later.{beside}"
    )
    lines = [how, "", *markdown(head, rows)]
    print("\n".join(lines))
    if given.out:
        write_section(given.out, "## First use", lines)


def _commit(checkout: Path) -> str:
    command = ["git", "-C", str(checkout), "rev-parse", "--short", "HEAD"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


if __name__ == "__main__":
    main()
