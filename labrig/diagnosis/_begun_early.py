"""Holds at whose end the body is on its way to the next set-point already: stamps of two clocks."""

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.diagnosis._score import jackknife_sd
from labrig.effects import Context, capture_means

_ROWS, _HOLDS = 3, 10
"""Rows of a hold, and such holds, from which on it can be told."""
_SHARE = 0.02
"""Of the way to the next set-point, from which on it is said."""
_SURE = 6.0
"""By how many standard errors it stands clear of nothing."""


def begun_early(context: Context, within: Floats) -> list[str]:
    """A line where what was measured goes towards the next set-point before it is commanded.

    What changes from the first half of a hold to its last row is explained by the way to this set-point, by the
    set-point itself, and by the way to the next, along the base's slopes; the standard error of the last is the
    jackknife's over holds. `within` (K,) is the noise within holds.
    """
    holds = list(_holds(context))
    if len(holds) < _HOLDS or not (within > 0).any():
        return []
    weight = np.where(within > 0, 1 / np.where(within > 0, within, 1.0), 0.0)
    end, sd = _share(context, holds, -1, weight)
    if end < max(_SHARE, _SURE * sd):
        return []
    before = f", from about {_since(context, holds, end, weight)} before on" if context.has_time else ""
    return [
        f"at the end of {len(holds)} holds what was measured has gone {100 * end:.0f} % of the way to the next "
        f"set-point, which is not commanded yet{before}: measurements are stamped too early, or commands too late (two "
        "clocks), or rows are in the hold before their own; put that right in the table and import it again"
    ]


def _holds(context: Context) -> list[tuple[Ints, int]]:
    """The rows of each hold that has several and is followed by another in its session, and the number of that."""
    rows, found = context.rows, []
    for own in np.split(np.arange(len(rows.capture)), np.flatnonzero(np.diff(rows.capture)) + 1):
        after = int(rows.event[own[-1]]) + 1 if len(own) >= _ROWS else len(rows.event_session)
        if after < len(rows.event_session) and rows.event_session[after] == rows.session[own[0]]:
            found.append((own, after))
    return found


def _share(context: Context, holds: list[tuple[Ints, int]], row: int, weight: Floats) -> tuple[float, float]:
    """Which share of the way to the next set-point is gone at a row of the holds' second halves, and its sd."""
    grams, products = np.zeros((len(holds), 3, 3)), np.zeros((len(holds), 3))
    for i, (own, after) in enumerate(holds):
        half = len(own) // 2
        first, _ = capture_means(context.residual[own[:half]], np.zeros(half, dtype=int))
        change = context.residual[own[half:][row]] - first[0]
        seen = np.isfinite(change) & (weight > 0)
        now = context.rows.actuation[own[0]]
        before = context.previous[context.rows.event[own[0]]]
        ways = np.stack([now, now - before, context.rows.event_actuation[after] - now], axis=1)
        X = (context.jacobian[own[0]] @ ways)[seen] * weight[seen, None]
        grams[i], products[i] = X.T @ X, X.T @ (change * weight)[seen]
    total, target = grams.sum(axis=0), products.sum(axis=0)
    whole = np.linalg.pinv(total, rcond=1e-9, hermitian=True) @ target
    without = np.linalg.pinv(total - grams, rcond=1e-9, hermitian=True) @ (target - products)[..., None]
    return float(whole[2]), float(jackknife_sd(without[:, 2, 0]))


def _since(context: Context, holds: list[tuple[Ints, int]], end: float, weight: Floats) -> str:
    """For how long it goes on, in words: from the first row at which half of that share is gone."""
    fewest = min(len(own) - len(own) // 2 for own, _ in holds)
    row = -1
    while row > -fewest and _share(context, holds, row - 1, weight)[0] > end / 2:
        row -= 1
    starts = context.rows.event_time_s
    gaps = [float(starts[after] - context.rows.time_s[own[row]]) for own, after in holds]
    return f"{np.nanmedian(gaps):.2g} s"
