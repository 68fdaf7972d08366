"""Mistaken values: entries far from what their neighbours and the other observables say, which nothing bears out."""

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig._gaps import filled
from labrig._linalg import svd
from labrig.arrays import Floats, Ints
from labrig.diagnosis._witnesses import Moments, borne_out, grown, moments_of
from labrig.effects import Context, capture_means

FORM = 0.03
"""No formula is exact: by this share of its own size a residual may be off without being wrong."""
_FAR = 8.0
"""How many times as far off as usual an entry is that looks mistaken."""
_MOST_FAR = 0.2
"""Share of the markers, or of the observables, from which on it is the body that is elsewhere."""
_AT_ONCE = 2
"""How many markers may be mistaken in the same row; of more it is the body that is elsewhere."""
_SMOOTH_RANK = 10
"""Directions of the fit that entries are compared with."""
_STAYS = 4
"""Captures on end from which on what is far has moved, and is no mistake."""
_BESIDE = 5
"""Neighbours before and after that a row is compared with."""
_MISTAKEN = 2
"""How many of the neighbours may be mistaken themselves, on either side."""
_FAR_FROM_NEIGHBOURS = 4.0
"""How many times as far off as usual an entry is, beside its neighbours, that looks mistaken."""
_AROUND = 2
"""Rows of a hold before and after that a row is compared with."""
_LONG = 6
"""Rows of a hold from which on it is compared with all longer ones."""
_TO_TELL = 3
"""Rows of a hold, at least, of which one can be told to be mistaken."""
_RARE = 3.0
"""What goes beyond nine in ten at the same place of a hold by so much is rare there."""
_PULLED = 0.2
"""Share of the farthest entry of a row up to which another may be off because that one pulls the fit."""


def clean(context: Context) -> tuple[Floats, int]:
    """The base's residual (F, K) without the entries far from what their neighbours in time and space say; how many.

    Where there are several observables, "far" is against a low-rank fit of all rows (what is physical has low rank, a
    mistaken marker has not); with few, against the neighbours along the campaign. Rows, rows within their holds (where
    noise is smaller) and captures are looked at in turn, since a mistake may last for a whole hold or for one frame.
    What is borne out stays. Captures in which other effects are ruled out are looked at by themselves: what is gone
    there is no mistake where it is not. Raises `LabrigError` where nothing is left to compare, as where all markers are
    swapped.
    """
    if not np.isfinite(context.residual).any():
        why = ("the model predicts nothing of what was measured", *context.rows.warnings)[-1]
        raise LabrigError(f"nothing is left of the run that could be compared: {why}")
    residual, dropped = np.full_like(context.residual, np.nan), 0
    for own in _alike(context):
        some = context.thin(own) if len(own) < len(residual) else context
        residual[own], lost = _clean(some.residual, moments_of(some))
        dropped += lost
    return residual, dropped


def _alike(context: Context) -> list[Ints]:
    """The rows of captures in which the same effects are ruled out, group by group."""
    names = context.rows.ruled_out or (frozenset[str](),) * context.rows.n_captures
    number = {own: i for i, own in enumerate(dict.fromkeys(names))}
    group = np.array([number[own] for own in names])[context.rows.capture]
    return [np.flatnonzero(group == g) for g in np.unique(group)]


def _clean(residual: Floats, at: Moments) -> tuple[Floats, int]:
    """`clean` for rows in which the same effects are ruled out."""
    captures = int(at.index.max()) + 1
    if captures < 6 and len(residual) < 20:
        return residual, 0
    seen = np.asarray(np.isfinite(residual).any(axis=0))
    if not seen.all():
        rows = residual.copy()
        rows[:, seen], dropped = _clean(residual[:, seen], at.of(seen))
        return rows, dropped
    far, unusual = _far(residual, at)
    far = _passing(far, at.index)
    borne = borne_out(residual, far, at, unusual) | grown(residual, far, at)
    rows = _without(residual, far & ~borne, at)
    means, _ = capture_means(rows, at.index)
    far = _far_in_hold(rows, at.index)
    again = borne_out(rows - means[at.index], far, at)
    rows = _without(rows, far & ~again, at)
    if captures >= 6:
        means, _ = capture_means(np.where(borne | again, np.nan, rows), at.index)
        held = at.of_captures()
        far, unusual = _far(means, held)
        far = _passing(far, held.index)
        came = np.zeros_like(far)
        np.logical_or.at(came, at.index, grown(rows, far[at.index], at))
        kept = _without(means, far & ~(came | borne_out(means, far, held, unusual)), held)
        rows = np.where((np.isfinite(means) & np.isnan(kept))[at.index], np.nan, rows)
    return rows, int((np.isfinite(residual) & ~np.isfinite(rows)).sum())


def _without(values: Floats, mistaken: NDArray[np.bool_], at: Moments) -> Floats:
    """The values (n, K), NaN where they are mistaken: a marker's in all its axes."""
    same = at.owner[:, None] == at.owner
    return np.where(mistaken @ same, np.nan, values)


def _passing(far: NDArray[np.bool_], index: Ints) -> NDArray[np.bool_]:
    """The far entries (n, K) that pass: one that is far for several captures on end has moved, and is no mistake."""
    n = int(index.max()) + 1
    if n < _STAYS:
        return far
    touched = np.zeros((n, far.shape[1]), dtype=bool)
    np.logical_or.at(touched, index, far)
    runs = np.logical_and.reduce([touched[shift : n - _STAYS + 1 + shift] for shift in range(_STAYS)])
    stays = np.zeros_like(touched)
    for shift in range(_STAYS):
        stays[shift : shift + len(runs)] |= runs
    return far & ~stays[index]


def _far(values: Floats, at: Moments) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which entries (n, K) are far from what the others say: those that look mistaken, and all of them.

    Observables of several units are compared as shares of what is usual in each. Where many observables are far at
    once, or several markers, it is the body that is elsewhere, and none looks mistaken. The fit of few observables
    follows a mistaken one, so there the rows before and after are asked, too.
    """
    _, spread = _middle_and_spread(values)
    if values.shape[1] < 8 or len(values) < 12:
        far = _far_from_neighbours(values, spread, at.unit)
        return far & ~_of_most(far, at)[:, None], far
    usual = np.array([np.median(spread[at.unit == unit]) for unit in at.unit])
    usual[usual == 0] = 1.0
    off = np.abs(values / usual - _smooth(values / usual))
    bad = off > _FAR * np.maximum(_noise(off), FORM * spread / usual)
    # a mistake pulls the fit of its neighbours along a little
    bad &= off > _PULLED * np.nanmax(np.where(bad, off, 0.0), axis=1, keepdims=True)
    same = at.owner == np.unique(at.owner)[:, None]
    most = max(_MOST_FAR * len(same), _AT_ONCE)

    def is_body(far: NDArray[np.bool_]) -> NDArray[np.bool_]:
        return (far @ same.T).sum(axis=1) > most  # markers that are far in any axis

    far = bad & ~(is_body(bad) | (bad.mean(axis=1) > _MOST_FAR))[:, None]
    if values.shape[1] >= 3 * _SMOOTH_RANK:
        return far, bad
    beside = _far_from_neighbours(values, spread, at.unit)
    return far | beside & ~is_body(beside)[:, None], bad | beside


def _of_most(far: NDArray[np.bool_], at: Moments) -> NDArray[np.bool_]:
    """Where a whole capture is far in most sensors, in two at least, (n,): what spoils one spoils no other for so long,
    so it is the body that is elsewhere.
    """
    owners, owner = np.unique(at.owner, return_inverse=True)
    of_owner = far @ (owner[:, None] == np.arange(len(owners)))
    rows = np.bincount(at.index)
    whole = np.stack([np.bincount(at.index, own > 0) for own in of_owner.T], axis=1) == rows[:, None]
    most = whole.sum(axis=1) > max(len(owners) / 2, 1)
    return most[at.index]


def _far_in_hold(values: Floats, index: Ints) -> NDArray[np.bool_]:
    """Which entries are far from the rows around them in their own hold, (n, K).

    "Far" is against the noise between neighbouring rows, against how much the five rows around differ from each other,
    and against what that place in a hold usually is off by: what changes along a hold is no mistake.
    """
    off, usual = np.zeros_like(values), np.zeros_like(values)
    if np.bincount(index).max() < _TO_TELL:
        return off > 0
    place = np.zeros(len(values), dtype=int)
    steps = []
    for own in np.split(np.argsort(index, kind="stable"), np.cumsum(np.bincount(index))[:-1]):
        n, width = len(own), min(len(own), 2 * _AROUND + 1)
        steps.append(np.diff(values[own], axis=0))
        i = np.arange(n)
        around = values[own][np.clip(i - _AROUND, 0, n - width)[:, None] + np.arange(width)]
        middle = _median(around)
        told = np.isfinite(around).sum(axis=1) >= _TO_TELL
        off[own] = np.where(told, np.nan_to_num(np.abs(values[own] - middle)), 0.0)
        usual[own] = np.nan_to_num(_median(np.abs(around - middle[:, None])))
        ends = np.minimum(i, _AROUND), np.minimum(i[::-1], _AROUND)
        place[own] = np.ravel_multi_index(
            (*ends, np.full(n, min(n, _LONG))), (_AROUND + 1, _AROUND + 1, _LONG + 1)
        )
    noise = 1.4826 / np.sqrt(2) * np.nan_to_num(_median(np.abs(np.concatenate(steps))[None]))[0]
    limit = _FAR * np.maximum(noise, usual)
    for where in np.unique(place):
        here = place == where
        limit[here] = np.maximum(limit[here], _RARE * np.quantile(off[here], 0.9, axis=0))
    return off > limit


def _median(values: Floats) -> Floats:
    """Median over the second axis of what was seen, (n, r, K) to (n, K); NaN where nothing was."""
    count = np.isfinite(values).sum(axis=1, keepdims=True)
    order = np.sort(values, axis=1)
    low, high = (
        np.take_along_axis(order, np.maximum(at, 0), axis=1) for at in ((count - 1) // 2, count // 2)
    )
    return ((low + high) / 2)[:, 0]


def _middle_and_spread(values: Floats) -> tuple[Floats, Floats]:
    """Median and spread of each column; a campaign of two states, one rarer than the other, spreads over both."""
    low, middle, high = np.nanquantile(values, [0.1, 0.5, 0.9], axis=0)
    around = 1.4826 * np.nanmedian(np.abs(values - middle), axis=0)
    return middle, np.maximum(around, (high - low) / 2.563)


def _smooth(values: Floats) -> Floats:
    """A low-rank fit that outlying entries cannot pull: directions from clipped values, Huber weights by row."""
    middle, spread = _middle_and_spread(values)
    limit = 4 * np.maximum(spread, np.median(spread))
    clipped = filled(np.clip(values, middle - limit, middle + limit))
    _, _, Vt = svd(clipped)
    V = Vt[: min(_SMOOTH_RANK, min(values.shape) // 3)]
    known = np.where(np.isfinite(values), values, 0.0)
    w = np.isfinite(values).astype(float)
    expected = clipped @ V.T @ V
    for _ in range(6):
        off = np.abs(known - expected)
        scale = _noise(np.where(w > 0, off, np.nan))
        weight = np.where(w > 0, np.minimum(1.0, 2 * scale / np.maximum(off, 1e-12)), 0.0)
        H = np.einsum("rk,nk,qk->nrq", V, weight, V, optimize=True) + 1e-9 * np.eye(len(V))
        z = np.linalg.solve(H, ((weight * known) @ V.T)[:, :, None])[:, :, 0]
        expected = z @ V
    return expected


def _noise(off: Floats) -> Floats:
    """How noisy each column is by how far (n, K) it is off: as most are, or by its own median where that is more."""
    return 1.4826 * np.maximum(np.nanmedian(off), np.nanmedian(off, axis=0))


def _far_from_neighbours(values: Floats, spread: Floats, unit: Ints) -> NDArray[np.bool_]:
    """Which lie outside of what those before and after them say, by much more than these differ from each other: in the
    observable, and in most of its `unit` (K,), since few neighbours say little of one by itself.
    """
    padded = np.pad(filled(values), ((_BESIDE, _BESIDE), (0, 0)), mode="edge")
    windows = np.sort(np.lib.stride_tricks.sliding_window_view(padded, 2 * _BESIDE + 1, axis=0), axis=-1)
    low, middle, high = (windows[..., i] for i in (_MISTAKEN, _BESIDE, -1 - _MISTAKEN))
    usual = 1.4826 * np.nanmedian(np.abs(values - middle), axis=0)
    usual = np.maximum(usual, [np.nanmedian(usual[unit == own]) for own in unit])
    off = np.abs(values - np.clip(values, 2 * low - high, 2 * high - low))
    return off > _FAR_FROM_NEIGHBOURS * np.maximum(usual, FORM * spread)
