"""How large each effect of a model is on one run, as a multiple of what the model has."""

import numpy as np

from labrig.age._known import Beside
from labrig.arrays import Floats
from labrig.passport import by_capture, jackknife_variance

_FEWEST = 3
"""Captures from which on each observable's own offset is left out: a marker that slipped is no creep."""
_LOST = "?lost"
_LEAST_INFORMATION = 16.0
"""An effect whose size this run would say to a quarter of it, at best, or worse, is not asked for."""


def scales(beside: Beside) -> dict[str, tuple[float, float]]:
    """The multiple of each effect that fits a run best, and its standard deviation; 1 is the model's own.

    Weighted least squares of what the model leaves on what its effects do, all together, in units of the noise, with
    the jackknife's standard deviation over captures. What the sensors saw escape from the chambers is fitted beside
    them. Effects that hardly act on this run are left out.
    """
    observations = beside.observations
    seen = observations.seen
    changes = beside.changes | _lost(beside)
    names = list(changes)
    columns = [observations.whiten @ (changes[n] / observations.unit) for n in names]
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
    off = _solved(gram.sum(axis=0), product.sum(axis=0))
    each = _solved(gram.sum(axis=0) - gram, product.sum(axis=0) - product)
    sd = np.sqrt(jackknife_variance(each))
    found = {n: (1.0 + float(o), float(s)) for n, o, s in zip(names, off, sd, strict=True)}
    return {name: each for name, each in found.items() if name != _LOST}


def _lost(beside: Beside) -> dict[str, Floats]:
    """What pressure that the sensors saw escape does, by the base's own slope: it is no effect's doing but a leak's."""
    fall = beside.context.measured_fall
    if fall is None or "leak" in beside.changes:
        return {}
    return {_LOST: np.einsum("fkc,fc->fk", beside.context.jacobian, fall)}


def _solved(gram: Floats, product: Floats) -> Floats:
    """Least squares from normal equations (..., Q, Q), (..., Q); directions that nothing speaks of stay at zero."""
    return np.asarray(np.linalg.pinv(gram, rcond=1e-9, hermitian=True) @ product[..., None], dtype=float)[
        ..., 0
    ]
