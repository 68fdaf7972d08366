"""Out-of-sample scores: what a set of columns explains of the blocks that it was not fitted to."""

from dataclasses import dataclass
from itertools import product

import numpy as np

from labrig.arrays import Floats
from labrig.diagnosis._design_matrix import DesignMatrix, Split

RIDGES = (1e-6, 1e-3, 0.03, 0.3)
"""Ridges, as shares of the columns' own squares, of which the one that does best is kept: a grid."""
PRIORS = (1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0)
"""How strongly a family's prior holds its weights, as shares of what the run says of a weight on average."""


@dataclass(frozen=True)
class Score:
    """Held-out gain: by how much the weighted square of each left-out block falls, (G,); and the full fit.

    `beta` (Q,) is fitted to all blocks; `fold_beta` (G, Q) without each block; `covariance` (Q, Q) of `beta`
    for residuals of unit weight. `ridge`, and `strength` of the prior, are those that were kept.
    """

    gains: Floats
    beta: Floats
    fold_beta: Floats
    covariance: Floats
    ridge: float
    strength: float

    @property
    def gain(self) -> float:
        """The whole held-out gain."""
        return float(self.gains.sum())


def standard_error(gains: Floats) -> float:
    """The standard error of a sum of gains (G,), from how the blocks differ; infinite for a single block."""
    n = len(gains)
    return float(np.sqrt(n) * gains.std(ddof=1)) if n > 1 else np.inf


def relative_error(gains: Floats) -> float:
    """The standard error of a sum of gains (G,), as a share of that sum."""
    return standard_error(gains) / max(abs(float(gains.sum())), 1e-300)


def jackknife_sd(without: Floats) -> Floats:
    """The standard deviation of an estimate from its values (G, ...) without each block in turn, over the first axis
    (J. Tukey, Ann. Math. Statist. 29 (1958) 614).
    """
    n = len(without)
    return np.sqrt((n - 1) / n * ((without - without.mean(axis=0)) ** 2).sum(axis=0))


def score(columns: DesignMatrix) -> Score:
    """Fit without each block, predict it, and keep the ridge, and the strength of the prior, that does best.

    Narrow fits need no ridge to choose.
    """
    held = columns.prior > 0
    ridges = RIDGES if (~held).sum() > 3 else RIDGES[:1]
    tried = list(product(ridges, PRIORS if held.any() else PRIORS[:1]))
    if columns.regression.declared is None and columns.regression.calibrated is None:
        G, c = columns.sums
        results = [_leave_out(G, c, ridge, strength * columns.prior) for ridge, strength in tried]
    else:
        folds = [columns.held_out(f) for f in range(columns.regression.n_groups)]
        results = [_leave_out_each(folds, ridge, strength * columns.prior) for ridge, strength in tried]
        G, c = columns.sums
    best = int(np.argmax([gains.sum() for gains, _ in results]))
    gains, fold_beta = results[best]
    ridge, strength = tried[best]
    inverse = _inverse(G.sum(axis=0), ridge, strength * columns.prior)
    beta = inverse @ c.sum(axis=0)
    return Score(gains, beta, fold_beta, inverse @ G.sum(axis=0) @ inverse, ridge, strength)


def without_each(columns: DesignMatrix, ridge: float) -> tuple[Floats, Floats]:
    """Coefficients (G, Q) of fits without each block, and the inverse (Q, Q) of the Gram matrix over all of them."""
    if columns.regression.declared is None and columns.regression.calibrated is None:
        beta = _leave_out(*columns.sums, ridge, columns.prior)[1]
    else:
        folds = [columns.held_out(f) for f in range(columns.regression.n_groups)]
        beta = _leave_out_each(folds, ridge, columns.prior)[1]
    return beta, _inverse(columns.sums[0].sum(axis=0), ridge, columns.prior)


def _leave_out(G: Floats, c: Floats, ridge: float, prior: Floats) -> tuple[Floats, Floats]:
    """Gains (G,) and coefficients (G, Q) of fits without each block, from the sums of each: nothing else is fitted."""
    total, target = G.sum(axis=0), c.sum(axis=0)
    beta = (_inverse(total - G, ridge, prior) @ (target - c)[..., None])[..., 0]
    return _gains(G, c, beta), beta


def _leave_out_each(folds: list[Split], ridge: float, prior: Floats) -> tuple[Floats, Floats]:
    """Gains and coefficients where the base's own parameters are fitted anew without each block."""
    seen, target = np.stack([f.gram for f in folds]), np.stack([f.product for f in folds])
    beta = (_inverse(seen, ridge, prior) @ target[..., None])[..., 0]
    return _gains(np.stack([f.own_gram for f in folds]), np.stack([f.own_product for f in folds]), beta), beta


def _gains(G: Floats, c: Floats, beta: Floats) -> Floats:
    """By how much coefficients (G, Q) lower the weighted square of the block that each did not see, (G,)."""
    return 2 * np.einsum("gq,gq->g", c, beta) - np.einsum("gq,gqr,gr->g", beta, G, beta)


def _inverse(G: Floats, ridge: float, prior: Floats) -> Floats:
    """Inverses of Gram matrices (..., Q, Q) with the prior's precision (Q,), and where there is none a ridge in units
    of their own diagonals; columns of zeros stay out.
    """
    d = np.sqrt(np.maximum(np.diagonal(G, axis1=-2, axis2=-1), 0.0))
    live = d > 1e-9 * np.maximum(d.max(axis=-1, initial=0.0, keepdims=True), 1e-300)
    scale = np.where(live, 1 / np.where(live, d, 1.0), 0.0)
    both = scale[..., :, None] * scale[..., None, :]
    scaled = G * both
    own = np.arange(G.shape[-1])
    scaled[..., own, own] += np.where(live, np.where(prior > 0, prior * scale**2, ridge), 1.0)
    return np.asarray(np.linalg.inv(scaled) * both, dtype=float)
