"""What bears out an entry that looks mistaken: then it is no mistake, but something that the model lacks.

A mistake of a camera or a sensor is of one observable, at any time. What a rig does comes again where it is at the same
pressures, moves other observables as its chambers move them, or comes at certain pressures, steps, times or places
only.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats, Ints
from labrig.diagnosis._repeats import SAME
from labrig.effects import Context

Mask = NDArray[np.bool_]

_NEAREST = 8
"""How many of the nearest rows of other captures are asked."""
_WITNESSES = 3
"""How many of these must say the same."""
_NEAR = 0.1
"""How near they must be: share of the range, or decades of the time held."""
_LEANS = 0.25
"""Share of what is far that those nearest to it must be off by, the same way, for it to be but the farthest of them."""
_DECADE = 2.3
"""Natural logarithm of ten."""
_BY_CHANCE = 0.01
"""Share of campaigns, at each look, in which mistakes that come anywhere may seem to come at certain places only."""
_FEWEST = 12
"""Captures up to which only the nearest are asked: the other witnesses were measured on campaigns of 60 and more."""
_STEPS = 3
"""Steps within a hold, at least, in which something comes by and by."""
_CERTAIN = 3.0
"""Standard deviations that what the others say must be away from nothing."""
_UNSEEN = 0.01
"""Motions of the chambers of which the other observables see so little are left out."""


@dataclass(frozen=True)
class Moments:
    """What is known of n rows, or captures, beside what was measured, of C chambers and K observables.

    `pressure` and `step` (n, C): what was commanded, and by how much more than before, as shares of the range; `late`
    (n,): the time in the hold, in decades; `slopes` (n, K, C) of the base, and what it predicts, `place` (n, K);
    `owner` (K,) numbers the markers, or what else an observable belongs to, `unit` (K,) the units; `index` (n,) numbers
    the captures.
    """

    pressure: Floats
    step: Floats
    late: Floats
    slopes: Floats
    place: Floats
    owner: Ints
    unit: Ints
    index: Ints

    def of(self, observables: Mask) -> "Moments":
        """What is known of some observables (K,) only."""
        return Moments(
            self.pressure,
            self.step,
            self.late,
            self.slopes[:, observables],
            self.place[:, observables],
            self.owner[observables],
            self.unit[observables],
            self.index,
        )

    def of_captures(self) -> "Moments":
        """What is known of captures: their pressures and steps, the mean of their times."""
        first = np.unique(self.index, return_index=True)[1]
        late = np.bincount(self.index, self.late) / np.bincount(self.index)
        own = np.arange(len(first))
        pressure, step, slopes, place = (
            x[first] for x in (self.pressure, self.step, self.slopes, self.place)
        )
        return Moments(pressure, step, late, slopes, place, self.owner, self.unit, own)


def moments_of(context: Context) -> Moments:
    """What is known of a campaign's rows."""
    rows = context.rows
    pressure = rows.fraction
    step = pressure - rows.share(context.previous)[rows.event]
    late = np.log1p(context.elapsed_s) / _DECADE
    index = np.unique(rows.capture, return_inverse=True)[1]
    unit = np.unique(rows.unit, return_inverse=True)[1]
    return Moments(pressure, step, late, context.jacobian, context.base, rows.owner, unit, index)


def borne_out(values: Floats, far: Mask, at: Moments, unusual: Mask | None = None) -> Mask:
    """Which of the entries that are `far` (n, K) from what is usual are no mistakes.

    `unusual` (n, K) are all that are far, also where the whole body is: they say, too, where that is so.
    """
    if not far.any():
        return far
    if at.index.max() < _FEWEST:
        return _said_again(values, far, at)
    said, asked = _said_by_others(values, far, at)
    placed = far & _at_one_place(far if unusual is None else far | unusual, at)
    found = said | _said_again(values, far & ~asked, at) | placed | _repeated(values, far, at)
    return found | _leant(values, far & ~found, at)


def grown(values: Floats, far: Mask, at: Moments) -> Mask:
    """Which entries that are `far` came there step by step along their own hold, (n, K): a mistake comes at once.

    From the first row of the hold on, in three steps or more, none of which is more than half of the way.
    """
    out = np.zeros_like(far)
    off = _from_usual(values)
    for capture in np.unique(at.index[far.any(axis=1)]):
        rows = np.flatnonzero(at.index == capture)
        for k in np.flatnonzero(far[rows].any(axis=0)):
            seen = rows[np.isfinite(off[rows, k])]
            seen = seen[np.argsort(at.late[seen], kind="stable")]
            ends = [j for j in np.flatnonzero(far[seen, k]) if _step_by_step(off[seen[: j + 1], k])]
            out[seen[: max(ends, default=-1) + 1], k] = True
    return out & far


def _step_by_step(path: Floats) -> bool:
    """Whether values (n,) went from the first to the last in several steps, none of which is most of the way."""
    steps = np.abs(np.diff(path))
    at_once = steps.max(initial=0.0) > abs(path[-1] - path[0]) / 2 or abs(path[0]) > abs(path[-1]) / 2
    return len(steps) >= _STEPS and not at_once


def _from_usual(values: Floats) -> Floats:
    """How far values (n, K) are from the median of their observable."""
    return values - np.nanmedian(values, axis=0)


def _said_by_others(values: Floats, far: Mask, at: Moments) -> tuple[Mask, Mask]:
    """Which are nearer to what the other markers say, through the base's slopes, than to nothing; and which these can
    judge: where there are more observables of them than chambers.
    """
    said, asked = np.zeros_like(far), np.zeros_like(far)
    noise = 1.4826 * np.nanmedian(np.abs(_from_usual(values)), axis=0)
    noise = np.where(noise > 0, noise, 1.0)
    for i in np.flatnonzero(far.any(axis=1)):
        known = np.isfinite(values[i])
        x, slopes = values[i, known] / noise[known], at.slopes[i, known] / noise[known, None]
        size = np.sqrt(np.sum(slopes**2, axis=0))
        slopes = slopes[:, size > 0] / size[size > 0]
        all_of_them = slopes.T @ slopes, slopes.T @ x
        for owner in np.unique(at.owner[far[i]]):
            own = at.owner[known] == owner
            if np.sum(~own) <= slopes.shape[1]:
                continue
            there, sd = _from_others(slopes, x, own, all_of_them)
            near = np.abs(x[own] - there) < 0.5 * np.abs(x[own])
            entries = np.flatnonzero(known)[own]
            said[i, entries] = far[i, entries] & near & (np.abs(there) > _CERTAIN * sd)
            asked[i, entries] = far[i, entries]
    return said, asked


def _from_others(
    slopes: Floats, x: Floats, own: Mask, all_of_them: tuple[Floats, Floats]
) -> tuple[Floats, Floats]:
    """What the other observables say of those that are `own` (r,), by least squares, and the sd of that: all moved by x
    (r,), with slopes (r, C).

    `all_of_them`: the sums (C, C) and (C,) of the normal equations, from which the own part is taken off.
    """
    power, turn = np.linalg.eigh(all_of_them[0] - slopes[own].T @ slopes[own])
    seen = power > _UNSEEN**2 * power.max(initial=0.0)
    inverse = (turn[:, seen] / power[seen]) @ turn[:, seen].T
    moved = inverse @ (all_of_them[1] - slopes[own].T @ x[own])
    left = np.sum((x - slopes @ moved)[~own] ** 2) / (np.sum(~own) - slopes.shape[1])
    way = slopes[own] @ inverse
    return slopes[own] @ moved, np.sqrt(max(left, 1.0) * np.sum(way * slopes[own], axis=1))


def _said_again(values: Floats, far: Mask, at: Moments) -> Mask:
    """Which say what the nearest in other captures say, at one of the pressures or that time.

    One coordinate is enough: a limit is met by one chamber, and a leak seen in the long holds.
    """
    out = np.zeros_like(far)
    off = _from_usual(values)
    for i, k in np.argwhere(far):
        others = np.flatnonzero((at.index != at.index[i]) & np.isfinite(values[:, k]))
        alike = off[others, k] * np.sign(off[i, k]) > 0.5 * np.abs(off[i, k])
        for coordinate in (*at.pressure.T, at.late):
            away = np.abs(coordinate[others] - coordinate[i])
            near = np.argsort(away, kind="stable")[:_NEAREST]
            out[i, k] |= (alike[near] & (away[near] <= _NEAR)).sum() >= _WITNESSES
    return out


def _repeated(values: Floats, far: Mask, at: Moments) -> Mask:
    """Which say what most other captures of the same set-point say, in the rows nearest to that time in the hold: a
    mistake would not come again there.
    """
    off = _from_usual(values)
    out = np.zeros_like(far)
    for i in np.flatnonzero(far.any(axis=1)):
        same = (np.abs(at.pressure - at.pressure[i]) <= SAME).all(axis=1) & (at.index != at.index[i])
        away = np.where(same, np.abs(at.late - at.late[i]), np.inf)
        least = np.full(at.index.max() + 1, np.inf)
        np.minimum.at(least, at.index, away)
        same &= away <= least[at.index] + 1e-9
        alike = off[same] * np.sign(off[i]) > 0.5 * np.abs(off[i])
        out[i] = far[i] & (2 * alike.sum(axis=0) > same.sum())
    return out


def _leant(values: Floats, far: Mask, at: Moments) -> Mask:
    """Which are off the same way as those nearest to them, in place or by a pressure, that are not far themselves: laws
    are continuous, and mistakes are not.
    """
    off = _from_usual(values)
    out = np.zeros_like(far)
    for k in np.flatnonzero(far.any(axis=0)):
        known = np.isfinite(off[:, k]) & ~far[:, k]
        coordinates = np.column_stack([at.place[:, at.owner == at.owner[k]], at.pressure])
        for i in np.flatnonzero(far[:, k]):
            others = np.flatnonzero(known & (at.index != at.index[i]))
            if len(others) <= _NEAREST:
                continue
            for coordinate in coordinates.T:
                near = np.argsort(np.abs(coordinate[others] - coordinate[i]), kind="stable")[:_NEAREST]
                lean = off[others[near], k] * np.sign(off[i, k])
                sd = lean.std(ddof=1) / np.sqrt(_NEAREST)
                out[i, k] |= bool(lean.mean() > max(_LEANS * abs(off[i, k]), _CERTAIN * sd))
    return out


def _at_one_place(far: Mask, at: Moments) -> Mask:
    """Which stand at one end of the pressures, steps, times or their marker's own places, as mistakes would not.

    A wall is met where a marker is farthest out, by whichever chambers. Each observable is asked by itself, and all of
    them together for the time in a hold; what is far at other times of the same hold, too, is a mistake that lasts. How
    unlikely so many are at an end is bounded as by H. Chernoff (Ann. Math. Statist. 23 (1952) 493), over all ends,
    coordinates and observables.
    """
    out = np.zeros_like(far)
    commanded = np.column_stack([at.pressure, at.step, np.abs(at.step).max(axis=1, initial=0.0)])
    most = np.bincount(np.unique(at.owner, return_inverse=True)[1]).max()
    tests = 2 * far.shape[1] * (commanded.shape[1] + 1 + most) / _BY_CHANCE
    each = 1.0 / np.bincount(at.index)[at.index]
    ends = _shares(np.column_stack([commanded, -commanded]), each)
    place = _shares(np.column_stack([at.place, -at.place]), each)
    time = _shares(np.column_stack([at.late, -at.late]), each)
    early = np.zeros_like(far)
    for k in np.flatnonzero(far.any(axis=0)):
        rows = np.flatnonzero(far[:, k])
        own = np.flatnonzero(np.tile(at.owner == at.owner[k], 2))
        where = np.column_stack([ends[rows], place[rows][:, own]])
        out[rows, k] = _at_an_end(where, _runs(at.index[rows]), tests)
        early[rows, k] = _at_an_end(time[rows], at.index[rows], tests)
    rows = np.flatnonzero(far.any(axis=1))
    early[rows] |= far[rows] & _at_an_end(time[rows], at.index[rows], tests)[:, None]
    return out | early & ~_within_hold(far & ~early, at.index)


def _within_hold(entries: Mask, index: Ints) -> Mask:
    """Whether an observable has any of these entries (n, K) in the same capture, (n, K)."""
    found = np.zeros((index.max() + 1, entries.shape[1]), dtype=bool)
    np.logical_or.at(found, index, entries)
    return found[index]


def _shares(values: Floats, each: Floats) -> Floats:
    """The share of all rows, each counting for so much (n,), that are not above each of the values (n, q)."""
    out = np.empty_like(values)
    for own, share in zip(values.T, out.T, strict=True):
        order = np.argsort(own, kind="stable")
        total = np.cumsum(each[order]) / each.sum()
        share[:] = total[np.searchsorted(own[order], own, side="right") - 1]
    return out


def _runs(capture: Ints) -> Ints:
    """Numbers of the runs of captures, one after the other, that the captures (r,) are in: one mistake may last."""
    known, code = np.unique(capture, return_inverse=True)
    return np.asarray(np.cumsum(np.diff(known, prepend=known[0]) > 1)[code], dtype=np.int64)


def _at_an_end(share: Floats, unit: Ints, tests: float) -> Mask:
    """Which of r entries are, by one of q coordinates, at an end where too many are for chance, (r,).

    `share` (r, q): that of all rows which are as far out; units (r,) count once each, one alone says nothing.
    """
    _, unit, count = np.unique(unit, return_inverse=True, return_counts=True)
    n = len(count)
    if n < 2:
        return np.zeros(len(unit), dtype=bool)
    order = np.argsort(share, axis=0, kind="stable")
    s = np.clip(np.take_along_axis(share, order, axis=0), 1e-12, 1 - 1e-12)
    m = np.clip(np.cumsum(1.0 / count[unit][order], axis=0) / n, 1e-12, 1 - 1e-12)
    unlikely = n * (m * np.log(m / s) + (1 - m) * np.log((1 - m) / (1 - s)))
    last = np.diff(s, axis=0, append=2.0) > 0
    unlikely = np.where(last & (m > s), unlikely, 0.0)
    best = np.argmax(unlikely, axis=0)[None]
    enough = np.take_along_axis(unlikely, best, axis=0) > np.log(n * tests)
    return ((share <= np.take_along_axis(s, best, axis=0)) & enough).any(axis=1)
