"""Whether measurements and model may be in different units or of different kinds, or the rig did not move at all."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats, Ints
from labrig.diagnosis._mixed_up import mixed_up
from labrig.diagnosis._pressures_off import TIMES, pressures_off
from labrig.effects import Context

_OF_BOTH = ("the model", "the measurement")
_NEAR, _FAR = 0.1, 0.3
"""Share of the places at rest by which what markers are off by may be another; and of how far they move, from which on
it is looked at."""
_STILL = 0.05
"""Share of what the model changes from set-point to set-point that its slopes say, below which it has none."""
_CAPTURES = 6
"""Captures from which on a session says how far it follows the model."""
_ALIKE = 0.9
"""Correlation from which on what was measured follows the model."""


def units_off(context: Context) -> list[str]:
    """A line for each unit whose observables hardly move, or follow the model's prediction many times as far or as
    little; without one, a line where one of both gives displacements and the other positions; without that, what else
    is mistaken.
    """
    scales = (
        [line for line, _ in _scales(context)] or [*_in_one_session(context)] or [*pressures_off(context)]
    )
    return scales or [*_displaced(context)] or [*_stairs(context)] or [*mixed_up(context)]


def mistaken(context: Context) -> Iterator[str]:
    """What nothing can be concluded beside: units, displacements and positions, axes, chambers or set-points that are
    mistaken for each other.
    """
    yield from (line for line, follows in _scales(context) if follows)
    yield from _in_one_session(context)
    yield from pressures_off(context)
    yield from _displaced(context)
    yield from _stairs(context)
    yield from mixed_up(context)


def _stairs(context: Context) -> list[str]:
    """A line where the model stands still beside each set-point, though it says another thing at the next one: effects
    that act through its slopes would be nothing at all.
    """
    first = context.rows.first
    u, base, slope = context.rows.actuation[first], context.base[first], context.jacobian[first]
    step = np.diff(u, axis=0)
    said = np.einsum("nkc,nc->nk", slope[1:] + slope[:-1], step) / 2
    way = np.ptp(base, axis=0)
    scale = np.where(way > 0, way, np.inf)
    moved, follows = (float((np.square(v / scale)).sum()) for v in (np.diff(base, axis=0), said))
    if context.base_kind != "python" or moved <= 0 or follows > _STILL**2 * moved:
        return []
    return [
        "the model says the same at pressures a little beside each set-point, and another thing at the next one, as a "
        "table that is looked up: no slopes can be read off it, so let it interpolate, or give its predictions as "
        "base: {kind: table, file: ...}"
    ]


def _scales(context: Context) -> Iterator[tuple[str, bool]]:
    """A line for each unit that may be another, and whether what was measured follows the model all the same."""
    everything = np.ones(len(context.base), dtype=bool)
    for unit in dict.fromkeys(context.rows.unit):
        times, follows = _times(context, unit, everything)
        if times <= 1 / TIMES or (times >= TIMES and follows):
            yield (
                f"what is measured in {unit} changes {_far(times)} as the model says: check the units of "
                "both and of the pressures, and whether these arrive",
                follows,
            )


def _in_one_session(context: Context) -> Iterator[str]:
    """A line where single sessions, most often files of their own, follow the model many times as far or as little."""
    rows = context.rows
    for unit in dict.fromkeys(rows.unit):
        off = {}
        for s, name in enumerate(rows.sessions):
            own = rows.session == s
            times, follows = _times(context, unit, own)
            if len(np.unique(rows.capture[own])) >= _CAPTURES and follows and not 1 / TIMES < times < TIMES:
                off[name] = times
        if off and len(off) < len(rows.sessions):
            name, times = next(iter(off.items()))
            more = f" (and {len(off) - 1} more)" if len(off) > 1 else ""
            yield (
                f"in session {name}{more} what is measured in {unit} changes {_far(times)} as the model "
                "says, and in others it does not: check the units of its file, of the pressures, too"
            )


def _far(times: float) -> str:
    """How far something changes beside the model, in words."""
    large = max(times, 1 / times)
    said = f"{large:.0f}" if large >= 10 else f"{large:.2g}"
    return f"{said} times as far" if times >= 1 else f"1/{said} as far"


def _times(context: Context, unit: str, of: NDArray[np.bool_]) -> tuple[float, bool]:
    """How many times as far as the model says what has a unit changes in some rows (F,), and whether it follows the
    model; 1 and not where either does not change.
    """
    own = np.array(context.rows.unit) == unit
    values, said = context.rows.values[np.ix_(of, own)], context.base[np.ix_(of, own)]
    seen = np.isfinite(values)
    count = np.maximum(seen.sum(axis=0), 1)
    measured, base = (
        np.where(seen, v, 0.0) - np.where(seen, v, 0.0).sum(axis=0) / count for v in (values, said)
    )
    both, of_base, of_measured = (
        float((a * b)[seen].sum()) for a, b in ((measured, base), (base, base), (measured, measured))
    )
    if of_base <= 0 or of_measured <= 0 or not seen.any():
        return 1.0, False
    times = float(np.sqrt(of_measured / of_base))
    return times, both > 0 and both >= _ALIKE * times * of_base


def _displaced(context: Context) -> list[str]:
    """A line where, at the least pressures, the markers lie many times as far apart in one of both, and farther than
    they move and than the error differs from row to row: of markers that start side by side, and of noise, their places
    tell nothing of what they were counted from.
    """
    rows = context.rows
    of_markers = np.isfinite(rows.values) & (rows.marker >= 0)
    many = of_markers.sum(axis=1) > np.bincount(rows.marker[rows.marker >= 0], minlength=1).max()
    if not many.any():
        return []
    row = np.flatnonzero(many)[np.argmin(rows.fraction[many].sum(axis=1))]
    own = np.flatnonzero(of_markers[row])
    measured, model = (_apart(v[row, own], rows.axis[own]) for v in (rows.values, context.base))
    moves = np.sqrt(np.sum(np.var(context.base[:, own], axis=0)) / len(np.unique(rows.marker[own])))
    varies = np.sqrt(3 * np.mean(np.nanvar(rows.values[:, own] - context.base[:, own], axis=0)))
    if max(measured, model) < max(TIMES * min(measured, model), moves, TIMES * varies):
        return _counted_from_rest(context)
    small, large = _OF_BOTH if model < measured else _OF_BOTH[::-1]
    return [
        f"at the least pressures the markers lie {measured:.2g} mm from their middle as measured and {model:.2g} mm as "
        f"the model says: {small} seems to give displacements, {large} positions, where both must give the same"
    ]


def _counted_from_rest(context: Context) -> list[str]:
    """A line where each marker is always off by the place at rest that one of both has, and the other lacks: of markers
    that move farther than they lie apart, no place tells of it, but that all are off by just this does. What differs
    from row to row by nearly as much is another error.
    """
    rows = context.rows
    own = np.flatnonzero((rows.marker >= 0) & np.isfinite(rows.values).any(axis=0))
    axis = rows.axis[own]
    error = rows.values[:, own] - context.base[:, own]
    off = _from_middle(np.nanmean(error, axis=0), axis)
    rest = _from_middle(context.base_vented[own], axis)
    away = _from_middle(context.base[:, own] - context.base_vented[own], axis)
    moved = float(np.sqrt((away**2).sum(axis=1).mean()))
    off_size, rest_size = float(np.linalg.norm(off)), float(np.linalg.norm(rest))
    if off_size < max(_FAR * moved, TIMES * float(np.linalg.norm(np.nanstd(error, axis=0)))):
        return []
    near = _NEAR * off_size
    if rest_size > near and np.linalg.norm(off + rest) > near:
        return []
    small, large = _OF_BOTH if rest_size < near else _OF_BOTH[::-1]
    return [
        f"all markers are off by their places at rest: {small} seems to give displacements, {large} positions, where "
        "both must give the same"
    ]


def _from_middle(place: Floats, axis: Ints) -> Floats:
    """How far coordinates (..., K) along `axis` (K,), 0 to 2, are from those of the markers' middle."""
    middle = np.zeros_like(place)
    for a in np.unique(axis):
        middle[..., axis == a] = place[..., axis == a].mean(axis=-1, keepdims=True)
    return place - middle


def _apart(place: Floats, axis: Ints) -> float:
    """Root mean square distance of markers from their middle, whose coordinates (K,) lie along `axis` (K,)."""
    return float(np.sqrt(3 * np.mean(_from_middle(place, axis) ** 2)))
