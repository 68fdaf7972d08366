"""Fourteen plain laws as records without holds, every second one cut out of the middle: "Streams, plain laws".

    python benchmarks/stream_laws.py [--seeds 5] [--first 0] [--out benchmarks/RESULTS.md]

Each record is imported as a person would, with a static base, and diagnosed. A name is right where the law has it and
nothing else is named. The noise is a hundredth of the output's range.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

import labrig
from benchmarks._streams.laws import KINDS, LAWS, Law, driven
from benchmarks.streams import MAPPING
from labrig.bench import wilson
from labrig.bench._report import write_section

SAMPLES, CUT, NOISE = 1500, 200, 0.01
Row = tuple[Law, str, bool, bool, float]


def one(law: Law, number: int, seed: int) -> Row:
    """What is said of a record, whether that is right, whether a wrong name is sure, and the error by the noise."""
    random = np.random.default_rng([seed, number])
    u = driven(KINDS[(seed + number) % len(KINDS)], SAMPLES, random)
    y = law.output(u, law.sample_s)
    noise = NOISE * float(np.ptp(y))
    y = y + noise * random.normal(size=len(y))
    cut = int(random.integers(0, CUT)) if seed % 2 else 0
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = Path(name)
        table = {"t": law.sample_s * np.arange(SAMPLES - cut), "u": 50 * u[cut:], "y": y[cut:]}
        pd.DataFrame(table).to_csv(folder / "table.csv", index=False)
        (folder / "map.yaml").write_text(MAPPING.format(("input", law.units[0]), ("output", law.units[1])))
        (folder / "model.yaml").write_text(f"base: {{kind: static, degree: {law.degree}}}\n")
        run = labrig.import_table(folder / "map.yaml", folder / "run")
        found = labrig.diagnose(run, folder / "model.yaml")
    names = set(found.summary["effects"])
    right = names == law.right if law.all_of else names <= law.right and bool(names) == bool(law.right)
    sure = {e["effect"] for e in found.summary["effects_considered"] if e["call"] == "sure"}
    said = f"{found.verdict} {' + '.join(sorted(names))}".strip()
    print(law.name, seed, said, "" if right else "(not right)", flush=True)
    return law, said, right, bool(sure - law.right), found.error["model"] / noise


def table(rows: list[Row]) -> list[str]:
    """A line for each law, and the sums."""
    out = ["| law | right | a wrong name sure | error, parts of the noise | said |", "|---|---|---|---|---|"]
    for law in LAWS:
        own = [row for row in rows if row[0] is law]
        count = {said: sum(row[1] == said for row in own) for said in dict.fromkeys(row[1] for row in own)}
        words = "; ".join(f"{n} x {said}" for said, n in sorted(count.items(), key=lambda item: -item[1]))
        wrong, error = sum(row[3] for row in own), np.median([row[4] for row in own])
        out.append(
            f"| {law.name} | {sum(row[2] for row in own)} of {len(own)} | {wrong} | {error:.2g} | {words} |"
        )
    sums = []
    for column in (2, 3):
        many = sum(row[column] for row in rows)
        low, high = wilson(many, len(rows))
        sums.append(f"{many} of {len(rows)} ({100 * low:.0f} to {100 * high:.0f} %)")
    return [*out, "", f"Right: {sums[0]}. A wrong name sure: {sums[1]}."]


def main() -> None:
    """Measure and write the section."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("benchmarks/RESULTS.md"))
    asked = parser.parse_args()
    seeds = range(asked.first, asked.first + asked.seeds)
    rows = [one(law, number, seed) for number, law in enumerate(LAWS) for seed in seeds]
    command = f"`python benchmarks/stream_laws.py --first {asked.first} --seeds {asked.seeds}`"
    how = (
        f"{command}: {SAMPLES} samples of one input and one output, white noise of a hundredth of the range."
    )
    write_section(asked.out, "## Streams, plain laws", [how, "", *table(rows)])


if __name__ == "__main__":
    main()
