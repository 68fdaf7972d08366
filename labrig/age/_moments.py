"""The fits of all moments of change to the runs up to each one, for one way in which scatter hangs together."""

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import logsumexp

from labrig.age._wander import whitener
from labrig.arrays import Floats, Ints

if TYPE_CHECKING:
    from labrig.age._change import Series

HAZARD = 1 / 60
"""How probable a change is from one run to the next, beforehand."""
SIZES = (2.0, 8.0, 32.0)
"""Prior standard deviations of a step, or of a slope over `SLOPE_DAYS`, in units of the scatter."""
SLOPE_DAYS = 30.0
_APART = 1e-9
"""Of the largest eigenvalue: what is less is no direction of its own."""


class Moments:
    """Least squares of whitened runs, from sums over the runs up to each one.

    Indices: `now` (n,) the last run that is known, `begin` (n,) the first after the change, shape (2,) step or slope,
    p (P,) what is fitted beside: the level of each kind, and a slope if the quantity `grows`; c (k,) components.
    """

    def __init__(self, series: "Series", grows: bool, wander: int) -> None:
        white = whitener(series.day, wander)
        x, y, z = _whitened(series, grows, white)
        zz, zy = _sums(z, z), _sums(z, y)
        zx = np.cumsum(x[..., None] * z[:, None, :], axis=1)
        inverse, rank, volume = _inverse(zz)
        off = zx @ inverse
        runs = np.arange(1, len(y) + 1)
        self.k, self.freedom = y.shape[1], runs - rank
        self.xx = np.maximum(np.cumsum(x**2, axis=1) - (off * zx).sum(axis=3), 0.0)
        self.xy = np.cumsum(x[..., None] * y[:, None, :], axis=1) - off @ zy
        self.yy = np.maximum(np.cumsum(y**2, axis=0) - (zy * (inverse @ zy)).sum(axis=1), 0.0)
        least = series.least**2 * np.cumsum((white**2).sum(axis=1)) / runs  # of scatter that doesn't wander
        whole = self.yy.sum(axis=1) + self.k * self.freedom * least
        self.tiny = 1e-12 * max(float(whole.max()), 1e-300)
        self.whole = np.maximum(whole, self.tiny)
        self.size = self.k * (np.cumsum(np.log(np.diag(white))) - 0.5 * volume)

    @property
    def unchanged(self) -> Floats:
        """The logarithm (n,) of the likelihood of the runs up to each one if nothing changed, but for a constant.

        Levels and scatter have their invariant priors.
        """
        return np.asarray(self.size - 0.5 * self.k * self.freedom * np.log(self.whole))

    def odds(self) -> Floats:
        """The logarithm (n,) of the Bayes factor, after each run, of a change at some time against none ever."""
        none_yet = np.arange(len(self.whole)) * np.log1p(-HAZARD)
        return np.asarray(np.logaddexp(np.asarray(logsumexp(self.factors, axis=(0, 2)), float), none_yet))

    @cached_property
    def factors(self) -> Floats:
        """Logarithms of the Bayes factors of each change, times its prior, (shape, now, begin)."""
        n = len(self.whole)
        now, begin = np.tril_indices(n)
        now, begin = now[begin >= 1], begin[begin >= 1]
        xx, square = self.xx[:, now, begin], (self.xy[:, now, begin] ** 2).sum(axis=2)
        power, whole = 0.5 * self.k * self.freedom[now], self.whole[now]
        each = np.full(xx.shape, -np.inf)
        for size in SIZES:
            stretch = 1.0 + size**2 * xx
            left = np.maximum(whole - size**2 / stretch * square, self.tiny)
            factor = power * np.log(whole / left) - 0.5 * self.k * np.log(stretch)
            each = np.logaddexp(each, np.where(power > 0, factor, 0.0))
        out = np.full((2, n, n), -np.inf)
        prior = np.log(HAZARD) + (begin - 1) * np.log1p(-HAZARD) - np.log(2 * len(SIZES))
        out[:, now, begin] = each + prior
        return out

    def amount(self, shape: int, begin: int, now: int) -> tuple[Floats, float]:
        """The least-squares size of a change, (k,), and the standard deviation of each component."""
        xx = max(float(self.xx[shape, now, begin]), 1e-300)
        xy = self.xy[shape, now, begin]
        left = float((self.yy[now] - xy**2 / xx).sum())
        freedom = self.k * max(int(self.freedom[now]) - 1, 1)
        return xy / xx, float(np.sqrt(max(left, 0.0) / freedom / xx))


def _whitened(series: "Series", grows: bool, white: Floats) -> tuple[Floats, Floats, Floats]:
    """Whitened: what each change does (shape, n, begin), the values (n, k), and what is fitted beside (n, P)."""
    spread = series.spread
    rows = white * (np.median(spread) / spread)
    t = (series.day - series.day[0]) / SLOPE_DAYS
    beside = [np.asarray(series.kind == kind, float) for kind in dict.fromkeys(series.kind.tolist())]
    z = rows @ np.stack([*beside, *([t] if grows else [])], axis=1)
    y = rows @ (series.value - np.median(series.value, axis=0))
    step = _later(rows)
    x = np.stack([step, _later(rows * t) - np.concatenate([t[:1], t[:-1]]) * step])
    return x, y, z


def _later(rows: Floats) -> Floats:
    """Sums of each row from each column on."""
    return np.cumsum(rows[:, ::-1], axis=1)[:, ::-1]


def _sums(one: Floats, other: Floats) -> Floats:
    """Products of columns summed over the rows up to each one, (n, a, b) of (n, a) and (n, b)."""
    return np.cumsum(one[:, :, None] * other[:, None, :], axis=0)


def _inverse(gram: Floats) -> tuple[Floats, Ints, Floats]:
    """The pseudo-inverses of n matrices (n, P, P), their ranks (n,), and the logarithms (n,) of their determinants.

    Directions of which nothing is known yet, such as the level of a programme that is still to come, count for nothing.
    """
    size, turn = np.linalg.eigh(gram)
    live = size > _APART * size[:, -1:]
    known = np.where(live, size, 1.0)
    inverse = (turn * np.where(live, 1.0 / known, 0.0)[:, None, :]) @ turn.swapaxes(1, 2)
    return inverse, live.sum(axis=1), np.log(known).sum(axis=1)
