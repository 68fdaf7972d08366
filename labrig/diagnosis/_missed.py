"""Single set-points that a chamber missed: a valve that did not switch, a command that was lost."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from labrig._gaps import filled
from labrig.arrays import Floats, Ints
from labrig.diagnosis._listed import in_captures
from labrig.diagnosis._usual import usual
from labrig.effects import Context, motion_scale

MISSED = "single set-points that a chamber missed"
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
_ALIKE = 0.1
"""Share of the range within which set-points are alike."""
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
        said.append(
            f"{rows.chambers[c]} {did} in {in_captures(own)}, whatever it was told: left out; look at its valve and "
            "its hose, and measure again"
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
    first = rows.first
    n, scale = len(first), motion_scale(context)
    seen = np.asarray(np.isfinite(context.residual[first]).any(axis=0))
    if n < _FEWEST or seen.sum() < len(rows.chambers) + _MORE or not context.jacobian[first].any():
        return None
    # at once: what empties along a hold has followed
    error = np.where(seen, filled(context.residual[first]) / scale, 0.0)
    off = error - usual(context, first, error)
    event, started = rows.event[first], context.started
    before = np.where((started[event] >= 0)[:, None], context.event_deflection[started[event]], 0.0)
    slopes = context.jacobian[first] * context.span * (seen / scale)[:, None]
    found = []
    for still, there in ((True, before), (False, np.zeros_like(before))):
        chamber = _at_fault(context, slopes, there, off, error)
        at = np.flatnonzero(chamber >= 0)
        if len(at) and not _on_end(at):
            found.append(Missed(rows.capture[first][at], chamber[at], still))
    return max(found, key=lambda missed: len(missed.capture), default=None)


def _at_fault(context: Context, slopes: Floats, there: Floats, off: Floats, error: Floats) -> Ints:
    """The chamber by which each capture is off, (n,), if it stood `there` (n, C: deflection) and had not followed; -1
    where none explains it.

    `error` (n, K) is what each capture is off, `off` that beside what is usual, both in the size of the rig's motion,
    as `slopes` (n, K, C) are.
    """
    rows, first, (low, high) = context.rows, context.rows.first, _AS_MUCH
    size = np.sqrt((off**2).sum(axis=1))
    by_owner = np.stack([(off[:, rows.owner == m] ** 2).sum(axis=1) for m in np.unique(rows.owner)], axis=1)
    clear = (by_owner.max(axis=1) < _ONE * size**2) & (size > _FAR * np.quantile(size, 1 - _MOST))
    step = there - context.deflection[first]
    large = np.abs(step) >= _STEP
    moves = slopes * (step / np.maximum(context.deflection_slope[first], _STEP))[:, None]
    square = np.maximum((moves**2).sum(axis=1), 1e-300)
    along, whole = (np.einsum("nkc,nk->nc", moves, one) for one in (off, error))
    explained = along**2 / square / np.maximum(size**2, 1e-300)[:, None]
    fits = large & (along > low * square) & (along < high * square) & (explained >= _EXPLAINED)
    fits &= clear[:, None] & (whole > low * square)  # nor is it what is usual that makes it up
    followed = large & (np.abs(whole) < low * square) & (np.abs(context.deflection[first]) >= _STEP)
    fits &= _now_and_then(fits, followed, rows.fraction[first])
    return np.where(fits.any(axis=1), np.where(fits, explained, 0.0).argmax(axis=1), -1)


def _now_and_then(missed: NDArray[np.bool_], followed: NDArray[np.bool_], x: Floats) -> NDArray[np.bool_]:
    """Which (n, C) of the set-points x (n, C) that were missed a chamber `followed` (n, C) at other times. What it does
    at all of its lowest, or of its highest ones, is a law.
    """
    out = np.zeros_like(missed)
    for c in np.flatnonzero(missed.any(axis=0)):
        own, others = x[missed[:, c], c], x[followed[:, c], c]
        if (others <= own.max()).any() and (others >= own.min()).any():
            out[:, c] = (np.abs(others - x[:, [c]]) <= _ALIKE).any(axis=1)
    return out


def _on_end(at: Ints) -> bool:
    """Whether so many captures follow each other that they are a change."""
    return len(at) >= _STAYS and bool((at[_STAYS - 1 :] - at[: 1 - _STAYS] < _STAYS).any())
