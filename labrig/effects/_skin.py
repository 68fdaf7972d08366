"""What acts where it is seen, not in a chamber: histories of the observables themselves."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from labrig._linalg import sums_of, svd
from labrig.arrays import Floats, Ints
from labrig.effects._context import FEW_OBSERVABLES, Context
from labrig.effects._effect import Term
from labrig.effects._family import Feature, Space, field, motion_scale
from labrig.effects._rows import Rows

MARKERS = "markers"
"""All markers together, beside few sensors."""
_EVEN = 0.1
"""Share of the largest slope by which slopes may differ and count as the same all over."""
_FLAT = 0.1
"""Extent of the body, share of its longest, below which it has no places that differ along that way."""


def at_events(context: Context) -> Floats:
    """The predicted displacement at each event (E, K): of its rows, else as the base predicts it, else by the chambers'
    deflections.
    """
    rows = context.rows
    E = len(rows.event_session)
    count = np.bincount(rows.event, minlength=E)
    out = sums_of(rows.event, context.displacement, E) / np.maximum(count, 1)[:, None]
    alone = count == 0
    if alone.any() and context.elsewhere is not None:
        out[alone] = context.elsewhere(rows.event_actuation[alone]) - context.base_vented
    elif alone.any():
        by_chamber = np.linalg.lstsq(context.deflection, context.displacement, rcond=None)[0]
        out[alone] = context.event_deflection[alone] @ by_chamber
    return out


def play_behind(context: Context, width: float) -> Floats:
    """How far a play of `width`, a share of the whole motion, of each observable stays behind it, (F, K)."""
    drive = at_events(context)
    return context.played(width * motion_scale(context), drive) - drive[context.rows.event]


def lag_behind(context: Context, tau_s: float) -> Floats:
    """How far a first-order lag of each observable stays behind it, (F, K)."""
    drive = at_events(context)
    return context.lagged(tau_s, drive) - drive[context.rows.event]


def settling(context: Context, tau_s: float) -> Floats:
    """What is left of the last motion of each observable as a damped body of second order loses it, (F, K)."""
    q = context.elapsed_s[:, None] / tau_s
    return last_motion(context) * (1 + q) * np.exp(-q)


def last_motion(context: Context) -> Floats:
    """How far each observable was, before the last actuation, from where it is now, (F, K)."""
    drive = at_events(context)
    before = context.started
    return (np.where((before >= 0)[:, None], drive[before], 0.0) - drive)[context.rows.event]


def by_place(context: Context, name: str, values: Floats) -> list[Feature]:
    """Functions (F, K) that are larger on one side of the body than on the other, along each way that it is long in; of
    few sensors, each in a measure of its own.

    What another gain at each place would do is taken off: the base may be wrong in that.
    """
    out = []
    for a, z in enumerate(_places(context)):
        own, gain, whole = values * z, context.displacement * z, f"{name} by place {a}"
        if context.shows(gain.any()):
            as_gain = context.yardstick(f"{whole}, as a gain", partial(_share_of, own, gain))
            out.append(field(whole, own - as_gain * gain))
    return out


def _share_of(values: Floats, gain: Floats) -> Floats:
    """How much of `gain` the values have, by least squares."""
    return (values * gain).sum() / max(float((gain**2).sum()), 1e-300)


def by_sensor(context: Context, lagging: list[tuple[str, Floats]]) -> list[Feature]:
    """What few sensors take on with time, (F, K) each, in a measure of each one's own: its gain grows with it."""
    which = _which(context.rows)
    return [
        field(f"{name} of sensor {k}", values * z) for name, values in lagging for k, z in enumerate(which)
    ]


def by_itself(context: Context, space: Space) -> Iterator[Space]:
    """The same of few sensors, each by itself: what goes through the pressures of one need not go through another's.
    None where there are not few, or a single one.
    """
    which, _ = groups(context.rows)
    if len(which):
        yield replace(space, key=f"{space.key}, by sensor", apart=which)


def felt(context: Context, changes: dict[str, Floats]) -> list[Feature]:
    """What few sensors feel of each input, (F, C) by name, as so much of what they measure, however far that input
    moves them there: a seal rubs as hard where a lever is short. None of sensors that inputs move alike all over.
    """
    slopes, alone = context.jacobian * context.span, np.flatnonzero(seen_alone(context.rows))
    if not len(alone) or len(alone) > FEW_OBSERVABLES:
        return []
    even = np.ptp(slopes[:, alone], axis=0).max() <= _EVEN * np.abs(slopes[:, alone]).max()
    if not context.shows(not even):
        return []
    return _each(context, changes, alone)


def touched(context: Context, changes: dict[str, Floats]) -> list[Feature]:
    """What few sensors read of each input, (F, C) by name, that the base says nothing of, such as a force at a tip that
    meets something.
    """
    return _each(context, changes, _unsaid(context))


def touched_term(context: Context, parameter: str, change: Floats) -> Term | None:
    """The same as a formula: one coefficient of each such sensor and input, in the sensor's unit. None without any."""
    rows, own = context.rows, _unsaid(context)
    pairs = [(k, c) for k in own for c in range(change.shape[1]) if change[:, c].any()]
    if not pairs:
        return None
    feature = np.zeros((*context.base.shape, len(pairs)))
    for j, (k, c) in enumerate(pairs):
        feature[:, k, j] = change[:, c]
    labels = tuple(f"{rows.observables[k]} by {rows.chambers[c]}" for k, c in pairs)
    return Term.field(parameter, feature, labels)


def _unsaid(context: Context) -> Ints:
    """Which few sensors the base says nothing of, (n,)."""
    still = np.ptp(context.displacement, axis=0) == 0
    own = np.flatnonzero(seen_alone(context.rows) & still)
    return own[: len(own) if len(own) <= FEW_OBSERVABLES else 0]


def _each(context: Context, changes: dict[str, Floats], own: Ints) -> list[Feature]:
    """A field of each change (F, C) of each chamber in each of some observables by itself."""
    scale, out = motion_scale(context), []
    for name, change in changes.items():
        for k in own:
            for c in range(change.shape[1]):
                values = np.zeros(context.base.shape)
                values[:, k] = scale[k] * change[:, c]
                out.append(field(f"{name} {k} {c}", values))
    return out


def per_sensor(context: Context, parameter: str, change: Floats) -> Iterator[Term]:
    """One coefficient of few sensors each, and one of all markers; `change` (F, C), units of the actuation. None where
    there are not few, or a single one.
    """
    which, names = groups(context.rows)
    if len(which):
        moved = np.einsum("fkc,fc->fk", context.jacobian, change)
        yield Term.field(parameter, moved[:, :, None] * which.T, names)


def groups(rows: Rows) -> tuple[Floats, tuple[str, ...]]:
    """Each of few sensors, and all markers together, (n, K), 1 or 0, and their names; of a single group none."""
    alone = [int(k) for k in np.flatnonzero(seen_alone(rows))]
    which = np.eye(len(rows.marker))[alone]
    names = tuple(rows.observables[k] for k in alone)
    if (rows.marker >= 0).any():
        which, names = np.vstack([which, (rows.marker >= 0).astype(float)]), (*names, MARKERS)
    several = alone and 1 < len(names) <= FEW_OBSERVABLES
    return (which, names) if several else (which[:0], ())


def _places(context: Context) -> Floats:
    """Where each observable is at rest along the ways in which the body is long, (n, K), of unit spread; and which of
    few sensors it is.
    """
    return np.concatenate([_along(context), _which(context.rows)])


def _which(rows: Rows) -> Floats:
    """Each of few sensors that were seen, and are no marker's, against all of them, (n, K), of unit spread."""
    alone = np.flatnonzero(seen_alone(rows))
    out = np.zeros((len(alone) if 1 < len(alone) <= FEW_OBSERVABLES else 0, len(rows.marker)))
    if len(out):
        out[:, alone] = (np.eye(len(alone)) - 1 / len(alone)) * np.sqrt(len(rows.marker))
    return out


def seen_alone(rows: Rows) -> NDArray[np.bool_]:
    """Which observables were seen at all and are no marker's, (K,)."""
    return (rows.marker < 0) & np.isfinite(rows.values).any(axis=0)


def _along(context: Context) -> Floats:
    """Where each marker's coordinates are at rest along the ways in which the body is long, (n, K), of unit spread."""
    rows = context.rows
    out = np.zeros((3, len(rows.marker)))
    if rows.rest_mm is None or not np.isfinite(rows.rest_mm).all() or len(rows.rest_mm) < 3:
        return out[:0]
    away = rows.rest_mm - rows.rest_mm.mean(axis=0)
    ways = context.yardstick("long ways", lambda: svd(away)[2])
    size = np.sqrt(((away @ ways.T) ** 2).sum(axis=0))
    own = np.flatnonzero(rows.marker >= 0)
    out[:, own] = (away @ ways.T / np.maximum(size, 1e-300) * np.sqrt(len(away))).T[:, rows.marker[own]]
    return out[size > _FLAT * size.max()]


def body_behind(context: Context, width: float) -> Floats:
    """How far the body stays behind, all of it, where a play of `width` holds its main way of moving back, (F, K)."""
    along, way = _main_way(context)
    return (context.played(width, along) - along[context.rows.event])[:, None] * way


def body_settled(context: Context, power: float) -> Floats:
    """How far the body would go along its main way if that went with a power of the way, (F, K)."""
    along, way = _main_way(context)
    now = along[context.rows.event]
    return (np.sign(now) * np.abs(now) ** power)[:, None] * way


def marker_behind(context: Context, width: float) -> Floats:
    """How far each marker stays behind that is dragged in space by a thread of `width`, of the whole motion, (F, K).

    Dry friction that knows no direction: J. J. Moreau, Trends in Applications of Pure Mathematics to Mechanics II
    (Pitman 1979). Each observable without a marker by itself.
    """
    scale, marker = motion_scale(context), context.rows.marker
    of_one = ((marker[:, None] == marker) & (marker >= 0) | np.eye(len(marker), dtype=bool)).astype(float)
    return _dragged(context, width, at_events(context) / scale, of_one) * scale


def path_behind(context: Context, width: float) -> Floats:
    """How far the set-points of all chambers stay behind, (F, C), as shares of their ranges, that are dragged together
    by a thread of `width`: the same friction where it is the whole body that moves along its path, whoever moves it.
    """
    C = len(context.rows.chambers)
    drive = (context.rows.event_actuation - context.vented) / context.span
    return _dragged(context, width, drive, np.ones((C, C)))


def path_direction(context: Context) -> Floats:
    """The way, of length 1, that the set-points of all chambers last went together, (F, C); 0 before the first one."""
    change = context.rows.event_actuation - context.previous
    out = change / np.maximum(np.linalg.norm(change, axis=1, keepdims=True), 1e-300)
    for e, before in enumerate(context.started):
        if not change[e].any() and before >= 0:
            out[e] = out[before]
    return out[context.rows.event]


def _dragged(context: Context, width: float, drive: Floats, of_one: Floats) -> Floats:
    """How far a drive's (E, n) points stay behind it that threads of `width` drag, (F, n); `of_one` (n, n) is 1 where
    two numbers are of one point.
    """
    state = drive.copy()
    for e, before in enumerate(context.started):
        behind = drive[e] - (state[before] if before >= 0 else 0.0)
        length = np.sqrt(behind**2 @ of_one)
        state[e] = drive[e] - behind * np.minimum(1.0, width / np.maximum(length, 1e-12))
    return (state - drive)[context.rows.event]


def _main_way(context: Context) -> tuple[Floats, Floats]:
    """How far the body is along its main way at each event (E,), as a share of the whole motion, and that way (K,)."""
    drive, scale = at_events(context), motion_scale(context)
    way = context.yardstick("main way", lambda: svd(drive / scale)[2][0])
    return drive / scale @ way / np.sqrt(len(scale)), way * scale * np.sqrt(len(scale))
