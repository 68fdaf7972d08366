"""Single set-points that a chamber missed: a valve that did not switch, a command that was lost."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.effects import Context, Space, acting, errors_by_capture, motion_scale, pressure
from labrig.model import robust_fit

MISSED = "missed"
MISSED_ONE = "single set-points that a chamber missed"
_NAMED = 4
_FEWEST = 20
"""Captures below which a few that are far off say nothing of what is usual."""
_MOST = 0.1
"""Share of the captures up to which they are single ones; what comes more often is an effect."""
_STAYS = 4
"""Captures, one after the other, from which on it is a change."""
_FAR = 3.0
"""How many times as far off a capture is as those of most others are."""
_STEP = 0.1
"""Share of the range from which on a step that was missed can be told from an effect."""
_SMALL = 1e-6
_EXPLAINED, _AS_MUCH = 0.9, (0.7, 1.4)
"""Share of its square that the missed step explains, and how many times the step: slopes of a base are not exact."""


@dataclass(frozen=True)
class Missed:
    """Captures (m,), places among all of them, their numbers, and the chamber (m,) that did not follow; `still`: it
    stayed where it was, else it was vented; `less` (m,): by what share of its range it lacked pressure.
    """

    at: Ints
    capture: Ints
    chamber: Ints
    still: bool
    less: Floats


def missed(context: Context) -> Iterator[Space]:
    """What chambers lacked at the set-points that they missed, all of them together."""
    found = missing(context)
    if found is None:
        return
    rows = context.rows
    index = np.unique(rows.capture, return_inverse=True)[1]
    values = np.zeros_like(rows.fraction)
    for at, chamber, less in zip(found.at, found.chamber, found.less, strict=True):
        values[index == at, chamber] = less
    yield Space(
        MISSED_ONE,
        MISSED,
        acting([pressure("missed", values)]),
        alike=1.0,
        scanned=int(index.max()) + 1,
        absolute=False,
    )


def missed_by(context: Context) -> list[str]:
    """A line for each chamber that missed set-points, with their captures."""
    found = missing(context)
    out = []
    for c in np.unique(found.chamber) if found else ():
        own = found.capture[found.chamber == c] if found else ()
        shown = ", ".join(str(i) for i in own[:_NAMED]) + (", ..." if len(own) > _NAMED else "")
        several = "captures" if len(own) > 1 else "capture"
        did = "stayed where it was" if found and found.still else "was as good as vented"
        out.append(
            f"{context.rows.chambers[c]} {did} in {len(own)} {several} ({shown}), whatever it was told: look at its "
            "valve and its hose, and measure them again"
        )
    return out


def missing(context: Context) -> Missed | None:
    """The captures that are far off by what one chamber would do if it had not followed; None where there are none, or
    too many, or where they follow each other.
    """
    rows = context.rows
    if not context.moves or context.sample_s:
        return None
    captures, error = errors_by_capture(context)
    n, scale = len(captures), motion_scale(context)
    first = np.unique(rows.capture, return_index=True)[1]
    if n < _FEWEST or not context.jacobian[first].any():
        return None
    off = error / scale - _usual(context, first, error / scale)
    size = np.sqrt((off**2).sum(axis=1))
    slope = np.maximum(context.deflection_slope[first], _STEP)
    event, started = rows.event[first], context.started
    before = np.where((started[event] >= 0)[:, None], context.event_deflection[started[event]], 0.0)
    found = []
    for still, there in ((True, before), (False, np.zeros_like(before))):
        less = (there - context.deflection[first]) / slope
        far = np.abs(there - context.deflection[first]) >= _STEP
        moves = context.jacobian[first] * (context.span * less)[:, None] / scale[:, None]
        square = np.maximum((moves**2).sum(axis=1), 1e-300)
        along = np.einsum("nkc,nk->nc", moves, off)
        explained = along**2 / square / np.maximum(size**2, 1e-300)[:, None]
        times = along / square
        fits = far & (times > _AS_MUCH[0]) & (times < _AS_MUCH[1]) & (explained >= _EXPLAINED)
        fits &= (size > _FAR * np.quantile(size, 1 - _MOST))[:, None]
        at = np.flatnonzero(fits.any(axis=1))
        chamber = np.where(fits, explained, 0.0).argmax(axis=1)[at]
        found.append(Missed(at, captures[at], chamber, still, less[at, chamber]))
    best = max(found, key=lambda one: len(one.at))
    m = len(best.at)
    if (
        m == 0
        or m > _MOST * n
        or (m >= _STAYS and (best.at[_STAYS - 1 :] - best.at[: 1 - _STAYS] < _STAYS).any())
    ):
        return None
    return best


def _usual(context: Context, first: Ints, off: Floats) -> Floats:
    """What each chamber does otherwise in most captures, (n, K), of how far these are off (n, K): by its pressure, by
    the one before, by the way it came.
    """
    rows = context.rows
    J = context.jacobian[first] * context.span / motion_scale(context)[:, None]
    normal = np.einsum("nkc,nkd->ncd", J, J)
    normal += _SMALL * np.trace(normal.mean(axis=0)) * np.eye(normal.shape[1])
    change = np.linalg.solve(normal, np.einsum("nkc,nk->nc", J, off)[:, :, None])[:, :, 0]
    event = rows.event[first]
    x, before, way = rows.fraction[first], context.previous[event] / context.span, context.direction[event]
    usual = np.zeros_like(change)
    for c in range(change.shape[1]):
        columns = np.column_stack(
            [np.ones(len(x)), x[:, c], x[:, c] ** 2, before[:, c], way[:, c], way[:, c] * x[:, c]]
        )
        usual[:, c] = columns @ robust_fit(columns, change[:, c], np.ones(len(x)))
    return np.einsum("nkc,nc->nk", J, usual)
