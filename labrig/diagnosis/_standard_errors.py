"""Standard errors of fitted values: of what is linear in a form and of what is not, together."""

from dataclasses import dataclass, replace

import numpy as np

from labrig.arrays import Floats
from labrig.diagnosis._candidates import Candidate, Fit
from labrig.diagnosis._design_matrix import DesignMatrix, columns_of, join
from labrig.diagnosis._moved import is_moved, with_shape
from labrig.diagnosis._score import jackknife_sd, without_each
from labrig.effects import Context

_STEP = 0.05
"""By what share a value is moved to see what that changes; numerical."""


@dataclass(frozen=True)
class StandardErrors:
    """What says how far fitted values may be off.

    `coefficients` (G + J, Q): those of the fits without each of the G blocks, then by how much they are off where each
    of the J shapes is off by a standard deviation of what it may be beforehand; `shapes`: how far a value of the shape
    of an effect, by its number and name, may be off, as a share of it.
    """

    coefficients: Floats
    blocks: int
    shapes: dict[tuple[int, str], float]

    def given_shape(self, values: Floats) -> Floats | None:
        """The same where the shapes stay as they are, from values (G, ...) without each block; None without shapes."""
        return jackknife_sd(values) if self.shapes else None

    def of(self, values: Floats) -> Floats:
        """The standard deviation (...) of what is linear in the coefficients, from its values (G + J, ...)."""
        return np.hypot(
            jackknife_sd(values[: self.blocks]), np.sqrt((values[self.blocks :] ** 2).sum(axis=0))
        )


def standard_errors(context: Context, chosen: Fit) -> StandardErrors:
    """Standard errors of a fit: by the jackknife over its blocks, in which what is not linear takes one step of
    Gauss-Newton with the coefficients (B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, 1982).

    Beforehand a value of a shape is known to a factor of e, so what the run says nothing of is off by as much as it
    is, and by no more: farther along a line says nothing. What a scan finds, and families' weights, have the jackknife
    alone.
    """
    blocks, Q = chosen.score.fold_beta.shape
    moved = [(i, name) for i, part in enumerate(chosen.parts) for name in _moved(part)]
    fields = [_change(context, chosen, i, name) for i, name in moved]
    known = [(at, field) for at, field in zip(moved, fields, strict=True) if field is not None]
    if not known:
        return StandardErrors(chosen.score.fold_beta, blocks, {})
    regression = chosen.columns.regression
    E = np.stack([field for _, field in known], axis=2)
    nothing = np.zeros((len(E), 0, 0)), np.zeros(0, dtype=np.int64)
    beside = DesignMatrix(regression, *nothing, regression.partial(E), np.ones(len(known)))
    as_fitted = replace(chosen.columns, prior=chosen.score.strength * chosen.columns.prior)
    each, inverse = without_each(join([as_fitted, beside]), chosen.score.ridge)
    all_values = StandardErrors(np.concatenate([each, inverse[Q:]]), blocks, {})
    relative = all_values.of(all_values.coefficients)[Q:]
    said = [(at, float(r)) for (at, _), r in zip(known, relative, strict=True)]
    shapes = {at: min(r, 1.0) for at, r in said if r > 0}  # of 0: the base itself does what it changes
    return StandardErrors(all_values.coefficients[:, :Q], blocks, shapes)


def _moved(part: Candidate) -> list[str]:
    """What is not linear in a form and no scan's or family's."""
    if part.effect.scans or part.columns.prior.any():
        return []
    return [name for name in part.variant.shape if is_moved(part, name)]


def _change(context: Context, chosen: Fit, i: int, name: str) -> Floats | None:
    """What the regression's rows change by (S, K) where the logarithm of a value grows by one, by a small step."""
    part = chosen.parts[i]
    value, high = part.variant.shape[name], part.effect.parameter(name).high
    step = _STEP if value * (1 + _STEP) <= high else -_STEP
    variant = with_shape(context, part, name, value * (1 + step))
    if variant is None:
        return None
    columns, beta = columns_of(part.columns.regression, variant), chosen.own(i)
    if columns.width != part.columns.width:
        return None
    change = columns.field(beta) - part.columns.field(beta)
    return change / np.log1p(step)
