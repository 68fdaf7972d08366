"""How long runs take to be listed: with the index, after a change, the first time, and by opening every log.

    python benchmarks/catalogue.py [--quick] [--out benchmarks/RESULTS.md]

The runs are small (3 captures, 30 frames, 60 kB), so that thousands of them are soon made; a larger log takes longer to
open, and as long to list. Each command is a process of its own. Writes the section "Catalogue of runs" of the results.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import yaml

from labrig.bench._report import write_section
from labrig.catalogue import INDEX, list_runs, tag
from labrig.log import Layout, LogWriter, Topic, find_runs, run_id, summarise
from labrig_drivers import MarkerFrame
from labrig_schema.step_pb2 import Step

MARKERS, FRAMES, CAPTURES = 34, 30, 3
LARGE_FRAMES = 30_000
REPEATS = 5
LIMIT_S = {1_000: "at most 1 s", 10_000: "at most 3 s"}
VERDICTS = ("identified", "nothing_missing", "confounded", "unknown")
WHERE = "verdict == 'identified' and rig == 'rig 2' and error > 2 * floor"


def write_run(folder: Path, number: int, frames: int = FRAMES) -> None:
    """A run of its own numbers, with its run.yaml."""
    folder.mkdir(parents=True)
    names = tuple(f"m{m}" for m in range(MARKERS))
    start_s = 1.75e9 + 1000.0 * number
    layout = Layout(("c1", "c2"), (0.0, 0.0), (60.0, 60.0), markers=names, start_s=start_s)
    day = f"2026-{number // 28 % 12 + 1:02d}-{number % 28 + 1:02d}T08:00:00+00:00"
    run: dict[str, Any] = {"procedure": "capture", "captures": CAPTURES, "started": day, "operator": "ada"}
    run |= {"rig": {"name": f"rig {number % 4}"}, "seed": number}
    writer = LogWriter(folder / "log.000.mcap", layout, run)
    position_mm = np.random.default_rng(number).normal(size=(frames, MARKERS, 3))
    status = np.ones(MARKERS, np.int8)
    for row in range(frames):
        writer.frame(MarkerFrame(start_s + 0.1 * row, row, position_mm[row], status))
    for capture in range(CAPTURES):
        writer.write(Topic.STEP, start_s + 3.0, index=capture, kind="record", state=Step.DONE, step_json="{}")
    writer.close("completed")
    (folder / "run.yaml").write_text(yaml.safe_dump(run), encoding="utf-8")


def write_runs(folder: Path, count: int) -> None:
    """Runs with a diagnosis each, and with tags for one in fifty."""
    with mock.patch("os.fsync"):
        for number in range(count):
            run = folder / f"{number:05d}-capture"
            write_run(run, number)
            found = {
                "verdict": VERDICTS[number % 4],
                "error": {"base": 1.0, "floor": 0.1 * (number % 9)},
                "units": "mm",
                "runs": [{"run": str(run), "id": run_id(run)}],
                "model": "model.yaml",
            }
            (run / "diagnosis.json").write_text(json.dumps(found), encoding="utf-8")
            if number % 50 == 0:
                tag(run, ["good"])


def typed_s(*words: str) -> float:
    """How long a command takes, from its first to its last moment; median of several."""
    took = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        subprocess.run([sys.executable, "-m", "labrig", *words], check=True, stdout=subprocess.DEVNULL)
        took.append(time.perf_counter() - began)
    return statistics.median(took)


def timed_s(work: Any) -> float:
    """How long a call takes."""
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def grow(folder: Path, count: int) -> None:
    """Append a few bytes to the logs of the first runs, as a run that goes on does."""
    for path in find_runs(folder)[:count]:
        with (path / "log.000.mcap").open("ab") as file:
            file.write(b"\x00" * 9)


def measure(folder: Path, count: int) -> str:
    """A row of the table for so many runs."""
    write_runs(folder, count)
    opened_s = timed_s(lambda: [summarise(path) for path in find_runs(folder)])
    first_s = timed_s(lambda: list_runs(folder))
    listed_s = typed_s("runs", str(folder))
    filtered_s = typed_s("runs", str(folder), "--where", WHERE)
    called_s = statistics.median(timed_s(lambda: list_runs(folder)) for _ in range(REPEATS))
    grow(folder, 10)
    changed_s = timed_s(lambda: list_runs(folder))
    size_mb = (folder / INDEX).stat().st_size / 1e6
    return (
        f"| {count:,} | {listed_s:.2f} s | {LIMIT_S.get(count, '')} | {filtered_s:.2f} s | {called_s:.2f} s | "
        f"{changed_s:.2f} s | {first_s:.1f} s | {opened_s:.1f} s | {opened_s / called_s:.0f} | {size_mb:.1f} MB |"
    )


def main() -> None:
    """Measure, print and write the section."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="200 runs only; changes no results")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "RESULTS.md")
    options = parser.parse_args()
    lines = [
        f"`python benchmarks/catalogue.py` on {platform.machine()}, {os.cpu_count()} cores, "
        f"Python {platform.python_version()}; small logs ({CAPTURES} captures, {FRAMES} frames of {MARKERS} markers), "
        "a diagnosis for each.",
        "",
        "| runs | `labrig runs` | asked for | with `--where` | in Python | after 10 logs grew | first time "
        "| every log opened | that: in Python | index |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    with tempfile.TemporaryDirectory() as name:
        for count in (200,) if options.quick else LIMIT_S:
            lines.append(measure(Path(name) / str(count), count))
        write_run(Path(name) / "large", 0, LARGE_FRAMES)
        large_s = statistics.median(timed_s(lambda: summarise(Path(name) / "large")) for _ in range(REPEATS))
        large_mb = (Path(name) / "large" / "log.000.mcap").stat().st_size / 1e6
    lines += [
        "",
        "The command is a process of its own, whose start is in its time; medians of five. Listing does not depend on "
        f"how large the logs are, opening does: one of {LARGE_FRAMES:,} frames ({large_mb:.0f} MB) takes "
        f"{1000 * large_s:.0f} ms, so that 1,000 of them take {1000 * large_s:.0f} s.",
    ]
    print("\n".join(lines))
    if not options.quick:
        write_section(options.out, "## Catalogue of runs", lines)


if __name__ == "__main__":
    main()
