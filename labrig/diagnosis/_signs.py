"""What can act one way only: a stop holds back, and never drives on.

A Gaussian knows no sign. But where a law is given only one of two, its evidence is what it is without, times how
probable that sign is after the data over how probable it is before, which is a half: p(y | s > 0) = p(y) p(s > 0 | y) /
p(s > 0), by Bayes. A part with the wrong sign loses by that what it has gained by its fit. Of two such parts both must
have theirs: apart each may seem to, where they are nearly the same and only their sum is known.
"""

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np
from scipy.special import log_ndtr, ndtr, ndtri

from labrig.arrays import Floats, Ints
from labrig.diagnosis._evidence import TOGETHER, State

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)
_LEAST = 1e-300
"""What is nothing; numerical."""


def log_gain(mean: Floats, sd: Floats) -> Floats:
    """By how many nats a part gains where it may act one way only: it acts by `mean` with `sd` that way."""
    return np.log(2.0) + log_ndtr(mean / np.maximum(sd, _LEAST))


def log_gain_together(mean: Floats, covariance: Floats) -> Floats:
    """By how many nats sets of parts (N, k) gain that may act one way only; of more than two the least of any two."""
    sd = np.sqrt(np.maximum(np.diagonal(covariance, axis1=1, axis2=2), _LEAST))
    if mean.shape[1] < 2:
        return log_gain(mean, sd).sum(axis=1)
    z, alike = mean / sd, covariance / (sd[:, :, None] * sd[:, None])
    pairs = combinations(range(mean.shape[1]), 2)
    return 2 * np.log(2.0) + np.min([_log_both(z[:, i], z[:, j], alike[:, i, j]) for i, j in pairs], axis=0)


def _log_both(one: Floats, two: Floats, alike: Floats) -> Floats:
    """Log probability that two numbers of unit variance, these means and this correlation are both above zero, (N,).

    The mean over the less probable one, where it is above zero, of how probable the other then is.
    """
    one, two = np.minimum(one, two), np.maximum(one, two)
    least = ndtr(one)
    above = -ndtri(np.maximum(least, _LEAST)[:, None] * (1 + _NODES) / 2)
    rest = np.sqrt(np.maximum(1.0 - alike**2, 1e-12))
    then = 0.5 * ndtr((two[:, None] + alike[:, None] * above) / rest[:, None]) @ _WEIGHTS
    both = np.log(np.maximum(least, _LEAST)) + np.log(np.maximum(then, _LEAST))
    return np.where(least < _LEAST, log_ndtr(one), both)


def gains_alone(
    state: State, sets: Sequence[Sequence[tuple[slice, float, int]]], ways: Mapping[int, Floats]
) -> Floats:
    """What each set's parts that act one way only gain together where its blocks are raised, (N,): (columns, prior sd,
    number) of each, of which those in `ways` go that way. Each set has as many such parts.

    Only a set's own columns matter to it. Of (C^-1 + D^2)^-1, their covariance with precisions D^2 less, no more than
    what is along a way is worked out (Woodbury): of many sets at a time, where columns that a set lacks have no D.
    """
    widths = np.array([sum(at.stop - at.start for at, _, _ in parts) for parts in sets])
    out, order = np.empty(len(sets)), np.argsort(widths, kind="stable")
    while len(order):
        most = max(int(TOGETHER / widths[order[-1]] ** 2), 1)
        order, some = order[:-most], order[-most:]
        out[some] = _alone(state, [sets[i] for i in some], ways, int(widths[some].max()))
    return out


def _alone(
    state: State, sets: Sequence[Sequence[tuple[slice, float, int]]], ways: Mapping[int, Floats], width: int
) -> Floats:
    """`gains_alone` of sets that have at most `width` columns."""
    several = sum(number in ways for _, _, number in sets[0])
    index: Ints = np.zeros((len(sets), width), dtype=np.int64)
    square, along = np.zeros((len(sets), width)), np.zeros((len(sets), several, width))
    for i, parts in enumerate(sets):
        begins: dict[int, int] = {}
        free = row = 0
        for at, sd, number in parts:
            size = at.stop - at.start
            if (
                first := begins.get(at.start)
            ) is None:  # else two owners have the same columns: the squares add up
                begins[at.start] = first = free
                index[i, first : first + size] = np.arange(at.start, at.stop)
                free += size
            square[i, first : first + size] += sd**2
            if number in ways:
                along[i, row, first : first + size] = ways[number]
                row += 1
    there = square > 0
    was = state.sd[index] ** -2.0
    delta = np.sqrt(np.maximum(was - np.where(there, square, np.inf) ** -1.0, 0.0) * there)
    covariance = state.covariance[index[:, :, None], index[:, None]]
    mean = state.mean[index]
    C_along = covariance @ along.transpose(0, 2, 1)
    half = delta[:, :, None] * C_along
    M = np.eye(width) - delta[:, :, None] * covariance * delta[:, None]
    more = np.linalg.solve(M, np.concatenate([(delta * mean)[:, :, None], half], axis=2))
    acts = np.concatenate([(along @ mean[:, :, None]), along @ C_along], axis=2)
    acts += half.transpose(0, 2, 1) @ more
    return log_gain_together(acts[:, :, 0], acts[:, :, 1:])
