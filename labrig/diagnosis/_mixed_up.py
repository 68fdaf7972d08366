"""Axes, chambers or set-points that are mistaken for others: what was measured follows the model, once they are not."""

from collections.abc import Iterator
from itertools import permutations, product

import numpy as np
from scipy.optimize import linear_sum_assignment

from labrig._turns import quaternions
from labrig.arrays import Floats
from labrig.effects import Context, capture_means, motion_scale

_CLOSER = 3.0
"""How many times closer what was measured follows the model once something is exchanged, for that to be said."""
_MATTERS = 0.2
"""Share of what chambers do by which it must be another where they are exchanged: twins may be exchanged."""
_FOLLOWS, _NAMED = 0.25, 6
"""What a column leaves, at most, of the square of what it follows once it is in its place; how many are named."""
_ENOUGH = 3
"""Captures that there must be for each coefficient that is fitted."""
_FEWEST, _FAR = 10, 0.3
"""Set-points that there must be to compare them with their neighbours, and by what share of the range they differ."""


def mixed_up(context: Context) -> Iterator[str]:
    """A line for what is mistaken for each other: axes of markers, parts of a quaternion, signs, chambers, set-points.

    Nothing physical is put right by an exchange, which has no size that could be fitted.
    """
    ordered = [*_order(context)]
    yield from ordered
    yield from _quaternions(context)
    if context.moves:
        yield from _backward(context)
        # of a symmetric rig exchanged hoses look like a mirror
        if either := [*_axes(context), *_chambers(context), *(() if ordered else _columns(context))]:
            yield "; or ".join(either)
        yield from _moments(context)


def _order(context: Context) -> Iterator[str]:
    """Markers of which the model gives all x first, then all y, then all z, where the run has those of each marker."""
    rows = context.rows
    own = [np.flatnonzero((rows.axis == a) & (rows.marker >= 0)) for a in range(3)]
    if len({tuple(rows.marker[each]) for each in own}) > 1 or len(own[0]) < 2:
        return
    place = np.stack(own, axis=1).ravel()
    as_given = np.sort(place)
    base = context.base[:, as_given].reshape(len(context.base), 3, -1)
    measured, other = rows.values[:, place], np.moveaxis(base, 1, 2).reshape(len(base), -1)
    now, left = (float(np.nansum((measured - b) ** 2)) for b in (context.base[:, place], other))
    if now > 0 and now >= _CLOSER**2 * left:
        yield (
            f"the model gives x of all markers, then y and z of all: the run has {rows.observables[place[0]]}, "
            f"{rows.observables[place[1]]}, {rows.observables[place[2]]}, then those of the next marker, so let it "
            "give them in this order"
        )


def _columns(context: Context) -> Iterator[str]:
    """Columns that a function gives in another order than the run's observables: each goes to the one that is nearest,
    by how much that one changes.
    """
    rows = context.rows
    own = np.flatnonzero(np.isfinite(rows.values).any(axis=0))
    own = own[np.nanstd(rows.values[:, own], axis=0) > 0]
    if context.base_kind != "python" or len(own) < 2:
        return
    measured, base = (v[:, own] for v in (rows.values, context.base))
    size = np.nanstd(measured, axis=0)
    each = np.array([np.nanmean(((measured - b[:, None]) / size) ** 2, axis=0) for b in base.T])
    given, wanted = linear_sum_assignment(each)
    now, left = float(np.trace(each)), float(each[given, wanted].sum())
    moved = np.flatnonzero(given != wanted)
    if len(moved) and now >= _CLOSER**2 * left and left <= _FOLLOWS * len(own):
        names = [rows.observables[k] for k in own]
        j, k = given[moved[0]], wanted[moved[0]]
        yield (
            f"the model gives its columns in another order than the run: where the run has {names[j]}, it gives what "
            f"follows {names[k]}; let it give them in the order {', '.join(names[:_NAMED])}"
            f"{', ...' if len(names) > _NAMED else ''}"
        )


def _quaternions(context: Context) -> Iterator[str]:
    """Quaternions of which one of both begins with w, and the other ends with it."""
    rows = context.rows
    for own in quaternions(rows.unit, rows.values):
        measured, base = rows.values[:, own], context.base[:, own]
        now, *left = (_beside(measured, np.roll(base, by, axis=1)) for by in (0, 1, -1))
        if now > 0 and now >= _CLOSER**2 * min(left):
            names = ", ".join(rows.observables[own])
            where = "begins with the last of them" if left[1] < left[0] else "ends with the first of them"
            yield f"{names} is a quaternion that in the model {where}: let it give them in the order of the run"


def _beside(measured: Floats, base: Floats) -> float:
    """How far quaternions (F, 4) are from those of a model, each on its side, in squares."""
    either = [np.square(measured - sign * base).sum(axis=1) for sign in (1.0, -1.0)]
    return float(np.nansum(np.minimum(*either)))


def _backward(context: Context) -> Iterator[str]:
    """What no marker sees, and goes the other way than the model says."""
    rows = context.rows
    for unit in dict.fromkeys(rows.unit):
        alone = (rows.marker < 0) & np.isfinite(rows.values).any(axis=0)
        own = np.flatnonzero((np.array(rows.unit) == unit) & alone)
        measured, base = (
            v[:, own] - np.nanmean(v[:, own], axis=0)
            for v in (rows.values, np.where(np.isfinite(rows.values), context.base, np.nan))
        )
        now, left = (float(np.nansum((measured - sign * base) ** 2)) for sign in (1.0, -1.0))
        if now > 0 and now >= _CLOSER**2 * left:
            yield (
                f"what is measured in {unit} goes the other way than the model says: check the sign of the sensor, and "
                "of the model"
            )


def _axes(context: Context) -> Iterator[str]:
    """Markers whose axes, three of them or two, are a mirror image of the model's; those that were turned are a
    frame's, however far.
    """
    rows = context.rows
    seen_along = [np.flatnonzero((rows.axis == a) & (rows.marker >= 0)) for a in range(3)]
    letters = [a for a, each in zip("xyz", seen_along, strict=True) if len(each)]
    own = [each for each in seen_along if len(each)]
    if len(own) < 2 or len({tuple(rows.marker[each]) for each in own}) > 1 or len(own[0]) < 2:
        return
    place, d = np.stack(own, axis=1), len(own)
    measured, base = rows.values[:, place].reshape(-1, d), context.base[:, place].reshape(-1, d)
    seen = np.isfinite(measured).all(axis=1)
    if not seen.any():
        return
    # from their middle: another origin is no other axes
    x, b = (v[seen] - v[seen].mean(axis=0) for v in (measured, base))
    both = b.T @ x
    follows: dict[bool, list[tuple[float, tuple[int, ...], tuple[int, ...]]]] = {True: [], False: []}
    for order, signs in product(permutations(range(d)), product((1, -1), repeat=d)):
        mirrors = bool(np.linalg.det(np.eye(d)[list(order)]) * np.prod(signs) < 0)
        value = float(sum(s * both[j, i] for i, (j, s) in enumerate(zip(order, signs, strict=True))))
        follows[mirrors].append((value, order, signs))
    square = float((x**2).sum() + (b**2).sum())
    value, order, signs = max(follows[True])
    left, turned = (max(square - 2 * v, 0.0) for v in (value, max(follows[False])[0]))
    if turned > 0 and turned >= _CLOSER**2 * left:
        words = [("" if s > 0 else "-") + letters[j] for j, s in zip(order, signs, strict=True)]
        named, other = (f"{', '.join(each[:-1])} and {each[-1]}" for each in (letters, words))
        yield (
            f"what is measured as {named} is {other} of the model, a mirror image: the axes of one of both are named "
            "otherwise, rename them in the mapping"
        )


def _chambers(context: Context) -> Iterator[str]:
    """Chambers that move what others should: each goes to the one whose slopes, over the whole run, are nearest."""
    rows, C = context.rows, len(context.rows.chambers)
    if C < 2 or rows.n_captures < _ENOUGH * (C + 1):
        return
    spread = rows.actuation.std(axis=0)
    u = (rows.actuation - rows.actuation.mean(axis=0)) / np.where(spread > 0, spread, 1.0)
    columns = np.column_stack([np.ones(len(u)), u])
    seen = np.isfinite(rows.values).astype(float)
    square = np.linalg.pinv(np.einsum("fk,fa,fb->kab", seen, columns, columns), rcond=1e-9, hermitian=True)
    scale = motion_scale(context)
    measured, base = (
        np.einsum("kab,fb,fk->ka", square, columns, seen * np.nan_to_num(v) / scale)[:, 1:]
        for v in (rows.values, context.base)
    )
    # a slope by a chamber's own spread: of another chamber by that one's
    per = base / np.where(spread > 0, spread, 1.0)
    off = ((measured[:, :, None] - per[:, None, :] * spread[:, None]) ** 2).sum(axis=0)
    _, goes = linear_sum_assignment(off)
    moved = np.flatnonzero(goes != np.arange(C))
    now, left = float(np.trace(off)), float(off[np.arange(C), goes].sum())
    does, seen_of = (float((slope[:, moved] ** 2).sum()) for slope in (base, measured))
    if not len(moved) or now < max(_CLOSER**2 * left, _MATTERS**2 * does) or seen_of < _CLOSER**2 * left:
        return
    names = rows.chambers
    pairs = ", ".join(f"{names[c]} does what the model says of {names[goes[c]]}" for c in moved)
    yield f"{pairs}: check their hoses, and the order of the chambers in the mapping and in the model"


def _moments(context: Context) -> Iterator[str]:
    """Captures at which what the set-point before, or the one after, should do was measured."""
    rows = context.rows
    first, n = rows.first, len(rows.first)
    if context.sample_s or n < _FEWEST:
        return
    measured = capture_means(rows.values, rows.capture)[0] / motion_scale(context)
    base, session = context.base[first] / motion_scale(context), rows.session[first]
    for later, word in ((1, "before"), (-1, "after")):
        at = np.arange(n)
        use = (at - later >= 0) & (at - later < n)
        use[use] &= session[at[use] - later] == session[use]
        far = np.abs(rows.fraction[first[at[use] - later]] - rows.fraction[first[use]]).max(axis=1) >= _FAR
        use[use] &= far  # a loop as wide as a small step has the set-point before as well
        if use.sum() < _FEWEST:
            continue
        other = base[at[use] - later]
        now, left = (float(np.nansum((measured[use] - b) ** 2)) for b in (base[use], other))
        if now > 0 and now >= _CLOSER**2 * left:
            yield (
                f"what is measured at each set-point is what the model says of the one {word}: check how the "
                "pressures and the measurements were put together"
            )
