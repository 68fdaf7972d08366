"""What runs say of effects in a given form, as normal equations: nothing of it is shrunk, and nothing is chosen."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.diagnosis import Prepared, observe
from labrig.effects import Context, Variant, contribution
from labrig.passport._captures import by_capture, jackknife_variance
from labrig.passport._prior import size_of


@dataclass(frozen=True)
class Evidence:
    """What one run says of Q values: of each of n captures `gram` (n, Q, Q) and `product` (n, Q), in units of noise.

    `inflation`: by how much the captures disagree beyond their noise, as a ratio of variances, 1 or more.
    `fields` (Q, F, K): what each value changes in the rows.
    """

    gram: Floats
    product: Floats
    inflation: float
    fields: Floats

    @property
    def information(self) -> Floats:
        """The inverse covariance (Q, Q) of what it says."""
        return self.gram.sum(axis=0) / self.inflation

    @property
    def weighted(self) -> Floats:
        """The information times the estimate, (Q,)."""
        return self.product.sum(axis=0) / self.inflation

    @property
    def estimate(self) -> Floats:
        """The values (Q,) that fit this run best."""
        return _solved(self.information, self.weighted)

    @property
    def sd(self) -> Floats:
        """Standard deviations (Q,) of the estimate; huge where the run says nothing."""
        return np.sqrt(np.diag(_inverse(self.information)))


def evidence_of(ready: Prepared, forms: Sequence[tuple[Context, Variant]]) -> Evidence:
    """What a run says of the values of these forms, each in the context in which its values are meant.

    What the base itself fits to each run is fitted beside them.
    """
    context = ready.context
    observations = observe(context, ready.residual, ready.floor)
    seen = observations.seen
    fields = np.concatenate([_columns(own, variant) for own, variant in forms])
    white = np.stack([observations.whiten @ (field / observations.unit) for field in fields])[:, :, seen]
    known = np.zeros((observations.n_captures, len(seen)), dtype=bool)
    np.logical_or.at(known, observations.index, np.isfinite(ready.residual))
    known = known[observations.capture][:, seen]  # what a whole capture did not see says nothing of it
    left, white = np.where(known, observations.values[:, seen], 0.0), np.where(known, white, 0.0)
    if ready.declared is not None:
        own = np.linalg.qr(observations.whiten @ ready.declared)[0]
        left = left - own @ (own.T @ left)
        white = white - np.einsum("sd,td,qtk->qsk", own, own, white)
    if ready.calibrated is not None:
        by = [
            observations.whiten @ (ready.calibrated[..., d] / observations.unit)
            for d in range(ready.calibrated.shape[2])
        ]
        flat = np.linalg.qr(np.stack(by)[:, :, seen].reshape(len(by), -1).T)[0]
        left = left - (flat @ (flat.T @ left.ravel())).reshape(left.shape)
        rows = white.reshape(len(white), -1)
        white = (rows - (rows @ flat) @ flat.T).reshape(white.shape)
    return _evidence(fields, white, left, observations.capture, observations.n_captures)


def _evidence(fields: Floats, white: Floats, left: Floats, capture: Ints, n: int) -> Evidence:
    gram, product = by_capture(white, left, capture, n)
    total, target = gram.sum(axis=0), product.sum(axis=0)
    if n < 2:
        return Evidence(gram, product, 1.0, fields)
    each = np.array([_solved(total - g, target - p) for g, p in zip(gram, product, strict=True)])
    jack = jackknife_variance(each)
    told = np.diag(_inverse(total))
    live = np.diag(total) > 1.0
    ratio = float(np.mean(jack[live] / told[live])) if live.any() else 1.0
    return Evidence(gram, product, max(1.0, ratio), fields)


def _columns(context: Context, variant: Variant) -> Floats:
    """What a form changes by each of its values, (Q, F, K)."""
    sizes = [size_of(term, context) for term in variant.terms]
    out = []
    for number, size in enumerate(sizes):
        for i in range(size):
            coefficients = [np.zeros(s) for s in sizes]
            coefficients[number][i] = 1.0
            out.append(contribution(context, variant, coefficients))
    return np.array(out)


def _inverse(matrix: Floats) -> Floats:
    """The inverse of an information matrix; what it says nothing of comes out huge, and not infinite."""
    least = 1e-9 * max(float(np.diag(matrix).max(initial=0.0)), 1e-12)
    return np.asarray(np.linalg.inv(matrix + least * np.eye(len(matrix))), dtype=float)


def _solved(matrix: Floats, right: Floats) -> Floats:
    return _inverse(matrix) @ right
