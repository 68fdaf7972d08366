"""What the field says of frames and places that it was not shown, to see how far it can be trusted."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.surrogate._field import Posterior, Seen, coordinates, infer
from labrig.surrogate._unseen import apart, unseen

_FOLDS = 4
_NORMAL_95 = 1.96
_LENGTH_95 = np.array([0.0, 1.9600, 2.4477, 2.7955])
"""95 % of vectors of so many normal components, of unit deviation each, are no longer than this (chi distribution)."""
_LEAST = 1.25
"""The least factor: the process does not count that its settings are estimates."""
_Indices = NDArray[np.int64]


@dataclass(frozen=True)
class LeftOut:
    """How far off it was, and how far it took itself to be off, a quarter of frames and places left out at a time.

    Distances (J, Q), mm, along what was seen, and their expected variances, mm^2; NaN where a place was not seen, or
    nothing was left to learn from: `frames` were left out alone, or with the places (`both`). `apart` (J, Q): what the
    other places would leave of B, were they known exactly.
    """

    frames_mm: Floats
    frames_mm2: Floats
    both_mm: Floats
    both_mm2: Floats
    apart: Floats


def left_out(seen: Seen, covariance: Floats, precision: Floats, posterior: Posterior) -> LeftOut:
    """What the process says of each quarter of the frames and places from the others; see `infer` and `LeftOut`."""
    rng = np.random.default_rng(0)
    J, Q = seen.value_mm.shape[:2]
    quarters = [_quarters(rng.permutation(count) % _FOLDS) for count in (J, Q)]
    found = np.full((5, J, Q), np.nan)
    every = np.arange(Q)
    for rows, own in quarters[0]:
        found[:2, own] = _missed(seen, covariance, precision, posterior, rows, every, own, every)[:2]
        for columns, there in quarters[1]:
            part = _missed(seen, covariance, precision, posterior, rows, columns, own, there)
            found[2:, own[:, None], there] = part
    return LeftOut(*found)


def _quarters(fold: _Indices) -> list[tuple[_Indices, _Indices]]:
    """The others and each quarter itself, where there are both."""
    parts = [(np.flatnonzero(fold != f), np.flatnonzero(fold == f)) for f in range(_FOLDS)]
    return [(others, own) for others, own in parts if len(others) and len(own)]


def _missed(
    seen: Seen,
    covariance: Floats,
    precision: Floats,
    posterior: Posterior,
    rows: _Indices,
    columns: _Indices,
    own: _Indices,
    there: _Indices,
) -> Floats:
    """What frames `rows` and places `columns` say of `own` and `there`: distances, variances, and what is apart."""
    settings, part = posterior.settings, seen.part(own, there)
    a, b = coordinates(columns), coordinates(there)
    start = posterior.weights[np.ix_(rows, columns)]
    known = infer(seen.part(rows, columns), covariance[np.ix_(a, a)], precision[columns], settings, start)
    pressure, across = settings.pressure(seen.x[rows], seen.x[own]), covariance[np.ix_(a, b)]
    expected = (pressure.T @ known.weights.reshape(len(rows), -1) @ across).reshape(part.value_mm.shape)
    expected += np.tensordot(known.theta, part.directions, axes=1)
    off = np.einsum("jqab,jqb->jqa", part.known, expected - np.nan_to_num(part.value_mm))
    flat = part.directions.reshape(len(part.directions), len(own), -1)
    root = np.repeat(np.sqrt(precision[columns]), 3)[:, None]
    variance = unseen(known.grid, pressure, covariance.diagonal()[b], across * root, flat)
    along = (np.einsum("jqaa->jqa", part.known) * variance.reshape(off.shape)).sum(axis=2)
    left = apart(known.grid.spatial, covariance.diagonal()[b], across * root).reshape(-1, 3)
    open_ = np.einsum("jqaa,qa->jq", part.known, left)
    return np.where(part.used, np.stack([np.linalg.norm(off, axis=2), along, open_]), np.nan)


def rough_of(left: LeftOut) -> float:
    """Variance, mm^2, per unit of what the places leave open of B, with which most places that were left out are held.

    Nobody knows how rough the field is between places. Zero where the process alone holds them.
    """
    known = np.isfinite(left.both_mm)
    if not known.any():
        return 0.0
    missing = (left.both_mm[known] / _NORMAL_95) ** 2 - left.both_mm2[known]
    return float(max(np.quantile(missing, 0.95), 0.0) / max(left.apart[known].mean(), 1e-12))


def factor_of(left: LeftOut, seen: Seen, precision: Floats, noise_mm: float, simulated_mm: Floats) -> float:
    """By how much deviations must be larger than the process takes them to be, to hold 95 % of what was left out.

    What was left out holds the noise of what was seen there, so that it cannot show how small they may be.
    `simulated_mm` (J, Q): deviations of the forward model.
    """
    rank = np.rint(np.trace(seen.known, axis1=2, axis2=3)).astype(int)
    noise = (_LENGTH_95[rank] / _NORMAL_95 * noise_mm) ** 2 / precision
    ratio = [
        ((distance / _NORMAL_95) ** 2 - noise) / np.maximum(expected + simulated_mm**2, 1e-12)
        for distance, expected in ((left.frames_mm, left.frames_mm2), (left.both_mm, left.both_mm2))
    ]
    known = np.array(ratio)[np.isfinite(ratio)]
    return float(np.sqrt(max(np.quantile(known, 0.95), _LEAST**2))) if known.size else _LEAST
