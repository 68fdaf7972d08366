"""Inputs that move at one speed, set-points seen at one moment or approached from one side: what looks alike there."""

from collections.abc import Mapping

import numpy as np

from labrig._text import listed
from labrig.arrays import Floats, Ints
from labrig.diagnosis._amount import two_digits
from labrig.effects import TRANSIENT_S, Context, Effect

_FAR = 0.05
"""Share of the range over which a speed is taken, or an input comes back, so that a sensor's noise does not count."""
_ALIKE, _MOSTLY = 0.25, 0.8
"""Speeds are one where such a share of the way is gone at no more than so much from the usual one."""

_SHORT_S = 2 * TRANSIENT_S
"""Holds that end so soon after the command are short: no more is left of them than what is left out of long ones."""
_OFTEN = 0.5
"""Share of the moments at which an input changes, from which on it goes on by itself."""
_MOMENT = 0.2
"""Times of rows that differ by no more than this, as a part of the longest, are one moment."""


def one_speed(context: Context) -> list[str]:
    """A line where all chambers move at one speed each, in a record or by even steps at even times; none where nothing
    moves.
    """
    rows = context.rows
    if not context.moves:
        return []
    x = rows.event_actuation / context.span
    often = (np.diff(x, axis=0) != 0).mean(axis=0) >= _OFTEN
    chambers = np.flatnonzero(often if often.any() else ~often)  # what is set anew now and then has no speed
    speeds = [_usual(x[:, c], rows.event_time_s, rows.event_session) for c in chambers]
    moving = [
        (speed * abs(span), one)
        for (speed, one), span in zip(speeds, context.span[chambers], strict=True)
        if speed > 0
    ]
    if not moving or not all(one for _, one in moving):
        return []
    said = " and ".join(dict.fromkeys(two_digits(speed) for speed, _ in moving))
    unit = f"({rows.actuation_unit})" if " or " in rows.actuation_unit else rows.actuation_unit
    unit = f"{unit} a row" if rows.counted else f"{unit}/s"
    what = "the input always moves at" if context.sample_s else "the set-points always go on by"
    return [
        f"{what} about {said} {unit}: what lags in time (delay, creep) and what "
        "depends on the way (hysteresis, friction) look alike at one speed, so the name may be the other's; measure at "
        f"another speed, too{'' if context.sample_s else ', or hold some set-points for long'}"
    ]


def short_holds(context: Context) -> list[str]:
    """A line where most holds end while valves still fill and the body still swings."""
    rows = context.rows
    if not context.has_holds or not np.isfinite(rows.hold_s).all():
        return []
    last = np.zeros(rows.n_captures)
    np.maximum.at(last, rows.capture, rows.hold_s)
    seen = last[np.unique(rows.capture)]
    short = int((seen <= _SHORT_S).sum())
    if 2 * short <= len(seen):
        return []
    return [
        f"{short} of {len(seen)} holds end within {_SHORT_S:g} s of the command, while valves fill and the body "
        "swings: what is said here may be that; hold for 3 s or more"
    ]


def alike(context: Context, effects: Mapping[str, Effect]) -> frozenset[str]:
    """Effects that are not told apart: in a record whose inputs always move at one speed what lags in time and what
    depends on the way are functions of each other, and in one stroke what goes by the clock is one of both.
    """
    blurred = {"one speed"} if context.sample_s and one_speed(context) else set()
    blurred |= {"one stroke"} if one_stroke(context) else set()
    return frozenset(name for name, effect in effects.items() if blurred & effect.blurred_by)


def one_stroke(context: Context) -> list[str]:
    """A line where inputs go one way and back in each session, once, and never rest: time and way are one there."""
    rows = context.rows
    if not context.moves or context.elapsed_s.any():
        return []
    x = rows.event_actuation / context.span
    own = [x[rows.event_session == s] for s in np.unique(rows.event_session)]
    if any(np.ptp(part, axis=0).max() < _FAR or max(_turns(u) for u in part.T) > 1 for part in own):
        return []
    return [
        "the input goes there and back once: what changes with the clock (drift), what lags in time (delay, creep) and "
        "what depends on the way (hysteresis, friction) look alike in one stroke, so the name may be another's; go "
        "there and back several times, or hold some set-points for long"
    ]


def _turns(u: Floats) -> int:
    """How often an input (E,), a share of its range, turns back by more than a sensor's noise."""
    turns, way, top = 0, 0, float(u[0])
    for value in u.tolist():
        if way * (value - top) >= 0 and way:
            top = value
        elif abs(value - top) > _FAR:
            turns += way != 0
            way, top = (1 if value > top else -1), value
    return turns


def one_moment(context: Context) -> list[str]:
    """A line where every set-point was seen at the same time after it was set: what changes along holds is not seen."""
    held = context.elapsed_s
    if context.sample_s or not context.moves or held.max() <= 0 or np.ptp(held) > _MOMENT * held.max():
        return []
    return [
        f"every row was taken {held.mean():.2g} s after its set-point: what a chamber has lost by then (leak), or not "
        "reached yet (delay), looks like a curve of its pressure (regulator, stiffening, tension), so the name may be "
        "the other's; measure some set-points at several moments, too"
    ]


def counted_time(context: Context, named: Mapping[str, Effect]) -> list[str]:
    """A line where nothing was a clock, and what is named goes by time."""
    by_time = [
        name
        for name, effect in named.items()
        if any(p.unit == "s" or p.unit.endswith("/h") for p in effect.parameters)
    ]
    if not context.rows.counted or not by_time:
        return []
    return [
        f"no column was a time, so rows were taken as 1 s apart: times and rates of {listed(by_time, 'and')} count "
        "rows, and where rows were not taken evenly, the name may be another's; say 'time:' in the mapping"
    ]


def one_side(context: Context) -> list[str]:
    """A line where no set-point was approached but from the vented side: what depends on the way has one way there."""
    rows = context.rows
    seen = np.unique(rows.event)
    x = rows.event_actuation[seen]
    back = (context.previous[seen] - x) * np.sign(x - context.vented) > _FAR * context.span
    if context.sample_s or not context.moves or back.any():
        return []
    return [
        "every set-point was approached from the vented side: what depends on the way (friction, hysteresis) looks "
        "like an offset or a curve of the set-points (regulator, rest shape, tension) there, so the name may be the "
        "other's; approach some from the other side, too"
    ]


def _usual(x: Floats, time_s: Floats, session: Ints) -> tuple[float, bool]:
    """The usual speed of an input (E,), share of its range a second, 0 where it rests; and whether it has no other."""
    apart = 1
    while apart < len(x) // 4 and np.abs(x[apart:] - x[:-apart]).mean() < _FAR:
        apart *= 2
    way, took = np.abs(x[apart:] - x[:-apart]), time_s[apart:] - time_s[:-apart]
    good = (session[apart:] == session[:-apart]) & (took > 0) & (way > 0)
    if not good.any() or way.max() < _FAR:
        return 0.0, False
    way, speed = way[good], way[good] / took[good]
    order = np.argsort(speed)
    gone = np.cumsum(way[order]) / way.sum()
    usual = float(speed[order][np.searchsorted(gone, 0.5)])
    return usual, bool(way[np.abs(speed / usual - 1) <= _ALIKE].sum() >= _MOSTLY * way.sum())
