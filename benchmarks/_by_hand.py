"""What the benchmarks of tables by hand share: their options, and shares with their intervals."""

import argparse
from pathlib import Path

from labrig.bench import wilson


def options(seeds: int, first: int) -> argparse.Namespace:
    """`--seeds`, `--first`, `--workers` and `--out` of the command line."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=seeds)
    parser.add_argument("--first", type=int, default=first)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("benchmarks/RESULTS.md"))
    return parser.parse_args()


def share(each: list[bool]) -> str:
    """How many of them, and the 95 % interval."""
    low, high = wilson(sum(each), len(each))
    return f"{sum(each)} of {len(each)} ({100 * low:.0f} to {100 * high:.0f} %)"
