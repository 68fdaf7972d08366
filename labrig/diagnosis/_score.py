"""Out-of-sample scores: what a set of columns explains of the blocks that it was not fitted to."""

from dataclasses import dataclass

import numpy as np

from labrig.diagnosis._columns import Columns
from labrig.effects._rows import Floats

RIDGES = (1e-3, 0.03, 0.3)


@dataclass(frozen=True)
class Score:
    """Held-out gain: by how much the weighted square of each left-out block falls, (G,); and the full fit.

    `beta` (Q,) is fitted to all blocks; `fold_beta` (G, Q) without each block; `covariance` (Q, Q) of `beta`
    for residuals of unit weight.
    """

    gains: Floats
    beta: Floats
    fold_beta: Floats
    covariance: Floats
    ridge: float

    @property
    def gain(self) -> float:
        """The whole held-out gain."""
        return float(self.gains.sum())

    @property
    def se(self) -> float:
        """Its standard error, from how the blocks differ."""
        n = len(self.gains)
        return (
            float(np.sqrt(n / (n - 1) * np.sum((self.gains - self.gains.mean()) ** 2))) if n > 1 else np.inf
        )


def score(columns: Columns) -> Score:
    """Fit without each block, predict it, and keep the ridge that does best; narrow fits need none to choose."""
    ridges = RIDGES if columns.width > 3 else RIDGES[:1]
    if columns.streams.declared is None:
        G, c = columns.sums
        results = [_leave_out(G, c, ridge) for ridge in ridges]
    else:
        folds = [columns.fold_sums(f) for f in range(columns.streams.n_groups)]
        results = [_leave_out_each(folds, ridge) for ridge in ridges]
        G, c = columns.sums
    best = int(np.argmax([gains.sum() for gains, _ in results]))
    gains, fold_beta = results[best]
    inverse = _inverse(G.sum(axis=0), ridges[best])
    beta = inverse @ c.sum(axis=0)
    return Score(gains, beta, fold_beta, inverse @ G.sum(axis=0) @ inverse, ridges[best])


def null_gains(columns: Columns, signs: Floats, ridge: float, base: Floats) -> Floats:
    """The relative gain when the residuals of whole blocks change sign, (B,).

    `signs` (B, G) are +1 or -1; the gain of each block is taken as a share of its `base` (G,). Under the
    null the sign of a block's residual says nothing, so this is what the search would have found.
    """
    G, c = columns.sums
    total = G.sum(axis=0)
    out = np.zeros(len(signs))
    signed = signs @ c
    for f in range(len(G)):
        beta = (signed - signs[:, [f]] * c[f]) @ _inverse(total - G[f], ridge)
        gain = 2 * signs[:, f] * (beta @ c[f]) - np.einsum("bq,qr,br->b", beta, G[f], beta, optimize=True)
        out += gain / max(float(base[f]), 1e-300)
    return out


def _leave_out(G: Floats, c: Floats, ridge: float) -> tuple[Floats, Floats]:
    total, target = G.sum(axis=0), c.sum(axis=0)
    beta = np.stack([_inverse(total - G[f], ridge) @ (target - c[f]) for f in range(len(G))])
    return _gains(G, c, beta), beta


def _leave_out_each(folds: list[tuple[Floats, Floats]], ridge: float) -> tuple[Floats, Floats]:
    gains, betas = [], []
    for f, (G, c) in enumerate(folds):
        beta = _inverse(G.sum(axis=0) - G[f], ridge) @ (c.sum(axis=0) - c[f])
        gains.append(2 * c[f] @ beta - beta @ G[f] @ beta)
        betas.append(beta)
    return np.array(gains), np.stack(betas)


def _gains(G: Floats, c: Floats, beta: Floats) -> Floats:
    return 2 * np.einsum("gq,gq->g", c, beta) - np.einsum("gq,gqr,gr->g", beta, G, beta)


def _inverse(G: Floats, ridge: float) -> Floats:
    """Inverse of a Gram matrix with a ridge in units of its own diagonal; columns of zeros stay out."""
    d = np.sqrt(np.maximum(np.diag(G), 0.0))
    live = d > 1e-9 * max(float(d.max(initial=0.0)), 1e-300)
    scale = np.where(live, 1 / np.where(live, d, 1.0), 0.0)
    scaled = G * scale[:, None] * scale + np.diag(np.where(live, ridge, 1.0))
    return np.asarray(np.linalg.inv(scaled) * scale[:, None] * scale, dtype=float)
