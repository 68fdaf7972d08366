"""Columns of numbers that stand still in holds, and those that tremble."""

import numpy as np

from labrig.arrays import Floats

_STILL = 1 / 3
"""Share of rows that are exactly as the row before from which on a column stands still in holds."""
_JUMP = 0.03
"""Of a column's range: what is more is a jump, not the rounding of a slow motion."""
_NOISY = 0.4


def is_held(values: Floats) -> bool:
    """Whether numbers (n,) stand exactly still in holds, or always."""
    seen = seen_of(values)
    if len(seen) < 3:
        return False
    step = np.abs(np.diff(seen))
    moved = step[step > 0]
    return not len(moved) or bool(
        len(moved) <= (1 - _STILL) * len(step) and np.median(moved) > _JUMP * np.ptp(seen)
    )


def is_steps(values: Floats) -> bool:
    """Whether numbers (n,) mostly stay as they are from row to row."""
    return len(values) > 1 and float((np.diff(values) == 0).mean()) > 0.5


def is_noisy(values: Floats) -> bool:
    """Whether numbers (n,) tremble: their second differences change sign at random, and they are not held.

    A ramp that was rounded is not: its second differences are no more than the last digit that was written.
    """
    seen = seen_of(values)
    if len(seen) < 8 or is_held(seen):
        return False
    second = np.diff(seen, n=2)
    second[np.abs(second) < 1.5 * last_digit(seen)] = 0.0
    products = second[1:] * second[:-1]
    told = products[products != 0]
    return len(told) > 8 and bool((told < 0).mean() > _NOISY)


def is_exact(values: Floats) -> bool:
    """Whether numbers (n,) move and do not tremble, or come again to the last digit, as set-points of one row each."""
    seen = seen_of(values)
    again = len(seen) > 2 and 1 < len(np.unique(seen)) <= len(seen) / 2
    return again or (len(seen) > 2 and bool(np.ptp(seen) > 0) and not is_noisy(values))


def last_digit(seen: Floats) -> float:
    """The size of the last decimal digit that numbers (n,) were written with; 0 where they have more than six."""
    digits = (d for d in range(7) if np.allclose(seen, np.round(seen, d), rtol=0, atol=1e-9))
    return 10.0 ** -next(digits, np.inf)


def seen_of(values: Floats) -> Floats:
    """The numbers of a column (n,) without its gaps."""
    return values[np.isfinite(values)]
