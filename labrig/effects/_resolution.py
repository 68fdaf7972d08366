"""The steps in which an observable was recorded."""

import numpy as np

from labrig.arrays import Floats, Ints

_LOOKED_AT = 5000  # values of an observable, for the step in which it was recorded
_ALIKE = 3  # so many values there must be for each different one
_OFF_GRID = 0.02


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
        steps = np.diff(seen)
        with np.errstate(
            over="ignore", invalid="ignore"
        ):  # of steps so small that there is no multiple of them
            multiple = steps / steps.min()
            off = np.abs(multiple - np.round(multiple)).max()
        if off < _OFF_GRID:
            out[k] = steps.min()
    return out


def levels_of(commanded: Floats, rows: int) -> Ints | None:
    """The number (captures * rows,) of each row's set-point; None where some chamber has many different ones."""
    different = max(len(np.unique(own)) for own in commanded.T)
    if different > len(commanded) / _ALIKE:
        return None
    return np.repeat(np.unique(commanded, axis=0, return_inverse=True)[1].reshape(-1), rows).astype(np.int64)
