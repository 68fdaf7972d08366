"""How uneven noise is: one axis of cameras, or one marker at their edge, has several times the noise of another."""

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.effects import Rows, bulk_noise

_OF_MEDIAN = 1.36
"""Variance of the logarithm of a standard deviation that the median of n sizes gives, times n (F. R. Hampel, Journal of
the American Statistical Association 69, 1974: its efficiency is 37 %)."""
_OF_LOGARITHM = np.pi**2 / 8
"""Variance of the logarithm of a normal number's size, whose mean is `_MEAN_LOGARITHM`."""
_MEAN_LOGARITHM = -0.635
_OF_BULK = 0.01
"""Variance of the logarithm of the noise that the bulk of one axis' spectrum gives: a tenth, from eight markers on."""
_FEWEST_PAIRS = 3
_CHANCE = 2.0
"""Standard deviations by which observables must differ more than by chance, to be taken for uneven."""


def groups_of(rows: Rows, own: np.ndarray) -> list[Ints]:
    """What the noise of these observables (K,) may have in common: their axis, their marker, nothing; labels (k,)."""
    alone = np.arange(int(own.sum()))
    marker = np.where(rows.marker[own] >= 0, rows.marker[own], len(rows.markers) + alone)
    return [np.unique(labels, return_inverse=True)[1] for labels in (rows.axis[own], marker, alone)]


def spread(values: Floats) -> float:
    """Their standard deviation, from the median of their sizes, which a few large ones do not move; 0 of none."""
    good = np.abs(values[np.isfinite(values)])
    return float(1.4826 * np.median(good)) if len(good) else 0.0


def profile(values: Floats, numbers: int, groups: list[Ints]) -> Floats:
    """How large the noise of each column of `values` (m, k) is beside the others', (k,), around one.

    `numbers` is how many independent ones a column has.
    """
    each = np.array([spread(column) for column in values.T])
    log = np.log(np.where(each > 0, each, np.nan))
    return np.exp(_pulled(log, _OF_MEDIAN / max(numbers, 1), groups))


def profile_of_means(means: Floats, differences: Floats, within: Floats, groups: list[Ints]) -> Floats:
    """The same of captures' means (n, k): what is uneven `within` holds (k,; zeros: unknown) as far as repeats have it,
    too, which differ by `differences` (P, k), and what else is uneven in these; without repeats, what each axis says.
    """
    known = np.log(within / np.median(within)) if within.all() else np.zeros(len(within))
    if np.isfinite(differences).sum(axis=0).max(initial=0) < _FEWEST_PAIRS:
        of_axes = _log_of_axes(means, groups[0])
        return np.exp(
            _slope(of_axes, known) * known if known.any() else _pulled(of_axes, _OF_BULK, groups[:1])
        )
    size = np.where(np.abs(differences) > 0, np.abs(differences), np.nan)
    count = np.isfinite(size).sum(axis=0)
    log = (
        np.where(count > 0, np.nansum(np.log(size), axis=0) / np.maximum(count, 1), np.nan) - _MEAN_LOGARITHM
    )
    alike = _slope(log, known) * known
    return np.exp(alike + _pulled(log - alike, _OF_LOGARITHM / max(int(np.median(count)), 1), groups))


def _log_of_axes(means: Floats, axis: Ints) -> Floats:
    """Logarithms of the noise of each observable's axis (k,), from the bulk of its own spectrum; NaN where unknown."""
    out = np.full(means.shape[1], np.nan)
    for a in np.unique(axis) if len(np.unique(axis)) > 1 else ():
        size = bulk_noise(means[:, axis == a])
        out[axis == a] = np.log(size) if size > 0 else np.nan
    return out


def _pulled(log: Floats, variance: float, groups: list[Ints]) -> Floats:
    """What logarithms (k,), known with such a variance, say of each group and of each within it: pulled to their mean
    by as much as they differ by chance, wholly where that is all. What is not known is at the mean.
    """
    out = np.zeros(len(log))
    for labels in groups:
        left = log - out
        known = np.isfinite(left)
        count = np.bincount(labels, known)
        mean = np.bincount(labels, np.where(known, left, 0.0)) / np.maximum(count, 1)
        out = out + _of_one_kind(np.where(count > 0, mean, np.nan), variance / np.maximum(count, 1))[labels]
    return out


def _of_one_kind(log: Floats, variance: Floats) -> Floats:
    """The same of groups (g,) that are all of one kind, each known with a variance of its own."""
    known = np.isfinite(log)
    k = int(known.sum())
    if k < 2:
        return np.zeros(len(log))
    off = np.where(known, log - np.mean(log[known]), 0.0)
    chance, between = float(variance[known].mean()), float((off**2).sum() / (k - 1))
    if between < chance * (1 + _CHANCE * np.sqrt(2 / (k - 1))):
        return np.zeros(len(log))
    return off * (between - chance) / (between - chance + variance)


def _slope(log: Floats, known: Floats) -> float:
    """By what power of the one the other goes, from 0 to 1; 1 where nothing says it."""
    use = np.isfinite(log)
    if not use.any():
        return 1.0
    x, y = known[use] - known[use].mean(), log[use] - log[use].mean()
    return float(np.clip((x @ y) / (x @ x), 0.0, 1.0)) if x.any() else 0.0
