"""What is left on a fresh programme once the right name is added: what formulas and weights cost, not the naming.

    python benchmarks/named.py [--seed 99510000] [--n 60] [--class single] [--halves eighth,ninth,tenth,eleventh]

Blind campaigns whose effects are added by their true names; nothing is diagnosed. The drop is the benchmark's: the
share of the error on a programme of its own that goes, of all that is no noise. Effects that are another in each
session, and campaigns in which nothing was to be won, are left out. A row of a table is printed, and one by effect.
"""

import argparse
from collections import defaultdict
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from labrig._errors import LabrigError
from labrig.bench._draw import draw
from labrig.bench._files import write_model
from labrig.bench._intervals import bootstrap, wilson
from labrig.bench._run import _TIED_TO_A_SESSION, _fresh
from labrig.diagnosis import improve
from labrig.model import Model

ENOUGH = 0.85


def drop(name: str, seed: int, half: str) -> tuple[str, float, list[str]] | None:
    """The effects of one campaign, the drop with them, and the forms that they got; None where it says nothing."""
    campaign = draw(name, seed, half)
    effects = campaign.truth["effects"]
    if set(effects) & set(_TIED_TO_A_SESSION) or campaign.base is None:
        return None
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        path = write_model(campaign, Path(folder))
        try:
            improved = improve(campaign.dataset, Model.load(path), effects, force=True).improved
        except LabrigError:
            return " and ".join(effects), 0.0, []
        fresh = _fresh(campaign, path, improved)
    if fresh is None or fresh["drop"] is None or improved is None:
        return None
    return " and ".join(effects), fresh["drop"], [entry.form or "" for entry in improved.file.effects]


def row(name: str, drops: list[float]) -> str:
    """One row of the table, with 95 % intervals."""
    low, high = bootstrap(drops, lambda of: float(np.percentile(of, 10)))
    tenth, first, middle = np.percentile(drops, (10, 25, 50))
    enough = sum(d >= ENOUGH for d in drops)
    least, most = wilson(enough, len(drops))
    return (
        f"| {name} | {len(drops)} | {tenth:.2f} ({low:.2f} to {high:.2f}) | {first:.2f} | {middle:.2f} "
        f"| {enough} | {100 * least:.0f}-{100 * most:.0f} % |"
    )


def main() -> None:
    """Draw, add, and print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=99_510_000)
    parser.add_argument("--n", type=int, default=60)
    parser.add_argument("--class", dest="name", default="single")
    parser.add_argument("--halves", default="eighth,ninth,tenth,eleventh")
    args = parser.parse_args()
    tasks = [(s, h) for h in args.halves.split(",") for s in range(args.seed, args.seed + args.n)]
    found = [one for seed, half in tasks if (one := drop(args.name, seed, half)) is not None]
    by_effect = defaultdict(list)
    for effects, value, _ in found:
        by_effect[effects].append(value)
    print("| | campaigns | tenth percentile | first quartile | median | at least 0.85 | 95 % |")
    print("|---|---|---|---|---|---|---|")
    print(row("all", [value for _, value, _ in found]))
    if args.name != "pair":
        for effects in sorted(by_effect):
            print(row(effects, by_effect[effects]))
    weighted = sum(any(form.startswith("family, ") for form in forms) for _, _, forms in found)
    print(f"\nby a family's weights: {weighted} of {len(found)}")


if __name__ == "__main__":
    main()
