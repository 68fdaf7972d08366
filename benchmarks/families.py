"""How much of its own laws each effect's family holds, beside what any changes of the pressures would: "Families".

    python benchmarks/families.py [--half sixth ...] [--n 140] [--seed 9400000] [--out benchmarks/RESULTS.md]

What a law changes, without noise, is fitted by each space of its effect under the shipped prior, and the best one
counts; and by free changes of all pressures, row by row. What is found by a scan is looked for in the change itself.
Where a family leaves a lot of a law, other families may hold the law better, and take its name. No verdict is asked.
"""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.bench import PORTIONS
from labrig.bench._learn import COUNTS_FOR, MISFIT, columns_of, drawn_change
from labrig.bench._report import write_section
from labrig.diagnosis._spectra import factor, prior_of
from labrig.effects import Context, Effect, Space, library, motion_scale

_FREE_ROWS = 240
_PORTIONS = ("development", *PORTIONS)
"""Nobody looks at the laws of the exam."""
_A_LOT = 0.1
Row = tuple[str, str, str, float, float]


def left_by_family(context: Context, effect: Effect, change: Floats) -> float:
    """What the best of an effect's spaces leaves of a change (F, K), a share, root mean square."""
    seen = replace(context, rows=replace(context.rows, values=context.base + change), _memo={})
    keep = np.unique(np.linspace(0, len(change) - 1, min(_FREE_ROWS, len(change))).astype(int))
    scale = motion_scale(context)
    y = np.nan_to_num(change)[keep] / scale
    y = y / np.sqrt((y**2).mean())
    J = (context.jacobian * context.span)[keep] / scale[None, :, None]
    return min((_left_by(space, y, J, keep, scale) for space in effect.family(seen)), default=1.0)


def _left_by(space: Space, y: Floats, J: Floats, keep: Ints, scale: Floats) -> float:
    """What one space leaves of a change (n, K) of unit size; its free patterns are fitted without a prior."""
    prior, columns = prior_of(space), columns_of(space, J, keep, scale)
    parts: list[Floats] = [columns["shared"] @ factor(prior.shared)]
    P = columns["pattern"]
    if "own" in columns:
        parts.append((columns["own"] @ factor(prior.own)).reshape(y.size, -1))

    def beside_patterns(values: Floats) -> Floats:
        return values - P @ np.linalg.lstsq(P, values, rcond=None)[0] if P.shape[1] else values

    left, X = beside_patterns(y).ravel(), np.concatenate(parts, axis=1)
    total = float((X**2).sum() / y.size)
    if total > 0:
        wide = X.shape[1]
        X = beside_patterns((X / np.sqrt(total)).reshape(len(y), -1)).reshape(y.size, wide)
        noise = MISFIT**2 * y.size / COUNTS_FOR
        left = left - X @ np.linalg.solve(X.T @ X / noise + np.eye(wide), X.T @ left / noise)
    return float(np.sqrt(np.mean(left**2)))


def left_by_pressures(context: Context, change: Floats) -> float:
    """What is left when each row may have any pressures, a share; nan where observables are no more than chambers."""
    scale = motion_scale(context)
    slopes, y = context.jacobian * context.span / scale[None, :, None], np.nan_to_num(change) / scale
    if slopes.shape[1] <= slopes.shape[2]:
        return float("nan")
    some = np.unique(np.linspace(0, len(y) - 1, min(_FREE_ROWS, len(y))).astype(int))
    left = [y[f] - slopes[f] @ np.linalg.lstsq(slopes[f], y[f], rcond=1e-8)[0] for f in some]
    return float(np.sqrt(np.mean(np.square(left)) / np.mean(y[some] ** 2)))


def one(half: str, seed: int) -> Row:
    """Effect, law and rig of a campaign, and what is left of its change."""
    truth, context, change = drawn_change(seed, half)
    (name,), (law,) = truth["effects"], truth["laws"]
    left = left_by_family(context, library()[name], change)
    return name, law, truth["rig"], left, left_by_pressures(context, change)


def table(rows: Sequence[Row]) -> list[str]:
    """A line for each effect: how many campaigns, medians, and the three laws of which most is left."""
    out = [
        "| effect | campaigns | left by the family, median | more than a tenth | by any pressures, median "
        "| most is left of |",
        "|---|---|---|---|---|---|",
    ]
    for effect in sorted({row[0] for row in rows}):
        own = [row for row in rows if row[0] == effect]
        laws = {law: float(np.median([r[3] for r in own if r[1] == law])) for law in {r[1] for r in own}}
        worst = sorted(laws, key=lambda law: -laws[law])[:3]
        free = [row[4] for row in own if np.isfinite(row[4])]
        any_of_them = f"{np.median(free):.3f} (of {len(free)})" if free else "-"
        said = ", ".join(f"{law} {laws[law]:.2f}" for law in worst)
        lost = sum(row[3] > _A_LOT for row in own)
        median = np.median([r[3] for r in own])
        out.append(f"| {effect} | {len(own)} | {median:.3f} | {lost} | {any_of_them} | {said} |")
    lost = sum(row[3] > _A_LOT for row in rows)
    out.append(f"| all | {len(rows)} | {np.median([r[3] for r in rows]):.3f} | {lost} | | |")
    return out


def main() -> None:
    """Draw, fit, print, and write the section."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--half", nargs="+", default=["sixth"], choices=_PORTIONS)
    parser.add_argument("--n", type=int, default=140, help="campaigns of each")
    parser.add_argument("--seed", type=int, default=9400000)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    rows = [one(half, given.seed + seed) for half in given.half for seed in range(given.n)]
    asked = f"--half {' '.join(given.half)} --n {given.n} --seed {given.seed}"
    how = (
        f"`python benchmarks/families.py {asked}`: shares of changes without noise, root mean square, that are left "
        "by the best space of the law's own effect."
    )
    lines = [how, "", *table(rows)]
    print("\n".join(lines))
    if given.out:
        write_section(given.out, "## Families", lines)


if __name__ == "__main__":
    main()
