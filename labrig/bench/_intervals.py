"""How sure a figure is: 95 % intervals of shares, of differences of shares, and of anything by resampling."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from labrig.bench.records import Figure

_RESAMPLES = 1000


def wilson(successes: int, trials: int, z: float = 1.96) -> tuple[float, float]:
    """95 % interval of a share (Wilson 1927)."""
    if trials == 0:
        return 0.0, 1.0
    share = successes / trials
    middle = (share + z * z / (2 * trials)) / (1 + z * z / trials)
    half = z * np.sqrt(share * (1 - share) / trials + z * z / (4 * trials**2)) / (1 + z * z / trials)
    return max(0.0, float(middle - half)), min(1.0, float(middle + half))


def newcombe(successes: int, trials: int, others: int, of: int) -> tuple[float, float]:
    """95 % interval of successes/trials - others/of (Newcombe 1998, method 10: square and add Wilson's intervals)."""
    if not trials or not of:
        return -1.0, 1.0
    p, q = successes / trials, others / of
    low_p, high_p = wilson(successes, trials)
    low_q, high_q = wilson(others, of)
    below = float(np.hypot(p - low_p, high_q - q))
    above = float(np.hypot(high_p - p, q - low_q))
    return p - q - below, p - q + above


def bootstrap(values: Sequence[Any], figure: Callable[[list[Any]], float]) -> tuple[float, float]:
    """95 % interval of a figure of independent values: percentiles over values drawn again with replacement."""
    random = np.random.default_rng(0)
    if not len(values):
        return float("nan"), float("nan")
    found = [
        figure([values[k] for k in random.integers(len(values), size=len(values))]) for _ in range(_RESAMPLES)
    ]
    low, high = np.percentile(found, [2.5, 97.5])
    return float(low), float(high)


def share(successes: int, trials: int) -> Figure | None:
    """A share as figures have it: {value, low, high, count, of}; None of nothing."""
    if not trials:
        return None
    low, high = wilson(successes, trials)
    return {"value": successes / trials, "low": low, "high": high, "count": successes, "of": trials}


def share_text(count: int, of: int) -> str:
    """How many of how many, with the 95 % interval: `28 of 29 (83 to 99 %)`."""
    low, high = wilson(count, of)
    digits = 0 if of < 200 else 1
    return f"{count} of {of} ({100 * low:.{digits}f} to {100 * high:.{digits}f} %)"
