"""How uneven noise is: one axis of cameras, or one marker at their edge, has several times the noise of the others.

Only more noise than most have is asked for. Less would make much of small errors, which no formula is free of.
"""

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats, Ints
from labrig.effects import Rows, bulk_noise

_OF_MEDIAN = 1.36
"""Variance of the logarithm of a standard deviation that the median of n sizes gives, times n (F. R. Hampel, Journal of
the American Statistical Association 69, 1974: its efficiency is 37 %)."""
_OF_LOGARITHM = 1.5
"""Variance of the mean logarithm of the sizes of P differences between repeats that follow each other, times P: by
drawing them, 1.37 to 1.48 for 2 to 10."""
_OF_BULK = 0.01
"""Variance of the logarithm of the noise that the bulk of one axis' spectrum gives: a tenth, from eight markers on."""
_FEWEST_PAIRS = 3
"""Differences between repeats from which on they say how uneven the noise is."""
_SILENT = 1 / 3
"""Noise of rows that is a smaller part of that of means says nothing of it: something else makes that."""
_P_UNEVEN = 0.5
"""Prior probability that noise is another for some axes, for some markers, or for some observables."""
_SOME, _BY = np.meshgrid((0.03, 0.1, 0.3, 1.0), (0.25, 0.5, 1.0, 1.5))
"""How many of them have another then, and how much another (sd of its logarithm): each as likely."""


def groups_of(rows: Rows, own: NDArray[np.bool_]) -> list[Ints]:
    """What the noise of these observables (K,) may have in common: their axis, their marker, nothing; labels (k,)."""
    apart = np.arange(int(own.sum()))
    return [np.unique(labels, return_inverse=True)[1] for labels in (rows.axis[own], rows.owner[own], apart)]


def spread(values: Floats) -> float:
    """Their standard deviation, from the median of their sizes, which a few large ones do not move; 0 of none."""
    good = np.abs(values[np.isfinite(values)])
    return float(1.4826 * np.median(good)) if len(good) else 0.0


def profile(values: Floats, numbers: int, groups: list[Ints]) -> Floats:
    """How much larger the noise of each column of `values` (m, k) is than most others', (k,), one or more.

    `numbers` is how many independent ones a column has.
    """
    each = np.array([spread(column) for column in values.T])
    log = np.log(np.where(each > 0, each, np.nan))
    return np.exp(np.maximum(_pulled(log, _OF_MEDIAN / max(numbers, 1), groups), 0.0))


def profile_of_means(means: Floats, differences: Floats, within: Floats, groups: list[Ints]) -> Floats:
    """How much larger the noise of each column of captures' means (n, k) is than most others', (k,), one or more.

    What is uneven `within` holds (k,; zeros: unknown) counts as far as repeats have it, too, which differ by
    `differences` (P, k). Where rows say nothing, repeats do; without repeats, the spectrum of each axis.

    Few repeats say more of what else changed between them than hundreds of rows within holds say of the noise.
    """
    size = np.where(np.abs(differences) > 0, np.abs(differences), np.nan)
    count = np.isfinite(size).sum(axis=0)
    if count.max(initial=0) >= _FEWEST_PAIRS:
        log = np.nansum(np.log(size), axis=0) / np.where(count > 0, count, np.nan)
        variance = _OF_LOGARITHM / int(np.median(count[count > 0]))
    else:
        log, variance, groups = _log_of_axes(means, groups[0]), _OF_BULK, groups[:1]
    if within.all():
        if np.isfinite(log).any() and within.max() < _SILENT * np.exp(np.nanmedian(log)):
            return np.ones(len(within))
        known = np.maximum(np.log(within / _most(within)), 0.0)
        if len(groups) > 1:
            return np.exp(_slope(log, known) * known)
        # of axes their spectra say how far, of single markers nothing does
        axes = (np.bincount(groups[0], known) / np.bincount(groups[0]))[groups[0]]
        return np.exp(np.maximum(known + (_slope(log, axes) - 1) * axes, 0.0))
    return np.exp(np.maximum(_pulled(log, variance, groups), 0.0))


def _log_of_axes(means: Floats, axis: Ints) -> Floats:
    """Logarithms of the noise of each observable's axis (k,), from the bulk of its own spectrum; NaN where unknown."""
    out = np.full(means.shape[1], np.nan)
    for a in np.unique(axis) if len(np.unique(axis)) > 1 else ():
        size = bulk_noise(means[:, axis == a])
        out[axis == a] = np.log(size) if size > 0 else np.nan
    return out


def _pulled(log: Floats, variance: float, groups: list[Ints]) -> Floats:
    """How far logarithms (k,), known with such a variance, are from most: by group, and of what is left by the next."""
    out = np.zeros(len(log))
    for labels in groups:
        left = log - out
        known = np.isfinite(left)
        count = np.bincount(labels, known)
        mean = np.bincount(labels, np.where(known, left, 0.0)) / np.where(count > 0, count, np.nan)
        out = out + _from_most(mean, variance / np.maximum(count, 1))[labels]
    return out


def _from_most(log: Floats, variance: Floats) -> Floats:
    """How far logarithms (g,), each known with a variance of its own, are from what most have: what to expect of each
    where all are alike, or some are not. Zero of what is not known.
    """
    known = np.isfinite(log)
    if known.sum() < 2:
        return np.zeros(len(log))
    off, v = np.where(known, log - _most(log[known]), 0.0)[:, None, None], variance[:, None, None]
    alike = _log_density(off, v)
    apart = np.log(_SOME) + _log_density(off, v + _BY**2)
    either = np.logaddexp(np.log(np.maximum(1 - _SOME, 1e-300)) + alike, apart)
    # of each way to be uneven, against all of them and none
    odds = np.log(_P_UNEVEN / _SOME.size) + (either - alike)[known].sum(axis=0)
    every = np.logaddexp(np.logaddexp.reduce(odds, axis=None), np.log(1 - _P_UNEVEN))
    share = np.exp(odds - every + apart - either)
    return (share * off * _BY**2 / (_BY**2 + v)).sum(axis=(1, 2))


def _most(values: Floats) -> float:
    """What most have: their median, and the lesser of two, since the noisier one has more."""
    return float(np.quantile(values, 0.5, method="lower"))


def _slope(log: Floats, known: Floats) -> float:
    """By what power of the one the other goes, from 0 to 1; 1 where nothing says it."""
    use = np.isfinite(log)
    if not use.any():
        return 1.0
    x, y = known[use] - known[use].mean(), log[use] - log[use].mean()
    return float(np.clip((x @ y) / (x @ x), 0.0, 1.0)) if x.any() else 0.0


def _log_density(values: Floats, variance: Floats) -> Floats:
    """Of a normal distribution about zero, but for a constant that all share; SciPy's takes a second to be imported."""
    return -0.5 * (values**2 / variance + np.log(variance))
