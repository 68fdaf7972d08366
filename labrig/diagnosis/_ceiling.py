"""The ceiling: how much of the error some function of what was logged could explain at all.

Kernel ridge regression (Saunders, Gammerman, Vovk, ICML 1998) on growing sets of covariates, scored on the
same left-out blocks as the effects. It is a bound only where it beats every named effect.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.linalg import inv
from scipy.spatial.distance import cdist

from labrig.arrays import Floats, Ints
from labrig.diagnosis._regression import Regression
from labrig.effects import Context

_MOST_ROWS = 700
"""Rows that are learnt from at most; numerical, it bounds the time."""
_RIDGES = (0.01, 0.1, 1.0)
"""Variances of the noise beside that of the kernel, of which the one that does best is kept: a grid."""
STATIC = "pressure"
"""The set of covariates that are the pressures alone."""


@dataclass(frozen=True)
class Ceiling:
    """The best learner: which covariates it used, its held-out gains (G,) and prediction (S, K)."""

    covariates: str
    gains: Floats
    heldout: Floats

    @property
    def gain(self) -> float:
        """The whole held-out gain."""
        return float(self.gains.sum())


def ceiling(
    regression: Regression, context: Context, left: Floats, only: str | None = None
) -> dict[str, Ceiling]:
    """Learn what is `left` (S, K) from each set of covariates, or from one; the best ridge of each, by name."""
    sets = {name: x for name, x in covariates(context).items() if only in (None, name)}
    target = _scores(regression, left)
    rows = np.arange(len(context.base))
    if len(rows) > _MOST_ROWS:
        rows = np.unique(np.linspace(0, len(rows) - 1, _MOST_ROWS).astype(int))
    found: dict[str, Ceiling] = {}
    for name, features in sets.items():
        kernels = [kernel(features, features[rows])]
        if name == STATIC:
            kernels.append(_additive(features, features[rows]))
        for matrix, ridge in product(kernels, _RIDGES):
            predicted = _heldout(regression, matrix, ridge, target, rows)
            field = regression.lift(predicted) @ regression.patterns
            gains = _gains(regression, left, field)
            if name not in found or gains.sum() > found[name].gain:
                found[name] = Ceiling(name, gains, field)
    return found


def _heldout(regression: Regression, kernel: Floats, ridge: float, target: Floats, rows: Ints) -> Floats:
    """What kernel ridge regression on `rows` predicts of each block without it, (F, r).

    The weights without a block follow from those of all rows and the inverse (C. E. Rasmussen, C. K. I. Williams,
    Gaussian Processes for Machine Learning, MIT Press 2006, section 5.4.2, for blocks).
    """
    predicted = np.zeros_like(target)
    group = regression.row_group[rows]
    inverse = inv(kernel[rows] + ridge * np.eye(len(rows)), overwrite_a=True, check_finite=False)
    weights = inverse @ target[rows]
    for g in range(regression.n_groups):
        own, test = group == g, regression.row_group == g
        if own.all() or not test.any():
            continue
        without = weights - inverse[:, own] @ np.linalg.solve(inverse[own][:, own], weights[own])
        without[own] = 0.0
        predicted[test] = kernel[test] @ without
    return predicted


def _gains(regression: Regression, left: Floats, field: Floats) -> Floats:
    """By how much the weighted square of what is left falls in each block (G,) without a predicted field (S, K)."""
    each = regression.square(left) - regression.square(left - field)
    return np.array([each[own].sum() for own in regression.blocks])


def _scores(regression: Regression, left: Floats) -> Floats:
    """What is left of each row along the free patterns, (F, r), least squares over what was seen."""
    V = regression.patterns
    H = np.einsum("rk,sk,qk->srq", V, regression.weight, V, optimize=True)
    b = (regression.weight * left) @ V.T
    ridge = 1e-6 * np.trace(H, axis1=1, axis2=2).max(initial=1e-12) * np.eye(len(V))
    z = np.linalg.solve(H + ridge, b[:, :, None])[:, :, 0]
    n = int(regression.index.max()) + 1
    out = np.zeros((len(regression.index), len(V)))
    if regression.use_means:
        out += z[:n][regression.index]
        out[regression.keep] += z[n:]
    else:
        out[regression.keep] = z
    return out


def covariates(context: Context) -> dict[str, Floats]:
    """Growing sets of covariates, each column of unit spread, (F, d)."""
    rows = context.rows
    static = [rows.fraction]
    hold, history = [], []
    if context.has_holds:
        hold.append(np.log1p(context.elapsed_s)[:, None])
    if context.moves:
        history.append(rows.share(context.previous)[rows.event])
        history.append(context.direction[rows.event])
        if context.has_time:
            history += [(context.relaxed(tau) - rows.actuation) / context.span for tau in (3.0, 30.0, 300.0)]
    time = [context.session_time_s[:, None]] if np.ptp(context.session_time_s) > 0 else []
    if np.isfinite(rows.time_s).all() and len(rows.sessions) > 1 and np.ptp(rows.time_s) > 0:
        time.append(rows.time_s[:, None])
    other = [c.values[:, None] for c in rows.covariates.values() if np.isfinite(c.values).all()]
    other += [np.sign(speed)[:, None] for speed, _ in context.motion.values()]
    sets = {
        STATIC: static,
        "pressure, time in hold, history": static + hold + history,
        "pressure, time in session": static + time,
        "pressure, time in hold, history, time in session": static + hold + history + time,
    }
    if other:
        sets["everything that was logged"] = static + hold + history + time + other
    made: dict[str, Floats] = {}
    for name, parts in sets.items():
        features = np.concatenate(parts, axis=1)
        spread = features.std(axis=0)
        features = ((features - features.mean(axis=0)) / np.where(spread > 1e-9, spread, 1.0))[
            :, spread > 1e-9
        ]
        if not any(features.shape == other.shape for other in made.values()):
            made[name] = features if features.shape[1] else np.zeros((len(rows.capture), 1))
    return made


def kernel(a: Floats, b: Floats) -> Floats:
    """A constant, a linear, and two Gaussian kernels, wide and narrow, summed; (len(a), len(b))."""
    d = max(a.shape[1], 1)
    square = cdist(a, b, "sqeuclidean") / d
    return 1.0 + (a @ b.T) / d + 2 * np.exp(-square / 2) + np.exp(-square / 0.4)


def _additive(a: Floats, b: Floats) -> Floats:
    """A kernel of sums of parabolas, one of each covariate: what chambers do one by one, each in its own pattern."""
    return 1.0 + (a @ b.T + 0.5 * (a**2 @ (b**2).T)) / max(a.shape[1], 1)
