"""How large each effect of a model is on one run, as a multiple of what the model has."""

import numpy as np

from labrig.age._known import Beside
from labrig.arrays import Floats

_FEWEST = 3
"""Captures from which on each observable's own offset is left out: a marker that slipped is no creep."""
_LEAST_INFORMATION = 16.0
"""An effect whose size this run would say to a quarter of it, at best, or worse, is not asked for."""


def scales(beside: Beside) -> dict[str, tuple[float, float]]:
    """The multiple of each effect that fits a run best, and its standard deviation; 1 is the model's own.

    Weighted least squares of what the model leaves on what its effects do, all together, in units of the noise; the
    standard deviation is the jackknife's over captures (Efron 1982, The Jackknife, ch. 3), and so it has in it that the
    effects' forms are not exact. Effects that hardly act on this run are left as they are, and left out.
    """
    observations = beside.observations
    seen = observations.seen
    names = list(beside.changes)
    columns = [observations.whiten @ (beside.changes[n] / observations.unit) for n in names]
    left = observations.values[:, seen]
    fields = np.array([column[:, seen] for column in columns]).reshape(len(names), *left.shape)
    means = observations.n_captures
    if means >= _FEWEST:
        left = left.copy()
        left[:means] -= left[:means].mean(axis=0)
        fields[:, :means] -= fields[:, :means].mean(axis=1, keepdims=True)
    acting = (fields**2).sum(axis=(1, 2)) >= _LEAST_INFORMATION
    names = [name for name, acts in zip(names, acting, strict=True) if acts]
    if not names:
        return {}
    fields = fields[acting]
    gram, product = by_capture(fields, left, observations.capture, means)
    off = solved(gram.sum(axis=0), product.sum(axis=0))
    each = solved(gram.sum(axis=0) - gram, product.sum(axis=0) - product)
    sd = jackknife_sd(each)
    return {n: (1.0 + float(o), float(s)) for n, o, s in zip(names, off, sd, strict=True)}


def by_capture(fields: Floats, left: Floats, capture: Floats, n: int) -> tuple[Floats, Floats]:
    """Normal matrices (n, Q, Q) and products (n, Q) of each capture, of fields (Q, S, K) and values (S, K)."""
    Q = len(fields)
    each_gram = np.einsum("qsk,rsk->sqr", fields, fields)
    each_product = np.einsum("qsk,sk->sq", fields, left)
    gram, product = np.zeros((n, Q, Q)), np.zeros((n, Q))
    np.add.at(gram, capture, each_gram)
    np.add.at(product, capture, each_product)
    return gram, product


def solved(gram: Floats, product: Floats) -> Floats:
    """Least squares from normal equations (..., Q, Q) and (..., Q); directions that nothing speaks of stay at zero."""
    return (np.linalg.pinv(gram, rcond=1e-9, hermitian=True) @ product[..., None])[..., 0]


def jackknife_sd(each: Floats) -> Floats:
    """Standard deviations (Q,) from estimates (n, Q) without each of n captures; infinite for fewer than two."""
    n = len(each)
    if n < 2:
        return np.full(each.shape[1], np.inf)
    return np.sqrt((n - 1) / n * ((each - each.mean(axis=0)) ** 2).sum(axis=0))
