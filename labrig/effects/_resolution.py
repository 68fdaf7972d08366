"""The steps in which an observable was recorded."""

import numpy as np

from labrig.arrays import Floats, Ints

_LOOKED_AT = 5000  # values of an observable, for the step in which it was recorded
_ALIKE = 3  # so many values there must be for each different one
_OFF_GRID = 0.02
_ROUGH = 0.3  # where the last digit is coarser, as a share of a step, the digit is all that can be said
_DIGITS, _EXACT = 7, 1e-6


def resolution_of(values: Floats, level: Ints | None = None) -> Floats:
    """The step of each observable's values (N, K): what all of them are a multiple of, where many are alike; else 0.

    `level` (N,) numbers the set-points, where they are few and return: what is the same at each of them, without any
    noise, is in steps because they are.
    """
    out = np.zeros(values.shape[1])
    for k, column in enumerate(values.T):
        known = np.flatnonzero(np.isfinite(column))
        known = known[:: max(1, len(known) // _LOOKED_AT)]
        own = column[known]
        seen, code = np.unique(own, return_inverse=True)
        if not 2 < len(seen) <= len(own) / _ALIKE:
            continue
        if level is not None:
            at = level[known]
            if len(np.unique(at * len(seen) + code)) == len(np.unique(at)):
                continue
        out[k] = _step_of(seen)
    return out


def _step_of(seen: Floats) -> float:
    """The step that different values (n,), in their order, are whole multiples of, but for the last digit with which
    they were written; what that digit stands for, where there is none.
    """
    steps = np.diff(seen)
    last = _last_digit(seen, float(steps.min()))
    with np.errstate(
        over="ignore", invalid="ignore", divide="ignore"
    ):  # of steps too small to have multiples
        least = steps[steps < 1.5 * steps.min()].mean()
        step = np.ptp(seen) / np.round(steps / least).sum()
        count = (seen - seen[0]) / step
        off = np.abs(count - np.round(count)).max()
        written = last / step
    return float(step) if off < _OFF_GRID or off < _OFF_GRID + written < _ROUGH else last


def _last_digit(values: Floats, least: float) -> float:
    """What the last digit of values stands for that differ by so much at least; nothing where they have more digits."""
    for digits in range(_DIGITS):
        one = 10.0**-digits
        if np.abs(values - one * np.round(values / one)).max() < _EXACT * least:
            return one
    return 0.0


def levels_of(commanded: Floats, rows: int) -> Ints | None:
    """The number (captures * rows,) of each row's set-point; None where some chamber has many different ones."""
    different = max(len(np.unique(own)) for own in commanded.T)
    if different > len(commanded) / _ALIKE:
        return None
    return np.repeat(np.unique(commanded, axis=0, return_inverse=True)[1].reshape(-1), rows).astype(np.int64)
