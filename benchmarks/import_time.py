"""How long `import labrig` takes, beside `import numpy`, and how long `labrig --help` and the workbench's server do.

    python benchmarks/import_time.py [--quick] [--out benchmarks/RESULTS.md]

Each is a process of its own, in turn, so that what else the computer does falls on all of them; the time is the
import's own, by the process's clock, with the files in the system's cache. Writes the section "Import" of the results.
"""

import argparse
import os
import platform
import statistics
import subprocess
import sys
from pathlib import Path

from labrig.bench._report import write_section

REPEATS = 15
LIMIT_S = {"`import labrig`": "at most 0.15 s", "`labrig --help`": "at most 0.3 s"}
CODE = "import time; began = time.perf_counter(); {work}; print(time.perf_counter() - began)"
HELP = """
import time; began = time.perf_counter()
import contextlib, io
from labrig.cli import main
with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
    main(["--help"])
print(time.perf_counter() - began)
"""
WORKBENCH = """
import time; began = time.perf_counter()
import tempfile, urllib.request
from pathlib import Path
from labrig.workbench import open_desk, start
with tempfile.TemporaryDirectory() as folder:
    running = start(open_desk(Path(folder)), port=0)
    asked = urllib.request.Request(running.address.partition("?")[0] + "api/runs")
    asked.add_header("x-labrig-token", running.desk.token)
    urllib.request.urlopen(asked).read()
    took_s = time.perf_counter() - began
    running.stop()
print(took_s)
"""
WORK = {
    "`import labrig`": CODE.format(work="import labrig"),
    "`import labrig`, then `dir` and a first use (`labrig.LabrigError`)": CODE.format(
        work="import labrig; dir(labrig); labrig.LabrigError"
    ),
    "`import labrig; labrig.open_run` (xarray and numpy with it)": CODE.format(
        work="import labrig; labrig.open_run"
    ),
    "`labrig --help`": HELP,
    "`labrig workbench`, until it answers": WORKBENCH,
    "`import numpy`": CODE.format(work="import numpy"),
}
ALTERNATIVE = "`import numpy`"


def took_s(code: str) -> float:
    """What a new process says that its work took."""
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return float(ran.stdout.splitlines()[-1])


def main() -> None:
    """Measure, print and write the section."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="three of each; changes no results")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "RESULTS.md")
    options = parser.parse_args()
    repeats = 3 if options.quick else REPEATS
    for code in WORK.values():
        took_s(code)  # from the disk
    times: dict[str, list[float]] = {name: [] for name in WORK}
    for _ in range(repeats):
        for name, code in WORK.items():
            times[name].append(took_s(code))
    medians = {name: statistics.median(each) for name, each in times.items()}
    load = f" (load average {os.getloadavg()[0]:.1f})" if hasattr(os, "getloadavg") else ""
    lines = [
        f"`python benchmarks/import_time.py` on {platform.machine()}, {os.cpu_count()} cores{load}, "
        f"Python {platform.python_version()}; medians of {repeats} processes each, in turn.",
        "",
        "| What | median | slowest | of `import numpy` | asked for |",
        "|---|---|---|---|---|",
    ]
    lines += [
        f"| {name} | {medians[name]:.3f} s | {max(times[name]):.3f} s | {medians[name] / medians[ALTERNATIVE]:.2f} | "
        f"{LIMIT_S.get(name, '')} |"
        for name in WORK
    ]
    print("\n".join(lines))
    if not options.quick:
        write_section(options.out, "## Importing labrig", lines)


if __name__ == "__main__":
    main()
