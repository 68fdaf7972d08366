"""A prior and what runs say, put together: numbers only."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, ndtri

from labrig.arrays import Floats
from labrig.passport._data import Evidence
from labrig.passport._pool import Pool, pooled


@dataclass(frozen=True)
class Carried:
    """What came of it: `value` (Q,) and `sd` of prior and runs together; what each said; `z`, how far they are apart.

    `runs` (R, Q) are the runs' own values, `shrunk` (R, Q) the same pulled towards their common mean.
    """

    value: Floats
    sd: Floats
    prior: Pool
    data: Floats
    data_sd: Floats
    z: float
    runs: Floats
    shrunk: Floats
    between_runs: Floats


def combined(evidence: Sequence[Evidence], prior: Pool) -> Carried:
    """The runs pooled, the prior put beside them, and how far the two are apart."""
    own, sd = np.array([e.estimate for e in evidence]), np.array([e.sd for e in evidence])
    pool = pooled(own, sd) if len(evidence) > 1 else None
    between = pool.between if pool is not None else np.zeros(own.shape[1])
    information, weighted = np.zeros((own.shape[1],) * 2), np.zeros(own.shape[1])
    for each in evidence:
        H, v = _widened(each.information, each.weighted, between)
        information, weighted = information + H, weighted + v
    P = precision(prior)
    covariance = np.linalg.inv(information + P)
    value = covariance @ (weighted + P @ prior.mean)
    shrunk = own
    if pool is not None:
        T = np.diag(1.0 / np.maximum(between, 1e-9 * np.abs(value) + 1e-300) ** 2)
        shrunk = np.array([np.linalg.inv(e.information + T) @ (e.weighted + T @ value) for e in evidence])
    least = 1e-9 * max(float(np.diag(information).max()), 1e-12) * np.eye(len(value))
    data = np.linalg.inv(information + least)
    return Carried(
        value,
        np.sqrt(np.diag(covariance)),
        prior,
        data @ weighted,
        np.sqrt(np.diag(data)),
        apart(information, weighted, prior),
        own,
        shrunk,
        between,
    )


def _widened(information: Floats, weighted: Floats, between: Floats) -> tuple[Floats, Floats]:
    """What a run says of the mean of all runs: its covariance, widened by the variance between runs (Woodbury)."""
    some = between > 0
    if not some.any():
        return information, weighted
    part = information[:, some]
    core = np.linalg.inv(information[np.ix_(some, some)] + np.diag(between[some] ** -2))
    return information - part @ core @ part.T, weighted - part @ core @ weighted[some]


def apart(information: Floats, weighted: Floats, prior: Pool) -> float:
    """How far runs and prior are apart, as the number of standard deviations of as improbable a normal value.

    Directions of which the runs say nothing count for nothing.
    """
    off = weighted - information @ prior.mean
    covariance = information + information @ np.diag(prior.predicted_sd**2) @ information
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    size, turn = np.linalg.eigh(covariance / np.outer(scale, scale))
    live = size > 1e-9 * max(float(size.max()), 1e-300)
    along = (turn.T @ (off / scale))[live] / np.sqrt(size[live])
    return float(-ndtri(max(float(chdtrc(live.sum(), along @ along)), 1e-300) / 2))


def held_out(evidence: Sequence[Evidence], prior: Pool) -> list[Floats]:
    """The values (n, Q) for each capture of each run, from the prior and all the other captures."""
    P = precision(prior)
    whole = sum((e.information for e in evidence), P)
    target = sum((e.weighted for e in evidence), P @ prior.mean)
    return [
        np.array(
            [
                np.linalg.solve(whole - gram / e.inflation, target - product / e.inflation)
                for gram, product in zip(e.gram, e.product, strict=True)
            ]
        )
        for e in evidence
    ]


def fall(evidence: Sequence[Evidence], values: Sequence[Floats]) -> tuple[float, float]:
    """By how much effects with `held_out` values lower the square of each capture's error: sum, standard error."""
    falls = [
        float(2 * x @ product - x @ gram @ x)
        for e, each in zip(evidence, values, strict=True)
        for gram, product, x in zip(e.gram, e.product, each, strict=True)
    ]
    n = len(falls)
    return float(np.sum(falls)), float(np.sqrt(n) * np.std(falls, ddof=1)) if n > 1 else 0.0


def precision(prior: Pool) -> Floats:
    """The inverse covariance (Q, Q) of what a prior expects here."""
    return np.diag(1.0 / np.maximum(prior.predicted_sd, 1e-300) ** 2)
