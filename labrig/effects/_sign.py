"""What a plot of an effect has on its axes, so that a person sees what gives it away."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from labrig._linalg import svd
from labrig._turns import commonest_unit
from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._rows import capture_means

Names = NDArray[np.str_]

BELOW, ABOVE = "from below", "from above"
_NAMED = 3  # chambers that a plot tells apart
_NAMED_FROM = 0.3  # of the largest
_RIDGE = 1e-4
_JITTER = 0.05  # of a time in hold: what sampling alone makes of holds that are alike long
_BEGINNING = 1.3
"""Rows of a hold up to so many times its first moment are its beginning."""


@dataclass(frozen=True)
class Part:
    """One fitted effect of a model that may have others, for F rows, K observables, C chambers.

    `change` (F, K) is what it changes in the prediction; `left` (F, K) what the whole model leaves of the measured, NaN
    where nothing was seen: their sum is the residual without all other effects. `noise` (K,) of a row; `own` (F, C) is
    the change of the pressures that it stands for, where it acts on them.
    """

    form: str
    change: Floats
    left: Floats
    noise: Floats
    own: Floats | None = None
    shape: dict[str, float] = field(default_factory=dict)

    @cached_property
    def seen(self) -> Floats:
        """Change and what is left, NaN where nothing was seen, (F, K)."""
        return self.change + self.left

    @cached_property
    def weight(self) -> Floats:
        """What each value says, (F, K): 1 / noise^2, and 0 where nothing was seen."""
        return np.where(np.isfinite(self.left), 1 / np.maximum(self.noise, 1e-12) ** 2, 0.0)


@dataclass(frozen=True)
class Sign:
    """The points of a plot: where they lie, `measured` and `fitted`, what each says (`weight`), all (N,).

    A unit of `1` is none.
    """

    x_name: str
    x_unit: str
    y_name: str
    y_unit: str
    x: Floats
    measured: Floats
    fitted: Floats
    weight: Floats
    group: Names


def held(context: Context, values: Floats) -> Floats:
    """Means of the rows of each capture (F, ...) -> (N, ...), of what is not NaN."""
    return capture_means(values, context.rows.capture)[0]


def by_capture(context: Context, part: Part) -> Part:
    """The same with one row for each capture, for what does not change along the holds."""
    own = None if part.own is None else held(context, part.own)
    seen = np.where(np.isfinite(part.left), part.change, np.nan)
    change = held(context, seen)
    return Part(
        part.form,
        np.where(np.isfinite(change), change, held(context, part.change)),
        held(context, part.left),
        part.noise,
        own,
        part.shape,
    )


def onto(part: Part, direction: Floats) -> tuple[Floats, Floats, Floats]:
    """How much of `direction` (n, K) or (K,) each row is: measured, fitted, and what that says, (n,)."""
    weighted = part.weight * direction
    size = (weighted * direction).sum(axis=1)
    whole = np.where(size > 0, size, 1.0)
    measured = (weighted * np.nan_to_num(part.seen)).sum(axis=1) / whole
    fitted = (weighted * part.change).sum(axis=1) / whole
    return measured, fitted, size


def along_own(
    context: Context, part: Part, x: Floats, name: str, unit: str, group: Names | None = None
) -> Sign:
    """The size of the effect's own leading pattern over the observables, against `x` (F,) that betrays it."""
    one, x = by_capture(context, part), held(context, x)
    _, _, Vt = svd(one.change / part.noise)
    pattern = Vt[0] * part.noise
    rows = context.rows
    counted = commonest_unit(rows.unit, rows.values, context.base)
    commonest = rows.unit[int(counted[0])]
    pattern = pattern / (np.sqrt((pattern[counted] ** 2).mean()) or 1.0)
    measured, fitted, weight = onto(one, pattern)
    rising = np.ptp(x) > 0 and np.ptp(fitted) > 0.1 * np.abs(fitted).max()
    if (np.corrcoef(x, fitted)[0, 1] if rising else fitted.mean()) < 0:
        measured, fitted = -measured, -fitted
    if group is None:
        group = np.full(len(x), "")
    return Sign(
        name, unit, "size of its pattern over all observables", commonest, x, measured, fitted, weight, group
    )


def of_field(part: Part, direction: Floats, what: str, x: Floats, name: str, unit: str) -> Sign:
    """The effect as a share of `direction` (F, K), percent, against `x` (F,), row by row."""
    measured, fitted, weight = onto(part, direction)
    told = weight > 0.01 * weight.max(initial=0.0)  # rows in which the direction is hardly there say nothing
    return Sign(
        x_name=name,
        x_unit=unit,
        y_name=what,
        y_unit="%",
        x=x[told],
        measured=100 * measured[told],
        fitted=100 * fitted[told],
        weight=weight[told],
        group=np.full(int(told.sum()), ""),
    )


def of_step(context: Context, part: Part, growth: bool = False) -> Sign:
    """The effect as a share of the last change of the pressures, against the time since it.

    `growth`: what it has become since the beginning of each hold, so that what holds before have left is no matter.
    """
    rows = context.rows
    step = rows.actuation - context.previous[rows.event]
    moved = np.einsum("fkc,fc->fk", context.jacobian, step)
    what = "share of the last move"
    if growth:
        part, what = _since_the_beginning(context, part), "growth, share of the last move"
    return of_field(part, moved, what, context.elapsed_s, "time in hold", "s")


def _since_the_beginning(context: Context, part: Part) -> Part:
    """The same without what it was at the beginning of each hold."""
    time, capture = context.elapsed_s, context.rows.capture
    _, index = np.unique(capture, return_inverse=True)
    begin = np.full(int(index.max()) + 1, np.inf)
    np.minimum.at(begin, index, time)
    early = (time <= _BEGINNING * begin[index])[:, None]
    change = part.change - held(context, np.where(early, part.change, np.nan))[index]
    left = part.left - held(context, np.where(early, part.left, np.nan))[index]
    return Part(part.form, change, left, part.noise, None, part.shape)


def shows(sign: Sign, share: float = 0.3, bins: int = 12) -> bool:
    """Whether the fitted effect follows `x`: at least a share of its variance lies between neighbourhoods of x."""
    order = np.argsort(sign.x, kind="stable")
    parts = np.array_split(order, min(bins, len(order)))
    weight = np.array([sign.weight[p].sum() for p in parts])
    means = np.array([np.average(sign.fitted[p], weights=sign.weight[p]) for p in parts])
    whole = np.average(sign.fitted, weights=sign.weight)
    total = np.average((sign.fitted - whole) ** 2, weights=sign.weight)
    return bool(np.average((means - whole) ** 2, weights=weight) >= share * total)


def varies(sign: Sign) -> bool:
    """Whether there is an axis to draw along: holds that are all alike long have one time only, but for a jitter."""
    return bool(len(sign.x) and np.ptp(sign.x) > _JITTER * np.abs(sign.x).max())


def follows(sign: Sign) -> float:
    """The share of the fitted effect's variance that goes with `x` in straight lines, one for each group; 0 to 1."""
    left = whole = 0.0
    for name in np.unique(sign.group):
        x, fitted = (each[sign.group == name] for each in (sign.x, sign.fitted))
        x, fitted = x - x.mean(), fitted - fitted.mean()
        whole += float(fitted @ fitted)
        left += float(fitted @ fitted - (x @ fitted) ** 2 / max(float(x @ x), 1e-300))
    return 1.0 - left / whole if whole > 0 else 0.0


def pressures(context: Context, part: Part) -> tuple[Floats, Floats, Floats] | None:
    """The effect as a change of each chamber's pressure, row by row: measured, fitted, what it says, (F, C).

    Beside the fitted change stands what the model leaves along each chamber by itself. None where the effect is no
    change of pressures and too few observables tell the chambers apart.
    """
    J, W = context.jacobian, part.weight
    C = J.shape[2]
    gram = np.einsum("fkc,fk,fkd->fcd", J, W, J, optimize=True)
    size = np.einsum("fcc->fc", gram)
    if part.own is not None:
        own = part.own
    elif J.shape[1] >= 2 * C:
        ridge = _RIDGE * np.trace(gram, axis1=1, axis2=2)[:, None, None] / C * np.eye(C) + 1e-12 * np.eye(C)
        target = np.einsum("fkc,fk->fc", J, W * part.change)
        own = np.linalg.solve(gram + ridge, target[..., None])[..., 0]
    else:
        return None
    beside = np.einsum("fkc,fk->fc", J, W * np.nan_to_num(part.left)) / np.where(size > 0, size, 1.0)
    return own + beside, own, size


def by_chamber(
    context: Context,
    part: Part,
    x: Floats | None = None,
    name: str = "pressure of the chamber",
    unit: str | None = None,
    *,
    strokes: bool = False,
    named: bool = False,
) -> Sign:
    """The effect as an error of each chamber's pressure, against `x` (F, C), else the chamber's own pressure.

    All chambers are in it; `strokes` tells apart where each was reached from, `named` the chambers that have most.
    """
    rows = context.rows
    at = rows.actuation if x is None else x
    unit = rows.actuation_unit if unit is None else unit
    found = pressures(context, part)
    if found is None:
        mean = "mean " + name.replace("of the chamber", "of the chambers")
        turn = np.sign(context.direction[rows.event].sum(axis=1))
        group = np.where(turn > 0, BELOW, ABOVE) if strokes else np.full(len(turn), "")
        return along_own(context, part, at.mean(axis=1), mean, unit, _first(context, group))
    measured, fitted, weight = (held(context, values) for values in found)
    group = np.full(fitted.shape, "", dtype="<U64")
    keep = np.ones(fitted.shape, dtype=bool)
    if strokes:
        turn = _first(context, context.direction[rows.event])
        group[turn > 0], group[turn < 0] = BELOW, ABOVE
        keep = turn != 0
    if named and len(rows.chambers) > 1:
        size = np.sqrt((fitted**2).mean(axis=0))
        order = np.argsort(-size)
        first = [c for c in order[:_NAMED] if size[c] >= _NAMED_FROM * size[order[0]]]
        group[:] = "the others" if len(first) < len(rows.chambers) else ""
        for c in first:
            group[:, c] = rows.chambers[c]
    keep &= weight > 0.01 * weight.max(initial=0.0)
    return Sign(
        name,
        unit,
        "error as a pressure of the chamber",
        rows.actuation_unit,
        held(context, at)[keep],
        measured[keep],
        fitted[keep],
        weight[keep],
        group[keep],
    )


def _first(context: Context, values: NDArray) -> NDArray:
    """What the first row of each capture has, (F, ...) -> (N, ...)."""
    return values[context.rows.first]


def by_marker(context: Context, part: Part, axis: int | None = None, side: float = 1.0) -> Sign:
    """The effect along each marker's way, or along one axis, against how far the marker has come, all markers."""
    rows, one = context.rows, by_capture(context, part)
    moved = held(context, context.displacement)
    unit = rows.unit[int(np.flatnonzero(rows.axis >= 0)[0])] if (rows.axis >= 0).any() else rows.unit[0]
    x, y, f, w = [], [], [], []
    for m in np.unique(rows.marker):
        mine = (rows.marker == m) & (rows.axis == axis if axis is not None else True)
        for own in [np.flatnonzero(mine)] if m >= 0 else [[k] for k in np.flatnonzero(mine)]:
            if not len(own):
                continue
            length = np.linalg.norm(moved[:, own], axis=1)
            way = side * np.ones_like(moved[:, own])
            if axis is None:
                way = moved[:, own] / np.maximum(length, 1e-12)[:, None]
            known = np.isfinite(one.left[:, own]).all(axis=1)
            x.append((moved[:, own] * way).sum(axis=1)[known])
            y.append((one.seen[:, own] * way).sum(axis=1)[known])
            f.append((one.change[:, own] * way).sum(axis=1)[known])
            w.append(np.full(int(known.sum()), float(1 / np.mean(part.noise[own] ** 2))))
    letter = "" if axis is None else f" along {'-' if side < 0 else ''}{'xyz'[axis]}"
    joined = [np.concatenate(each) for each in (x, y, f, w)]
    where = letter or " along its way"
    return Sign(
        f"travel of the marker{letter}",
        unit,
        f"error of the marker{where}",
        unit,
        joined[0],
        joined[1],
        joined[2],
        joined[3],
        np.full(len(joined[0]), ""),
    )
