"""What can act one way only: a stop holds back, and never drives on.

A Gaussian knows no sign. But where a law is given only one of two, its evidence is what it is without, times how
probable that sign is after the data over how probable it is before, which is a half: p(y | s > 0) = p(y) p(s > 0 | y) /
p(s > 0), by Bayes. A part with the wrong sign loses by that what it has gained by its fit. Of two such parts both must
have theirs: apart each may seem to, where they are nearly the same and only their sum is known.
"""

from itertools import combinations

import numpy as np
from scipy.special import log_ndtr, ndtr, ndtri

from labrig.arrays import Floats

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)
_LEAST = 1e-300


def log_gain(mean: Floats, sd: Floats) -> Floats:
    """By how many nats a part gains where it may act one way only: it acts by `mean` with `sd` that way."""
    return np.log(2.0) + log_ndtr(mean / np.maximum(sd, _LEAST))


def log_gain_together(mean: Floats, covariance: Floats) -> float:
    """The same of some parts (k,), each of which may act one way only; of more than two the least gain of any two."""
    sd = np.sqrt(np.maximum(np.diag(covariance), _LEAST))
    z, alike = mean / sd, covariance / np.outer(sd, sd)
    if len(z) < 2:
        return float(log_gain(mean, sd).sum())
    return min(
        2 * np.log(2.0) + _log_both(z[i], z[j], alike[i, j]) for i, j in combinations(range(len(z)), 2)
    )


def _log_both(one: float, two: float, alike: float) -> float:
    """Log probability that two numbers of unit variance, these means and this correlation are both above zero.

    The mean over the less probable one, where it is above zero, of how probable the other then is.
    """
    one, two = sorted((float(one), float(two)))
    least = float(ndtr(one))
    if least < _LEAST:
        return float(log_ndtr(one))
    above = -ndtri(least * (1 + _NODES) / 2)
    rest = np.sqrt(max(1.0 - alike**2, 1e-12))
    then = 0.5 * float(_WEIGHTS @ ndtr((two + alike * above) / rest))
    return float(np.log(least) + np.log(max(then, _LEAST)))
