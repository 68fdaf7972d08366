"""What some free patterns take of the observations when they may be larger, beside all others at their small size."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from labrig.arrays import Floats
from labrig.diagnosis._constants import NEGLIGIBLE

if TYPE_CHECKING:
    from labrig.diagnosis._evidence import Sums


@dataclass(frozen=True)
class Taken:
    """What is taken off the normal equations: rows' rows (k, P) of A, rows' `values` of b, and `square` of the square,
    which counts `values` (k,) and what the data say next to nothing about; the log determinant grows by `logdet`.
    """

    rows: Floats
    values: Floats
    square: float
    logdet: float


def taken(sums: "Sums", before: Floats, after: Floats) -> Taken:
    """What is taken when prior variances (g, r) of free regressors grow from one to the other.

    Each direction by itself: with C the observations' covariance before, G the regressors that grow and D by how much,
    C^-1 falls by C^-1 G (D^-1 + G' C^-1 G)^-1 G' C^-1 (Woodbury).
    """
    grown = (after > before).any(axis=1)
    root = np.sqrt(before.T)[:, :, None]  # (r, g, 1)
    inner = np.eye(len(before)) + root * sums.GG * root.transpose(0, 2, 1)
    others = sums.GG[grown] @ (root * np.linalg.solve(inner, np.eye(len(before)) * root.transpose(0, 2, 1)))
    S = sums.GG[np.ix_(grown, grown)] - others @ sums.GG[:, grown]  # G' C^-1 G of each direction, (r, n, n)
    y = sums.GY[grown].T - np.einsum("rng,gr->rn", others, sums.GY)
    d = np.sqrt(after - before)[grown].T  # (r, n)
    power, U = np.linalg.eigh(d[:, :, None] * S * d[:, None, :])
    power = np.maximum(power, 0.0)
    T = (U * d[:, :, None]).transpose(0, 2, 1) / np.sqrt(1 + power)[:, :, None]
    values, keep = np.einsum("rkn,rn->rk", T, y), power > NEGLIGIBLE
    rows = np.empty((int(keep.sum()), sums.GW.shape[2]), dtype=sums.GW.dtype)
    start = 0
    for j, own in enumerate(keep):
        weights = -T[j, own] @ others[j]  # of all regressors, (k, g)
        weights[:, grown] += T[j, own]
        stop = start + len(weights)
        rows[start:stop] = weights.astype(rows.dtype) @ sums.GW[:, j]
        start = stop
    return Taken(rows, values[keep], float((values**2).sum()), float(np.log1p(power).sum()))
