"""How long a table takes to become a run, by its length, beside plain pandas with the mcap library.

    python benchmarks/import_speed.py [--quick] [--repeats N] [--out benchmarks/RESULTS.md]

Tables have a time, three inputs that walk at random, and the coordinates of a marker; as a stream (`capture: {per:
segment}`) and with a column of captures, holds of 100 rows. The alternative reads the same CSV by pandas and writes
each row as a JSON message, and checks, segments and reads back nothing. Writes the section "Import" of the results.
"""

import argparse
import json
import os
import platform
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from labrig.bench._report import write_section
from labrig.log import import_table

SIZES = (45_000, 250_000, 1_000_000)
LIMIT_S = 20


def write_table(folder: Path, rows: int) -> None:
    """A CSV of a stream and one of holds, with their mappings."""
    rng = np.random.default_rng(0)
    walk = np.cumsum(rng.normal(size=(rows, 3)), axis=0)
    walk = 60 * (walk - walk.min(axis=0)) / np.ptp(walk, axis=0)
    held = np.repeat(rng.uniform(0, 60, (rows // 100 + 1, 3)), 100, axis=0)[:rows]
    for name, u, capture in (("stream", walk, {"per": "segment"}), ("holds", held, {"column": "n"})):
        frame = pd.DataFrame({"t": np.arange(rows) * 0.01, "n": np.arange(rows) // 100})
        frame[["p1", "p2", "p3"]] = u.round(4)
        frame[["x", "y", "z"]] = (u @ rng.normal(size=(3, 3)) + rng.normal(0, 0.1, (rows, 3))).round(4)
        frame.to_csv(folder / f"{name}.csv", index=False)
        mapping = {
            "table": f"{name}.csv",
            "capture": capture,
            "time": {"column": "t", "unit": "s"},
            "actuation": [{"column": c, "name": c, "unit": "kPa", "max": 60} for c in ("p1", "p2", "p3")],
            "observables": [
                {"column": a, "name": f"m.{a}", "unit": "mm", "marker": "m", "axis": a} for a in "xyz"
            ],
        }
        (folder / f"{name}.yaml").write_text(yaml.safe_dump(mapping), encoding="utf-8")


def plainly(table: Path, log: Path) -> None:
    """pandas and the mcap library: one JSON message for each row."""
    from mcap.writer import Writer

    frame = pd.read_csv(table)
    with log.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channel = writer.register_channel("/row", "json", writer.register_schema("row", "jsonschema", b"{}"))
        for row in frame.to_dict("records"):
            stamp = round(row["t"] * 1e9)
            writer.add_message(channel, stamp, json.dumps(row).encode(), stamp)
        writer.finish()


def median_s(work: Callable[[Path], object], folder: Path, repeats: int) -> tuple[float, float]:
    """How long a piece of work takes that makes a new file or folder, by the wall and of the processor; medians."""
    took = []
    for number in range(repeats):
        new = folder / f"{time.monotonic_ns()}-{number}"
        began = time.perf_counter(), time.process_time()
        work(new)
        took.append((time.perf_counter() - began[0], time.process_time() - began[1]))
    wall, processor = (statistics.median(each) for each in zip(*took, strict=True))
    return wall, processor


def measure(rows: int, repeats: int) -> str:
    """A row of the results."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write_table(folder, rows)
        stream = median_s(lambda new: import_table(folder / "stream.yaml", new), folder, repeats)
        holds = median_s(lambda new: import_table(folder / "holds.yaml", new), folder, repeats)
        plain = median_s(lambda new: plainly(folder / "stream.csv", new), folder, repeats)
    each = " | ".join(f"{wall:.1f} s, {processor:.1f} s" for wall, processor in (stream, holds, plain))
    return f"| {rows:,} | {each} | {1e6 * stream[1] / rows:.1f} µs | {stream[1] / plain[1]:.2f} |"


def main() -> None:
    """Measure, and write the section."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="the smallest table only")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "RESULTS.md")
    options = parser.parse_args()
    import_once()
    table = [measure(rows, options.repeats) for rows in (SIZES[:1] if options.quick else SIZES)]
    load = f"{os.getloadavg()[0]:.0f}" if hasattr(os, "getloadavg") else "unknown"
    below = [
        f"`python benchmarks/import_speed.py` on {platform.machine()}, {os.cpu_count()} cores with a load of {load}, "
        f"Python {platform.python_version()}; a CSV of a time, three inputs and a marker; "
        f"medians of {options.repeats}, first by the wall, then of the processor. "
        f"Asked for: 1,000,000 rows in {LIMIT_S} s, and linear.",
        "",
        "| rows | stream | holds of 100 rows | pandas and mcap | stream: each row | stream: pandas and mcap |",
        "|---|---|---|---|---|---|",
        *table,
        "",
        "\"pandas and mcap\" reads the stream's CSV and writes each row as a JSON message; labrig's time is that of "
        "checking, cutting, writing and opening the run. The last two columns are of the processor.",
    ]
    write_section(options.out, "## Import", below)
    print("\n".join(below))


def import_once() -> None:
    """Have everything imported before the clock runs."""
    with tempfile.TemporaryDirectory() as place:
        write_table(Path(place), 1000)
        import_table(Path(place) / "stream.yaml", Path(place) / "run")


if __name__ == "__main__":
    main()
