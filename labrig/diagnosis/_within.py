"""The noise within holds: what rows of one hold differ by, whatever changes slowly along it."""

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.effects import Context

_MOST_ROWS = 6000
_EACH = 3
"""Independent differences that there must be for each coefficient of what changes along holds."""
_NORMAL = 1.4826
"""What the median of the sizes of normal numbers is multiplied by to give their standard deviation."""


def noise_within(context: Context, deviation: Floats, capture: Ints, at: Ints) -> float:
    """Noise (sd of a row) from deviations (R, k) of rows `at` (R,) from the means of their captures (R,); 0 if unknown.

    The lesser of two: what neighbouring rows bend by, which a straight line in them does not do; and what is left of
    them beside a straight line in time and one in its logarithm, as steep as the pressures, now and before, say. Three
    rows at 1, 3 and 8 s bend where a chamber leaks.
    """
    found = [
        _bends(deviation, capture, context.rows.hold_s[at]),
        _beside_slow(context, deviation, capture, at),
    ]
    return min((size for size in found if size > 0), default=0.0)


def _bends(deviation: Floats, capture: Ints, hold_s: Floats) -> float:
    """From second differences of neighbouring rows of a hold, or first ones where most holds have but two."""
    if len(deviation) < 2:
        return 0.0
    same = (capture[1:] == capture[:-1]) & (hold_s[1:] > hold_s[:-1])
    steps = np.diff(deviation, axis=0)
    both = same[1:] & same[:-1]
    enough = both.sum() >= same.sum() / 3
    bends, gain = ((steps[1:] - steps[:-1])[both], 6.0) if enough else (steps[same], 2.0)
    return _spread(bends) / np.sqrt(gain)


def _beside_slow(context: Context, deviation: Floats, capture: Ints, at: Ints) -> float:
    """From what pressures, now and before, times the time held leave; 0 where there are too few rows for it."""
    rows = context.rows
    seen = np.isfinite(deviation).all(axis=1) & np.isfinite(rows.hold_s[at])
    if not seen.any():
        return 0.0
    _, index = np.unique(capture[seen], return_inverse=True)
    step = -(-int(seen.sum()) // _MOST_ROWS)
    kept = index % step == 0
    at, left = at[seen][kept], deviation[seen][kept]
    _, index, count = np.unique(index[kept], return_inverse=True, return_counts=True)
    before = (context.previous / context.span)[rows.event[at]]
    now = rows.fraction[at]
    load = np.column_stack([np.ones(len(at)), now, now**2, before])
    held = np.column_stack([rows.hold_s[at], np.log1p(np.maximum(rows.hold_s[at], 0.0))])
    slow = (load[:, :, None] * held[:, None, :]).reshape(len(at), -1)
    slow = slow - _means(slow, index, count)[index]
    left = left - _means(left, index, count)[index]
    U, size, _ = np.linalg.svd(slow / np.maximum(np.linalg.norm(slow, axis=0), 1e-300), full_matrices=False)
    U = U[:, size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)]
    free = len(at) - len(count) - U.shape[1]
    if free < _EACH * max(U.shape[1], 1):
        return 0.0
    return _spread(left - U @ (U.T @ left)) * float(np.sqrt(len(at) / free))


def _means(values: Floats, index: Ints, count: Ints) -> Floats:
    """Means (n, q) of values (R, q) of each capture."""
    out = np.zeros((len(count), values.shape[1]))
    np.add.at(out, index, values)
    return out / count[:, None]


def _spread(values: Floats) -> float:
    """Their standard deviation, from the median of their sizes, which a few large ones do not move."""
    good = np.abs(values[np.isfinite(values)])
    return float(_NORMAL * np.median(good)) if len(good) else 0.0
