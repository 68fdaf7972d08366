"""How much of its own laws each effect's family holds, beside what any changes of the pressures would: "Families".

    python benchmarks/families.py [--half sixth] [--n 140] [--seed 9400000] [--out benchmarks/RESULTS.md]

What a law changes, without noise, is fitted by those spaces of its effect that act by the pressures and whose spectrum
is learnt (the best one counts; what acts in space, as planes and sags do, is in none of them), and by free changes of
all pressures, row by row. Where the second leaves next to nothing and the first a lot, the slopes are
good and the family is too narrow: then other families may hold the law better, and take its name. No verdict is asked.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from labrig.arrays import Floats
from labrig.bench._learn import drawn_change, example_of, left_by
from labrig.bench._report import write_section
from labrig.effects import Context, library, motion_scale

_FREE_ROWS = 240
Row = tuple[str, str, str, float, float]


def left_by_pressures(context: Context, change: Floats) -> float:
    """What is left when each row may have any pressures, a share; nan where observables are no more than chambers."""
    scale = motion_scale(context)
    slopes, y = context.jacobian * context.span / scale[None, :, None], np.nan_to_num(change) / scale
    if slopes.shape[1] <= slopes.shape[2]:
        return float("nan")
    some = np.unique(np.linspace(0, len(y) - 1, min(_FREE_ROWS, len(y))).astype(int))
    left = [y[f] - slopes[f] @ np.linalg.lstsq(slopes[f], y[f], rcond=1e-8)[0] for f in some]
    return float(np.sqrt(np.mean(np.square(left)) / np.mean(y[some] ** 2)))


def one(half: str, seed: int) -> Row | None:
    """Effect, law and rig of a campaign, and what is left of its change; None where no space acts by the pressures."""
    truth, context, change = drawn_change(seed, half)
    (name,), (law,) = truth["effects"], truth["laws"]
    example = example_of(context, library()[name], change, law)
    return example and (name, law, truth["rig"], left_by(example), left_by_pressures(context, change))


def table(rows: Sequence[Row]) -> list[str]:
    """A line for each effect: how many campaigns, medians, and the three laws of which most is left."""
    out = [
        "| effect | campaigns | left by the family, median | by any pressures, median | most is left of |",
        "|---|---|---|---|---|",
    ]
    for effect in sorted({row[0] for row in rows}):
        own = [row for row in rows if row[0] == effect]
        laws = {law: float(np.median([r[3] for r in own if r[1] == law])) for law in {r[1] for r in own}}
        worst = sorted(laws, key=lambda law: -laws[law])[:3]
        free = [row[4] for row in own if np.isfinite(row[4])]
        any_of_them = f"{np.median(free):.3f} (of {len(free)})" if free else "-"
        said = ", ".join(f"{law} {laws[law]:.2f}" for law in worst)
        out.append(
            f"| {effect} | {len(own)} | {np.median([r[3] for r in own]):.3f} | {any_of_them} | {said} |"
        )
    return out


def main() -> None:
    """Draw, fit, print, and write the section."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    halves = ("development", "third", "fourth", "fifth", "sixth")  # nobody looks at the laws of the exam
    parser.add_argument("--half", default="sixth", choices=halves)
    parser.add_argument("--n", type=int, default=140)
    parser.add_argument("--seed", type=int, default=9400000)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    rows = [row for seed in range(given.n) if (row := one(given.half, given.seed + seed)) is not None]
    command = f"`python benchmarks/families.py --half {given.half} --n {given.n} --seed {given.seed}`"
    how = (
        f"{command}: shares of changes without noise, root mean square, that are left by those spaces of the law's own "
        "effect that act by the pressures. Laws that act elsewhere (in space, on the frame) can't be held by these."
    )
    lines = [how, "", *table(rows)]
    print("\n".join(lines))
    if given.out:
        write_section(given.out, f"## Families, {given.half} portion", lines)


if __name__ == "__main__":
    main()
