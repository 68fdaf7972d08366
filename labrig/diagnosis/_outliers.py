"""Mistaken values: entries that neither their neighbours nor the other observables believe."""

import numpy as np
from numpy.typing import NDArray

from labrig.diagnosis._floor import capture_means
from labrig.diagnosis._spectrum import fill
from labrig.effects._rows import Floats, Ints

FORM = 0.03
"""No formula is exact: by this share of its own size a residual may be off without being wrong."""
_FAR = 8.0
_MOST_FAR = 0.2
_SMOOTH_RANK = 10
_STAYS = 4
_PULLED = 0.2


def clean(residual: Floats, capture: Ints) -> tuple[Floats, int]:
    """Drop entries that lie far from what their neighbours in time and space say; returns how many.

    Where there are several observables, "far" is against a low-rank fit of all rows (what is physical has
    low rank, a mistaken marker has not); with few, against the running median along the campaign. Captures
    and rows are looked at in turn, since a mistake may last for a whole hold or for one frame.
    """
    if len(np.unique(capture)) < 6 and len(residual) < 20:
        return residual, 0
    seen = np.isfinite(residual).any(axis=0)
    if not seen.all():
        rows = residual.copy()
        rows[:, seen], dropped = clean(residual[:, seen], capture)
        return rows, dropped
    captures, index = np.unique(capture, return_inverse=True)
    rows = np.where(_passing(_far(residual), index), np.nan, residual)
    means, _ = capture_means(rows, capture)
    if len(captures) >= 6:
        rows = np.where(_passing(_far(means), np.arange(len(captures)))[index], np.nan, rows)
    return rows, int((np.isfinite(residual) & ~np.isfinite(rows)).sum())


def _passing(far: NDArray[np.bool_], index: Ints) -> NDArray[np.bool_]:
    """Only what passes: an entry that stays far for several captures on end has moved, and is no mistake."""
    n = int(index.max()) + 1
    touched = np.zeros((n, far.shape[1]), dtype=bool)
    np.logical_or.at(touched, index, far)
    if n < _STAYS:
        return far
    whole = np.logical_and.reduce([touched[shift : n - _STAYS + 1 + shift] for shift in range(_STAYS)])
    stays = np.zeros_like(touched)
    for shift in range(_STAYS):
        stays[shift : shift + len(whole)] |= whole
    return far & ~stays[index]


def _far(values: Floats) -> NDArray[np.bool_]:
    """Which entries are far from what the others say, (n, K)."""
    if values.shape[1] >= 8 and len(values) >= 12:
        off = np.abs(values - _smooth(values))
    else:
        off = np.abs(values - _running_median(fill(values)))
    _, spread = _middle_and_spread(values)
    bad = off > _FAR * np.maximum(1.4826 * np.nanmedian(off), FORM * spread)
    if values.shape[1] >= 8:  # a mistake pulls the fit of its neighbours along a little
        bad &= off > _PULLED * np.nanmax(np.where(bad, off, 0.0), axis=1, keepdims=True)
    structure = bad.mean(axis=1) > _MOST_FAR
    return bad & ~structure[:, None] if values.shape[1] >= 8 else bad


def _middle_and_spread(values: Floats) -> tuple[Floats, Floats]:
    """Median and spread of each column; a campaign of two states, one rarer than the other, spreads over both."""
    low, middle, high = np.nanquantile(values, [0.1, 0.5, 0.9], axis=0)
    around = 1.4826 * np.nanmedian(np.abs(values - middle), axis=0)
    return middle, np.maximum(around, (high - low) / 2.563)


def _smooth(values: Floats) -> Floats:
    """A low-rank fit that outlying entries cannot pull: directions from clipped values, Huber weights by row."""
    middle, spread = _middle_and_spread(values)
    limit = 4 * np.maximum(spread, np.median(spread))
    clipped = fill(np.clip(values, middle - limit, middle + limit))
    _, _, Vt = np.linalg.svd(clipped, full_matrices=False)
    V = Vt[: min(_SMOOTH_RANK, min(values.shape) // 3)]
    known = np.where(np.isfinite(values), values, 0.0)
    w = np.isfinite(values).astype(float)
    expected = clipped @ V.T @ V
    for _ in range(6):
        off = np.abs(known - expected)
        scale = 1.4826 * np.median(off[w > 0])
        weight = np.where(w > 0, np.minimum(1.0, 2 * scale / np.maximum(off, 1e-12)), 0.0)
        H = np.einsum("rk,nk,qk->nrq", V, weight, V, optimize=True) + 1e-9 * np.eye(len(V))
        z = np.linalg.solve(H, ((weight * known) @ V.T)[:, :, None])[:, :, 0]
        expected = z @ V
    return expected


def _running_median(values: Floats, half: int = 3) -> Floats:
    """Median of the neighbours along the campaign, with the spread of the values added as slack."""
    padded = np.pad(values, ((half, half), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0)
    low, high = np.quantile(windows, [0.15, 0.85], axis=-1)
    return np.clip(values, low - (high - low), high + (high - low))
