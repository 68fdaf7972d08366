"""Whether a quantity has changed, asked again after every run: a Bayes factor that bounds false alarms at any moment.

Null: a level for each kind of run, and normal scatter of unknown size, independent from run to run. Against it: from
some run on another level (a step), or a growth at a constant rate (a slope). The step or slope has a normal prior in
units of the scatter; levels and scatter have their invariant priors. So the weighted mean of the Bayes factors over the
moments of change is a martingale under the null, and by Ville's inequality (1939) it ever exceeds 1/alpha with a
probability of alpha at most, however often one looks. (T. L. Lai, Ann. Statist. 4, 1976, 265-280; H. Wang, A. Ramdas,
Sequential Analysis, 2025, arXiv:2310.03722. The prior of the moment is that of A. N. Shiryaev, Theory Probab. Appl. 8,
1963, 22-46.)

A change has to pass twice: so, and under the likeliest way in which scatter may wander from run to run (`_wander`). The
second makes it rarer still. Each way is judged with a change allowed for, so that a step does not pass for a wander.

A small variance of every run is added to both sums of squares: that makes every factor smaller, and keeps readings that
never differ from making a change of the least difference.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from labrig.age._moments import Moments
from labrig.age._wander import WANDERS
from labrig.arrays import Floats

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
    `alpha` at most if scatter is independent from run to run.
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
    begin = np.arange(n)
    passed = False
    for now, odds, each, moments in _passing(series, grows, limit):
        by_shape = np.exp(each - logsumexp(each))
        by_moment = by_shape.sum(axis=0)
        passed = now == n - 1
        if by_moment[begin <= now + 1 - FEWEST_AFTER].sum() < 0.5:
            continue
        shape, begins = (int(at) for at in np.unravel_index(int(np.argmax(by_shape)), by_shape.shape))
        share = np.cumsum(by_moment)
        first, last = np.searchsorted(share, [(1 - LIKELY) / 2, (1 + LIKELY) / 2])
        amount, sd = moments.amount(shape, begins, now)
        name = ("step", "slope")[shape]
        return Change(name, begins, int(first), int(min(last, n - 1)), now, amount, sd, odds), False
    return None, passed


def _passing(series: Series, grows: bool, limit: float) -> Iterator[tuple[int, float, Floats, Moments]]:
    """The runs after which the odds of a change pass the limit if nothing wanders, and if the likeliest does that may.

    Each with the odds, their parts (shape, begin), and the fits: those of the likeliest way to wander, by the runs up
    to there, changed or not.
    """
    known = [Moments(series, grows, 0)]
    passing = np.flatnonzero(known[0].odds() >= limit)
    if not len(passing):
        return
    known += [Moments(series, grows, wander) for wander in range(1, len(WANDERS))]
    odds = np.array([each.odds() for each in known])
    likeliest = np.argmax(odds + [each.unchanged for each in known], axis=0)
    for now in passing.tolist():
        own = int(likeliest[now])
        if odds[own, now] >= limit:
            yield now, float(odds[own, now]), known[own].factors[:, now], known[own]
