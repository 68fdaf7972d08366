"""Candidates: the forms that effects take, laid out and scored; and several of them fitted together."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.diagnosis._design_matrix import DesignMatrix, coefficients, columns_by_term, join, order_of
from labrig.diagnosis._regression import Regression
from labrig.diagnosis._score import Score, jackknife_sd, score
from labrig.effects import Context, Effect, Variant, contribution


@dataclass(frozen=True)
class Candidate:
    """One form of one effect, laid out and scored on its own."""

    effect: Effect
    variant: Variant
    columns: DesignMatrix
    score: Score

    @cached_property
    def alone(self) -> "Fit":
        """This form as the only one of a fit."""
        return Fit((self,), self.columns, self.score)


@dataclass(frozen=True)
class Fit:
    """Several effects fitted together."""

    parts: tuple[Candidate, ...]
    columns: DesignMatrix
    score: Score

    @property
    def names(self) -> tuple[str, ...]:
        """The effects, in the order in which they came in."""
        return tuple(p.effect.name for p in self.parts)

    def order(self, i: int) -> Ints:
        """Where the columns of the i-th effect stand among those of all, in their own order."""
        return order_of([p.columns for p in self.parts])[i]

    def own(self, i: int) -> Floats:
        """Coefficients of the i-th effect, in the order of its own columns."""
        return self.score.beta[self.order(i)]

    @cached_property
    def heldout(self) -> Floats:
        """Prediction of each row by the fit that did not see its block, (S, K)."""
        regression = self.columns.regression
        out = np.zeros_like(regression.residual)
        for g, own in enumerate(regression.blocks):
            out[own] = self.columns.field(self.score.fold_beta[g], own, without=g)
        return out + regression.nothing

    @property
    def left(self) -> Floats:
        """What the fit leaves of each row that it did not see, (S, K)."""
        return self.columns.regression.residual - self.heldout


def fit(parts: Sequence[Candidate]) -> Fit:
    """Fit effects together and score them out of sample."""
    if len(parts) == 1:
        return parts[0].alone
    columns = join([p.columns for p in parts])
    return Fit(tuple(parts), columns, score(columns))


def plausible(effect: Effect, variant: Variant, columns: DesignMatrix, scored: Score) -> bool:
    """Whether the fitted values lie within their physical bounds, or within two standard errors of them.

    Of a parameter with one value per chamber the mean counts, weighted by what each says; of a chain each link.
    """
    regression = columns.regression
    for term, own in columns_by_term(variant, regression.n_patterns):
        parameter = effect.parameter(term.parameter)
        low, high = parameter.bounds(regression.context)
        one_sided = low >= 0 or high <= 0
        if term.kind == "pattern" and one_sided and not _along(regression, scored.beta[own], low >= 0):
            return False
        if parameter.least > 0 and not _as_large(columns, scored, own, parameter.least):
            return False
        is_chain = bool(term.labels) and term.labels != regression.context.rows.chambers
        if term.kind in {"pressure", "field"} and not _within_bounds(scored, own, low, high, is_chain):
            return False
    return True


def _within_bounds(scored: Score, own: slice, low: float, high: float, each_counts: bool) -> bool:
    """Whether the mean of the `own` coefficients lies between two bounds, or within two standard errors of them; and
    each of them by itself, where `each_counts`. What the run says nothing of does not count.
    """
    variance = np.diag(scored.covariance)[own]
    known = variance > 0
    if not known.any():
        return True
    beta, without = scored.beta[own], scored.fold_beta[:, own]
    if each_counts:
        sd = jackknife_sd(without)
        if (known & ((beta < low - 2 * sd) | (beta > high + 2 * sd))).any():
            return False
    weight = np.where(known, 1 / np.where(known, variance, 1.0), 0.0)
    mean = float(np.sum(weight * beta) / weight.sum())
    sd = float(jackknife_sd(without @ weight / weight.sum()))
    return not (mean < low - 2 * sd or mean > high + 2 * sd)


def _as_large(columns: DesignMatrix, scored: Score, own: slice, least: float) -> bool:
    """Whether the values, where they act, are at least so large, or within two standard errors of it."""
    weight = acting(columns, scored.beta, own)
    sd = float(jackknife_sd(scored.fold_beta[:, own] @ weight))
    return float(scored.beta[own] @ weight) >= least - 2 * sd


def acting(columns: DesignMatrix, beta: Floats, own: slice | Ints) -> Floats:
    """Weights that sum to one: how much each of the `own` columns, times its coefficient, changes the observables."""
    weight = np.diag(columns.sums[0].sum(axis=0))[own] * beta[own] ** 2
    return weight / max(float(weight.sum()), 1e-300)


def _along(regression: Regression, beta: Floats, forward: bool) -> bool:
    """Whether a free pattern points the way in which the base itself moves, chamber by chamber; if not `forward`,
    whether it points against it.
    """
    pattern = beta.reshape(-1, regression.n_patterns) @ regression.patterns
    reach = regression.context.jacobian.mean(axis=0).T
    if len(pattern) != len(reach) or not np.abs(reach).any():
        return True
    return bool(((pattern * reach / regression.floor.row**2).sum() > 0) == forward)


def mean_square(regression: Regression, left: Floats) -> Floats:
    """Mean square of what is left (S, K), per observable (K,), captures counting alike; NaN if never seen."""
    seen = regression.weight > 0
    n_means = int(regression.index.max()) + 1 if regression.use_means else 0
    total = np.zeros(left.shape[1])
    for rows in (slice(0, n_means), slice(n_means, len(left))):
        each = seen[rows]
        if len(each):
            square = np.where(each, left[rows] ** 2, 0.0).sum(axis=0)
            total += square / np.maximum(each.sum(axis=0), 1)
    return np.where(seen.any(axis=0), total, np.nan)


def square_of(regression: Regression, left: Floats) -> float:
    """Mean square of what is left over the observables that errors are quoted for."""
    return float(np.nanmean(mean_square(regression, left)[regression.counted]))


def error_of(regression: Regression, left: Floats) -> float:
    """Root mean square of what is left over the observables that errors are quoted for."""
    return float(np.sqrt(square_of(regression, left)))


def quoted(chosen: Fit) -> float:
    """The held-out error of a fit as it is quoted."""
    return error_of(chosen.columns.regression, chosen.left)


def change_of(context: Context, chosen: Fit) -> Floats:
    """What the chosen effects, fitted to all rows, change in the prediction, (F, K)."""
    change = np.zeros_like(context.base)
    for i, part in enumerate(chosen.parts):
        change += contribution(context, part.variant, coefficients(part.columns, part.variant, chosen.own(i)))
    return change
