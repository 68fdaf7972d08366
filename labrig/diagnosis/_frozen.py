"""Markers that stand still to the last digit: a tracker that lost one may go on to report its last place."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.diagnosis._listed import in_captures
from labrig.effects import Context, whole_markers

_BY_CHANCE = 1e-3
"""Runs of equal places that a whole campaign may have by chance: values in steps are alike now and then."""
_TOGETHER = 0.5
"""Share of the markers that stand still at once from which on nothing is said of one: there may be no noise at all."""
_MOVES = 0.05
"""Share of the farthest that the model moves any marker below which one may well stand still."""
_NAMED = 4
"""How many markers are named."""
_ENDS = ((np.min, np.inf), (np.max, -np.inf))


def without_frozen(context: Context) -> Context:
    """The campaign without the rows in which a marker still is exactly where it was; the rows' warnings name them."""
    rows = context.rows
    place = whole_markers(rows)
    if len(place) < 2 or len(rows.capture) < 3:
        return context
    markers = rows.marker[place[:, 0]]
    moves = np.linalg.norm(np.ptp(context.base[:, place], axis=0), axis=1)
    told = moves > _MOVES * moves.max()
    seen = rows.values[:, place]
    if len(rows.resolution):  # what is recorded in steps stands still as long as it moves by less
        step, changes = rows.resolution[place], np.abs(np.diff(seen, axis=0))
        changes[:, ~np.isfinite(changes).any(axis=0)] = 0.0
        usual = np.nanmedian(changes, axis=0)
        coarse = ((step > 0) & (step >= usual)).any(axis=1)
        told &= ~coarse
    stale = _stale(seen, context.base[:, place]) & told
    if not (len(rows.resolution) and coarse.any()):
        stale |= _for_ever(seen)
    if not stale.any():
        return context
    values, said = rows.values.copy(), []
    for m, own in enumerate(place):
        values[np.ix_(stale[:, m], own)] = np.nan
    for m in np.flatnonzero(stale.any(axis=0)):
        captures = np.unique(rows.capture[stale[:, m]])
        said.append(
            f"{rows.markers[markers[m]]} stands still to the last digit in {in_captures(captures)}, as "
            "where a tracker repeats what it saw last: left out there"
        )
    if len(said) > _NAMED:
        said = [*said[:_NAMED], f"so do {len(said) - _NAMED} others"]
    return replace(context, rows=replace(rows, values=values, warnings=(*rows.warnings, *said)))


def _for_ever(place: Floats) -> NDArray[np.bool_]:
    """Which of the places (F, M, 3) are of markers that have one and the same in all rows, where most have not, (F, M).

    A model that was fitted to such a marker says that it does not move.
    """
    seen = np.asarray(np.isfinite(place).all(axis=2))
    low, high = (end(np.where(seen[..., None], place, at), axis=0) for end, at in _ENDS)
    still = (low == high).all(axis=1) & (seen.sum(axis=0) > 2)
    return seen & still & (still.mean() < _TOGETHER)


def _stale(place: Floats, expected: Floats) -> NDArray[np.bool_]:
    """Which of the places (F, M, 3) are those of the row before, in runs that are too long for chance, (F, M): of
    markers that are expected to move meanwhile, or that elsewhere tremble where they are expected to stand still.
    """
    same, still = np.zeros(place.shape[:2], dtype=bool), np.zeros(place.shape[:2], dtype=bool)
    seen = np.asarray(np.isfinite(place).all(axis=2))
    same[1:] = (place[1:] == place[:-1]).all(axis=2)
    still[1:] = (expected[1:] == expected[:-1]).all(axis=2) & seen[1:] & seen[:-1]
    alone = same.sum(axis=1) < _TOGETHER * np.maximum(seen.sum(axis=1), 1)
    rate = max(float(np.median(same[alone].mean(axis=0))) if alone.any() else 1.0, 1.0 / same.size)
    trembles = (same & still).sum(axis=0) < _TOGETHER * still.sum(axis=0)
    run, moved = np.zeros(same.shape, dtype=int), np.zeros(same.shape, dtype=bool)
    for f in range(1, len(same)):
        run[f] = np.where(same[f], run[f - 1] + 1, 0)
        moved[f] = same[f] & (moved[f - 1] | ~still[f])
    for f in range(len(same) - 2, 0, -1):  # every row of a run knows how long it gets
        goes_on = same[f] & same[f + 1]
        run[f], moved[f] = np.where(goes_on, run[f + 1], run[f]), np.where(goes_on, moved[f + 1], moved[f])
    told = same & alone[:, None] & (trembles | moved)
    return told & (same.size * rate ** run.astype(float) < _BY_CHANCE)
