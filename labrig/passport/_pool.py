"""Several estimates of the same thing that differ by more than their errors: a common mean, and how they scatter."""

from dataclasses import dataclass

import numpy as np

from labrig.arrays import Bools, Floats, Ints

_FEWEST = 3
"""Estimates from which on their own scatter is believed; of fewer the scatter that is stated counts, if larger."""
_WIDEST = 2.0


@dataclass(frozen=True)
class Pool:
    """A mean (Q,), its standard deviation, and the standard deviation `between` of the places about it.

    `count` (Q,): how many places said something.
    """

    mean: Floats
    sd: Floats
    between: Floats
    count: Ints

    @property
    def predicted_sd(self) -> Floats:
        """How far the next place may be from the mean, (Q,): the mean's own error, and the scatter between places.

        A scatter that comes from few places is itself unsure: then it is that of Student's t with count - 2 degrees of
        freedom, at most twice the normal one (J. P. T. Higgins, S. G. Thompson, D. J. Spiegelhalter, Journal of the
        Royal Statistical Society A 172, 2009, 137-159).
        """
        freedom = np.maximum(self.count - 2.0, 0.0)
        wider = np.where(freedom > 2, np.sqrt(freedom / np.maximum(freedom - 2.0, 1e-9)), _WIDEST)
        wider = np.where(self.count < _FEWEST, 1.0, np.minimum(wider, _WIDEST))
        return np.asarray(wider * np.hypot(self.sd, self.between), dtype=float)


def pooled(value: Floats, sd: Floats, spread: float = 0.0) -> Pool:
    """The random-effects mean of m estimates (m, Q) with standard deviations (m, Q); infinite where one says nothing.

    R. DerSimonian, N. Laird, Meta-analysis in clinical trials, Controlled Clinical Trials 7 (1986) 177-188: the scatter
    between places is (Q - (m - 1)) / (sum w - sum w^2 / sum w), w = 1 / sd^2, Q = sum w (x - mean)^2, not below zero.
    From fewer than three estimates it says little: there it is such that two places differ by `spread` or more, a share
    of the mean, or of what is usual among the Q values where that is larger: that a chamber has none of an effect here
    is no reason to expect none elsewhere.
    """
    value, sd = np.atleast_2d(value), np.atleast_2d(sd)
    w = np.where(np.isfinite(sd) & (sd > 0), 1.0 / np.maximum(sd, 1e-300) ** 2, 0.0)
    known = np.where(w > 0, value, 0.0)
    m = (w > 0).sum(axis=0)
    total = np.where(m > 0, w.sum(axis=0), 1.0)
    mean = (w * known).sum(axis=0) / total
    excess = (w * (known - mean) ** 2).sum(axis=0) - (m - 1)
    room = total - (w**2).sum(axis=0) / total
    between = np.sqrt(np.maximum(excess, 0.0) / np.where(room > 0, room, np.inf))
    least = spread * np.maximum(np.abs(mean), _usual(mean, total, m > 0)) / np.sqrt(2.0)
    between = np.maximum(between, np.where(m < _FEWEST, least, 0.0))
    w = np.where(w > 0, 1.0 / (1.0 / np.where(w > 0, w, 1.0) + between**2), 0.0)
    total = w.sum(axis=0)
    some = total > 0
    mean = np.where(some, (w * known).sum(axis=0) / np.where(some, total, 1.0), 0.0)
    return Pool(mean, np.where(some, 1.0 / np.sqrt(np.where(some, total, 1.0)), np.inf), between, m)


def _usual(mean: Floats, precision: Floats, some: Bools) -> float:
    """The root mean square of the Q values of which something is known, less what their own errors make of it."""
    beyond = np.maximum(mean**2 - 1.0 / precision, 0.0)
    return float(np.sqrt(beyond[some].mean())) if some.any() else 0.0
