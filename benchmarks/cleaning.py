"""What the cleaning of a campaign takes: mistaken values, which it should, and parts of an effect, which it should not.

    python benchmarks/cleaning.py [--seed 7000000] [--n 15] [--class single] [--halves development,third,fourth,fifth]

Blind campaigns of the development half, of which it is known what was hidden and what was mistaken. Nothing is
diagnosed. A value is mistaken where it is `WILD` noises away from what base and hidden effect say.
"""

import argparse
from pathlib import Path
from statistics import mean, median
from tempfile import TemporaryDirectory

import numpy as np
from _hidden import at_rows

from labrig.bench._draw import draw
from labrig.bench._files import write_model
from labrig.diagnosis._outliers import clean
from labrig.effects import rows_of
from labrig.model import Model

WILD = 12.0


def taken(name: str, seed: int, half: str) -> dict[str, float]:
    """Of one campaign: the share of the effect's square that goes, and how many mistakes there were, and stay."""
    campaign = draw(name, seed, half)
    truth = campaign.truth
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        context = Model.load(write_model(campaign, Path(folder))).context(rows_of(campaign.dataset))
    effect, residual = at_rows(campaign, np.sum(list(campaign.parts.values()), axis=0)), context.residual
    cleaned, dropped = clean(context)
    seen, gone = np.isfinite(residual), np.isfinite(residual) & np.isnan(cleaned)
    noise = np.hypot(truth["spoil"]["row"], truth["spoil"]["capture"])
    wild = seen & (np.abs(residual - effect) > WILD * noise + 3 * truth["structural"])
    return {
        "lost": float(np.sum(effect[gone] ** 2) / max(np.sum(effect[seen] ** 2), 1e-300)),
        "wild": int(wild.sum()),
        "stay": int((wild & ~gone).sum()),
        "dropped": dropped,
        "values": int(seen.sum()),
    }


def main() -> None:
    """Draw, clean, and print one row of a table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=7_000_000)
    parser.add_argument("--n", type=int, default=15)
    parser.add_argument("--class", dest="name", default="single")
    parser.add_argument("--halves", default="development,third,fourth,fifth")
    args = parser.parse_args()
    found = [
        taken(args.name, seed, half)
        for half in args.halves.split(",")
        for seed in range(args.seed, args.seed + args.n)
    ]
    lost = [f["lost"] for f in found]
    print(
        "| campaigns | effect lost, mean | more than 5 % lost | mistakes | of them kept | in campaigns | dropped |"
    )
    print("|---|---|---|---|---|---|---|")
    print(
        f"| {len(found)} | {mean(lost):.2%} (median {median(lost):.2%}) | {sum(s > 0.05 for s in lost)} "
        f"| {sum(f['wild'] for f in found)} | {sum(f['stay'] for f in found)} "
        f"| {sum(f['stay'] > 0 for f in found)} | {sum(f['dropped'] for f in found)} "
        f"of {sum(f['values'] for f in found)} |"
    )


if __name__ == "__main__":
    main()
