"""The noise within holds: what rows of one hold differ by, whatever changes slowly along it."""

import numpy as np

from labrig._linalg import sums_of
from labrig.arrays import Floats, Ints
from labrig.diagnosis._uneven import profile, spread
from labrig.effects import Context

_MOST_ROWS = 6000
"""Rows that are looked at: of more, whole holds at even distances; numerical."""
_ROUNDS = 4
"""Rounds in which what was not seen is filled; numerical."""
_NO_MORE = 1.25
"""What is left beside slow changes, as a part of the lesser of the two, up to which it is noise alone."""
_TAILS = 3.0
"""How many times the usual size a row counts for at most: of a normal distribution three of a thousand are larger."""
_EACH = 3
"""Independent differences that there must be for each coefficient of what changes along holds."""


def noise_within(context: Context, deviation: Floats, capture: Ints, at: Ints, groups: list[Ints]) -> Floats:
    """Noise (sd of a row) of each observable (k,), from deviations (R, k) of rows `at` (R,) from the means of their
    captures (R,); 0 if unknown. `groups` are those that may have more or less of it together.

    The lesser of two: what neighbouring rows bend by, which a straight line in them does not do; and what is left of
    them beside a straight line in time and one in its logarithm, as steep as the pressures, now and before, say. Three
    rows at 1, 3 and 8 s bend where a chamber leaks. How uneven it is only what is left says, where that is no more than
    what bends: a chamber that leaks bends the markers above it.
    """
    left, free = _beside_slow(context, deviation, capture, at)
    found = [_bends(deviation, capture, context.rows.hold_s[at]), left]
    sizes = [(size, values) for values in found if (size := spread(values)) > 0]
    if not sizes:
        return np.zeros(deviation.shape[1])
    least, values = min(sizes, key=lambda one: one[0])
    each = np.ones(deviation.shape[1])
    if free and spread(left) < _NO_MORE * least:
        each = profile(left, free, groups)
    return _with_tails(values / each) * each


def _with_tails(values: Floats) -> float:
    """Their standard deviation, rows that are much larger than most among them, as captures' means have them, too;
    none counts for more than three times what most are (P. J. Huber, Ann. Math. Statist. 35 (1964) 73).
    """
    most = _TAILS * spread(values)
    return float(np.sqrt(np.nanmean(np.clip(values, -most, most) ** 2))) if most > 0 else 0.0


def _bends(deviation: Floats, capture: Ints, hold_s: Floats) -> Floats:
    """Second differences of neighbouring rows of a hold, or first ones where most holds have but two, of unit gain."""
    if len(deviation) < 2:
        return deviation[:0]
    same = (capture[1:] == capture[:-1]) & (hold_s[1:] > hold_s[:-1])
    steps = np.diff(deviation, axis=0)
    both = same[1:] & same[:-1]
    enough = both.sum() >= same.sum() / 3
    bends, gain = ((steps[1:] - steps[:-1])[both], 6.0) if enough else (steps[same], 2.0)
    return bends / np.sqrt(gain)


def _beside_slow(context: Context, deviation: Floats, capture: Ints, at: Ints) -> tuple[Floats, int]:
    """What pressures, now and before, times the time held leave, of the noise's size, and how many numbers of each
    observable that is; none where rows are too few for the pressures now.
    """
    none = deviation[:0], 0
    rows = context.rows
    use = np.isfinite(deviation).any(axis=1) & np.isfinite(rows.hold_s[at])
    if not use.any():
        return none
    _, index = np.unique(capture[use], return_inverse=True)
    step = -(-int(use.sum()) // _MOST_ROWS)
    kept = index % step == 0
    at, left = at[use][kept], deviation[use][kept]
    _, index, count = np.unique(index[kept], return_inverse=True, return_counts=True)
    before = (context.previous / context.span)[rows.event[at]]
    now = rows.fraction[at]
    held = np.column_stack([rows.hold_s[at], np.log1p(np.maximum(rows.hold_s[at], 0.0))])
    held = held - _means(held, index, count)[index]
    for loads in ((now, now**2, before), (now, now**2), (now,)):
        load = np.column_stack([np.ones(len(at)), *loads])
        U = _span((load[:, :, None] * held[:, None, :]).reshape(len(at), -1))
        free = len(at) - len(count) - U.shape[1]
        if free >= _EACH * max(U.shape[1], 1):
            break
    else:
        return none
    seen = np.isfinite(left)
    made = np.zeros_like(left)
    for _ in range(1 if seen.all() else _ROUNDS):  # what was not seen is as it would be
        made = U @ (U.T @ np.where(seen, left, made))
    return np.where(seen, left - made, np.nan) * np.sqrt(len(at) / free), free


def _span(columns: Floats) -> Floats:
    """An orthonormal basis (R, r) of columns (R, q)."""
    U, size, _ = np.linalg.svd(
        columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300), full_matrices=False
    )
    return U[:, size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)]


def _means(values: Floats, index: Ints, count: Ints) -> Floats:
    """Means (n, q) of values (R, q) of each capture."""
    return sums_of(index, values, len(count)) / count[:, None]
