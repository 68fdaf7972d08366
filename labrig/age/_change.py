"""Whether a quantity has changed, asked again after every run: a Bayes factor that bounds false alarms at any moment.

Null: a level for each kind of run, and normal scatter of unknown size. Against it: from some run on another level (a
step), or a growth at a constant rate (a slope). The step or slope has a normal prior in units of the scatter; levels
and scatter have their invariant priors. So the weighted mean of the Bayes factors over the moments of change is a
martingale under the null, and by Ville's inequality (1939) it ever exceeds 1/alpha with a probability of alpha at most,
however often one looks. (T. L. Lai, Ann. Statist. 4, 1976, 265-280; H. Wang, A. Ramdas, Sequential Analysis, 2025,
arXiv:2310.03722. The prior of the moment is that of A. N. Shiryaev, Theory Probab. Appl. 8, 1963, 22-46.)

A small variance of every run is added to both sums of squares: that makes every factor smaller, and keeps readings that
never differ from making a change of the least difference.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from labrig.arrays import Floats

HAZARD = 1 / 60
"""How probable a change is from one run to the next, beforehand."""
SIZES = (2.0, 8.0, 32.0)
"""Prior standard deviations of a step, or of a slope over `SLOPE_DAYS`, in units of the scatter."""
SLOPE_DAYS = 30.0
FEWEST_AFTER = 2
"""Runs that have to show a change: one that is odd by itself is no change."""
LIKELY = 0.9
_LEAST = 0.2


@dataclass(frozen=True)
class Series:
    """A quantity over runs in order of time: `day` (n,), `value` (n, k), `sd` (n,), `kind` (n,) of each run."""

    day: Floats
    value: Floats
    sd: Floats
    kind: NDArray[np.str_]

    def part(self, start: int) -> "Series":
        """The runs from one on."""
        return Series(self.day[start:], self.value[start:], self.sd[start:], self.kind[start:])

    @property
    def least(self) -> float:
        """A scatter that is surely there: a part of what a run says of itself, where known."""
        known = self.sd[np.isfinite(self.sd) & (self.sd > 0)]
        return _LEAST * float(np.median(known)) if known.size else 0.0

    @property
    def spread(self) -> Floats:
        """What each run counts for, (n,): the usual standard deviation of its kind, or its own where that is larger."""
        out = np.ones(len(self.day))
        for kind in np.unique(self.kind):
            own = self.kind == kind
            known = self.sd[own][np.isfinite(self.sd[own])]
            usual = float(np.median(known)) if known.size else np.nan
            out[own] = np.fmax(self.sd[own], usual)
        some = np.isfinite(out) & (out > 0)
        return np.where(some, out, np.median(out[some]) if some.any() else 1.0)


@dataclass(frozen=True)
class Change:
    """A change: the run that it begins at, the first run after which it was sure, and how large it is.

    `first`..`last`: the runs among which it begins, at 90 %. `amount` (k,) and `sd`: the step, or the slope in
    `SLOPE_DAYS` days. `odds`: the logarithm of the Bayes factor when it was noticed.
    """

    shape: str
    begins: int
    first: int
    last: int
    noticed: int
    amount: Floats
    sd: float
    odds: float

    def later(self, runs: int) -> "Change":
        """The same change, where so many runs come before those that it was found in."""
        at = {name: getattr(self, name) + runs for name in ("begins", "first", "last", "noticed")}
        return replace(self, **at)


@dataclass(frozen=True)
class Found:
    """The changes of a series in order, and whether its last run looks like another one, which no other confirms."""

    changes: tuple[Change, ...]
    unconfirmed: bool


def changes(series: Series, alpha: float) -> Found:
    """Every change that shows in a series; each is found as it would have been the first time it was sure.

    After a change the level (after a slope the slope too) is learnt anew. The chance of a false one, at any time, is
    `alpha` at most.
    """
    found: list[Change] = []
    start, grows, odd = 0, False, False
    while True:
        limit = -np.log(alpha / ((len(found) + 1) * (len(found) + 2)))
        change, odd = _first(series.part(start), grows, limit)
        if change is None:
            return Found(tuple(found), odd)
        found.append(change.later(start))
        start, grows = found[-1].begins, change.shape == "slope"


def _first(series: Series, grows: bool, limit: float) -> tuple[Change | None, bool]:
    """The first change whose odds pass the limit and which enough runs show; else whether the last run passes alone."""
    n = len(series.day)
    if n < FEWEST_AFTER + 2:
        return None, False
    moments = _Moments(series, grows)
    odds, each = moments.odds()
    begin = np.arange(n)
    passed = False
    for now in np.flatnonzero(odds >= limit):
        weight = np.exp(each[:, :, now, :] - logsumexp(each[:, :, now, :]))
        by_moment = weight.sum(axis=(0, 1))
        passed = bool(now == n - 1)
        if by_moment[begin <= now + 1 - FEWEST_AFTER].sum() < 0.5:
            continue
        by_shape = weight.sum(axis=1)
        shape, begins = np.unravel_index(int(np.argmax(by_shape)), by_shape.shape)
        share = np.cumsum(by_moment)
        first, last = np.searchsorted(share, [(1 - LIKELY) / 2, (1 + LIKELY) / 2])
        amount, sd = moments.amount(int(shape), int(begins), int(now))
        name = ("step", "slope")[int(shape)]
        change = Change(
            name, int(begins), int(first), int(min(last, n - 1)), int(now), amount, sd, float(odds[now])
        )
        return change, False
    return None, passed


class _Moments:
    """Sums over the runs up to each one, from which the fits of all moments of change at all times follow at once.

    Indices: `now` (n,) the last run that is known, `begin` (n,) the first after the change, c (k,) components.
    """

    def __init__(self, series: Series, grows: bool) -> None:
        spread = series.spread
        weight = (np.median(spread) / spread) ** 2
        self.least = series.least**2
        t = (series.day - series.day[0]) / SLOPE_DAYS
        y = series.value - np.median(series.value, axis=0)
        self.kinds = [series.kind == kind for kind in dict.fromkeys(series.kind.tolist())]
        n, k = y.shape
        self.n, self.k = n, k
        origin = np.concatenate([t[:1], t[:-1]])
        seen = np.stack([np.cumsum(own) > 0 for own in self.kinds])
        self.freedom = np.arange(1, n + 1) - seen.sum(axis=0) - (1 if grows else 0)
        shapes = 2
        self.xx = np.zeros((shapes, n, n))
        self.xy = np.zeros((shapes, n, n, k))
        self.yy = np.zeros((n, k))
        xt, tt, ty = np.zeros((shapes, n, n)), np.zeros(n), np.zeros((n, k))
        for own in self.kinds:
            w = weight * own
            sums = {
                "w": np.cumsum(w), "t": np.cumsum(w * t), "tt": np.cumsum(w * t * t),
                "y": np.cumsum(w[:, None] * y, axis=0), "ty": np.cumsum((w * t)[:, None] * y, axis=0),
                "yy": np.cumsum(w[:, None] * y * y, axis=0),
            }  # fmt: skip
            total = np.where(sums["w"] > 0, sums["w"], 1.0)
            after = {name: _after(s) for name, s in sums.items() if name != "yy"}
            o = origin[None, :]
            x = (after["w"], after["t"] - o * after["w"])
            xx = (after["w"], after["tt"] - 2 * o * after["t"] + o**2 * after["w"])
            xy = (after["y"], after["ty"] - o[..., None] * after["y"])
            x_t = (after["t"], after["tt"] - o * after["t"])
            for s in range(shapes):
                self.xx[s] += xx[s] - x[s] ** 2 / total[:, None]
                self.xy[s] += xy[s] - x[s][..., None] * (sums["y"] / total[:, None])[:, None, :]
                xt[s] += x_t[s] - x[s] * (sums["t"] / total)[:, None]
            self.yy += sums["yy"] - sums["y"] ** 2 / total[:, None]
            tt += sums["tt"] - sums["t"] ** 2 / total
            ty += sums["ty"] - sums["t"][:, None] * sums["y"] / total[:, None]
        if grows:
            some = np.where(tt > 1e-12, tt, np.inf)
            self.xx -= xt**2 / some[None, :, None]
            self.xy -= xt[..., None] * (ty / some[:, None])[None, :, None, :]
            self.yy -= ty**2 / some[:, None]
        self.xx = np.maximum(self.xx, 0.0)
        self.yy = np.maximum(self.yy, 0.0)

    def odds(self) -> tuple[Floats, Floats]:
        """Logarithms: of the weighted Bayes factor after each run (n,), and of its parts (shape, size, now, begin)."""
        n, k = self.n, self.k
        freedom = np.maximum(self.freedom, 0)[None, :, None]
        whole = self.yy.sum(axis=1) + k * np.maximum(self.freedom, 0) * self.least
        tiny = 1e-12 * max(float(whole.max()), 1e-300)
        parts = np.full((2, len(SIZES), n, n), -np.inf)
        begin, now = np.arange(n)[None, :], np.arange(n)[:, None]
        prior = np.log(HAZARD) + (begin - 1) * np.log1p(-HAZARD) - np.log(2 * len(SIZES))
        inside = (begin >= 1) & (begin <= now)
        for i, size in enumerate(SIZES):
            stretch = 1.0 + size**2 * self.xx
            explained = size**2 / stretch * (self.xy**2).sum(axis=3)
            left = np.maximum(whole[None, :, None] - explained, tiny)
            ratio = np.log(np.maximum(whole, tiny))[None, :, None] - np.log(left)
            factor = -0.5 * k * np.log(stretch) + 0.5 * k * freedom * ratio
            factor = np.where(freedom > 0, factor, 0.0)
            parts[:, i] = np.where(inside, factor + prior, -np.inf)
        none_yet = np.arange(n) * np.log1p(-HAZARD)
        changed = np.asarray(logsumexp(parts, axis=(0, 1, 3)), dtype=float)
        total = np.logaddexp(changed, none_yet)
        return total, parts

    def amount(self, shape: int, begin: int, now: int) -> tuple[Floats, float]:
        """The least-squares size of a change, (k,), and the standard deviation of each component."""
        xx = max(float(self.xx[shape, now, begin]), 1e-300)
        xy = self.xy[shape, now, begin]
        left = float((self.yy[now] - xy**2 / xx).sum())
        freedom = self.k * max(int(self.freedom[now]) - 1, 1)
        return xy / xx, float(np.sqrt(max(left, 0.0) / freedom / xx))


def _after(cumulative: Floats) -> Floats:
    """Sums over the runs from `begin` up to `now`, (now, begin, ...), from cumulative sums (n, ...)."""
    before = np.concatenate([np.zeros_like(cumulative[:1]), cumulative[:-1]])
    out = cumulative[:, None] - before[None, :]
    n = len(cumulative)
    later = np.arange(n)[None, :] > np.arange(n)[:, None]
    out[later] = 0.0
    return out
