"""Least squares of fields over captures: the sums of each capture, and the jackknife over them."""

import numpy as np

from labrig._linalg import sums_of
from labrig.arrays import Floats, Ints


def by_capture(fields: Floats, left: Floats, capture: Ints, n: int) -> tuple[Floats, Floats]:
    """Normal matrices (n, Q, Q) and products (n, Q) of each of n captures.

    Of fields (Q, S, K) and values (S, K), in units of their noise; `capture` (S,) says whose each row is.
    """
    gram = sums_of(capture, np.einsum("qsk,rsk->sqr", fields, fields), n)
    return gram, sums_of(capture, np.einsum("qsk,sk->sq", fields, left), n)


def jackknife_variance(each: Floats) -> Floats:
    """Variances (Q,) from estimates (n, Q) without each of n captures (B. Efron, The Jackknife, 1982, ch. 3).

    They have in them that what is fitted is not exactly so. Infinite for fewer than two captures.
    """
    n = len(each)
    if n < 2:
        return np.full(each.shape[1], np.inf)
    return np.asarray((n - 1) / n * ((each - each.mean(axis=0)) ** 2).sum(axis=0), dtype=float)
