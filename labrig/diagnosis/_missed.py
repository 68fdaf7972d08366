"""Single set-points that a chamber missed: a valve that did not switch, a command that was lost."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Ints
from labrig.diagnosis._usual import usual
from labrig.effects import Context, fill, motion_scale

MISSED = "single set-points that a chamber missed"
_NAMED = 4
_FEWEST = 20
"""Captures below which a few that are far off say nothing of what is usual."""
_MORE = 3
"""How many more observables there must be than chambers: else whatever is seen is what some chamber does."""
_MOST = 0.1
"""Share of the captures up to which they are single ones; what comes more often is an effect."""
_STAYS = 4
"""Captures, one after the other, from which on it is a change."""
_FAR = 3.0
"""How many times as far off a capture is as those of most others are."""
_ONE = 0.8
"""Share of the square from which on one marker, or sensor, is off alone: that one may be mistaken."""
_STEP = 0.1
"""Share of the range from which on a step that was missed can be told from an effect."""
_EXPLAINED, _AS_MUCH = 0.9, (0.7, 1.4)
"""Share of its square that the missed step explains, and how many times the step: slopes of a base are not exact."""


@dataclass(frozen=True)
class Missed:
    """The captures (m,), by number, and the chamber (m,) that did not follow; `still`: it stayed where it was, else it
    was vented.
    """

    capture: Ints
    chamber: Ints
    still: bool


def without_missed(context: Context) -> tuple[Context, NDArray[np.bool_]]:
    """The campaign with warnings that name the captures in which a chamber did not follow, and the other rows (F,)."""
    found, rows = missing(context), context.rows
    if found is None:
        return context, np.ones(len(rows.capture), dtype=bool)
    said = []
    did = "stayed where it was" if found.still else "was as good as vented"
    for c in np.unique(found.chamber):
        own = found.capture[found.chamber == c]
        shown = ", ".join(str(i) for i in own[:_NAMED]) + (", ..." if len(own) > _NAMED else "")
        several = "captures" if len(own) > 1 else "capture"
        said.append(
            f"{rows.chambers[c]} {did} in {len(own)} {several} ({shown}), whatever it was told: left out there; look "
            "at its valve and its hose, and measure them again"
        )
    context = replace(context, rows=replace(rows, warnings=(*rows.warnings, *said)))
    return context, ~np.isin(rows.capture, found.capture)


def missing(context: Context) -> Missed | None:
    """The captures that are far off by what one chamber would do if it had not followed; None where there are none, or
    too many, or where they follow each other.
    """
    rows = context.rows
    if not context.moves or context.sample_s:
        return None
    captures, first = np.unique(rows.capture, return_index=True)
    error = fill(context.residual[first])  # at once: what empties along a hold has followed
    n, scale = len(captures), motion_scale(context)
    if n < _FEWEST or error.shape[1] < len(rows.chambers) + _MORE or not context.jacobian[first].any():
        return None
    off = error / scale - usual(context, first, error / scale)
    size = np.sqrt((off**2).sum(axis=1))
    alone = rows.marker < 0
    owner = np.where(alone, len(rows.markers) + np.arange(len(alone)), rows.marker)
    each = np.stack([(off[:, owner == m] ** 2).sum(axis=1) for m in np.unique(owner)], axis=1)
    several = each.max(axis=1) < _ONE * size**2
    event, started = rows.event[first], context.started
    before = np.where((started[event] >= 0)[:, None], context.event_deflection[started[event]], 0.0)
    slope = np.maximum(context.deflection_slope[first], _STEP)
    best, best_at = None, np.zeros(0, dtype=np.int64)
    for still, there in ((True, before), (False, np.zeros_like(before))):
        step = there - context.deflection[first]
        moves = context.jacobian[first] * (context.span * step / slope)[:, None] / scale[:, None]
        square = np.maximum((moves**2).sum(axis=1), 1e-300)
        along = np.einsum("nkc,nk->nc", moves, off)
        explained = along**2 / square / np.maximum(size**2, 1e-300)[:, None]
        fits = (along > _AS_MUCH[0] * square) & (along < _AS_MUCH[1] * square) & (explained >= _EXPLAINED)
        fits &= (np.abs(step) >= _STEP) & (several & (size > _FAR * np.quantile(size, 1 - _MOST)))[:, None]
        at = np.flatnonzero(fits.any(axis=1))
        often = len(at) > 0 and (size > size[at].min() / 2).sum() > _MOST * n
        if len(at) > len(best_at) and not often and not _on_end(at):
            best_at = at
            best = Missed(captures[at], np.where(fits, explained, 0.0).argmax(axis=1)[at], still)
    return best


def _on_end(at: Ints) -> bool:
    """Whether so many captures follow each other that they are a change."""
    return len(at) >= _STAYS and bool((at[_STAYS - 1 :] - at[: 1 - _STAYS] < _STAYS).any())
