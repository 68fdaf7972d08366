"""The regression problem: rows become means and deviations, observables a few modes.

Each capture gives its mean over the hold and, where the hold has several rows, the deviations from it;
both are weighted by their own noise, so that what changes within a hold (creep, leak) and what differs
between captures are both seen at their true worth. An effect's column is then a short vector over the
modes (chambers through the Jacobian, rigid motions of the frame, free patterns), and everything that
scoring needs are sums over rows of mode-by-mode products: no step depends on the number of observables.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from labrig._gaps import filled
from labrig._linalg import sums_of, svd
from labrig._turns import quoted_from
from labrig.arrays import Floats, Ints
from labrig.diagnosis._blocks import blocks_of
from labrig.diagnosis._floor import Floor
from labrig.diagnosis._outliers import FORM
from labrig.effects import FEW_OBSERVABLES, Context, bulk_edge, capture_means, frame_modes

MAX_PATTERNS = 8
"""Most directions of free patterns."""
_FEW_CAPTURES = 3
"""Captures from which on their means count: of fewer a fit would follow any mean."""
_ROWS_THAT_COUNT = 12
"""Rows that a hold counts as at most: neighbours of a long record say nearly the same."""
_FAR_MORE = 1.4
"""How many times more of their noise another unit's observables are off by, for errors to be quoted in it."""
_CALIBRATION_RIDGE = 1e-6
"""Added to the square of each calibrated parameter's field, as a share of it; numerical."""


@dataclass(frozen=True)
class Calibration:
    """What the base's calibrated parameters change: `fields` (S, K, D), the same `weighted`, and how they lie along the
    modes, `products` (S, m, D).
    """

    fields: Floats
    weighted: Floats
    products: Floats

    def fitted(self, left: Floats, train: NDArray[np.bool_]) -> Floats:
        """The parameters (D,) that explain most of what is `left` (S, K) in some rows."""
        size = self.fields.shape[2]
        weighted = self.weighted[train].reshape(-1, size)
        gram = self.fields[train].reshape(-1, size).T @ weighted
        return solve_calibrated(gram, left[train].ravel() @ weighted)


@dataclass(frozen=True)
class Regression:
    """The regression problem: S weighted rows, which are means and deviations; m modes, K observables.

    `weight` (S, K) is 1 / noise^2, 0 where nothing was seen; `residual` (S, K); `modes` (captures, m, K);
    `group` (S,) is which block is left out with it; `source` (S,) its capture, as an index. The base's own parameters
    are `declared` (S, D), regressors of every observable on its own, and `calibrated` (S, K, D), fields that all
    observables share; both are refitted beside every effect. `shrunk` (D,) draws coefficients of `declared` towards
    zero: a ridge, in units of the regressor's own square over all rows.
    """

    context: Context
    floor: Floor
    residual: Floats
    weight: Floats
    modes: Floats
    group: Ints
    source: Ints
    index: Ints
    keep: Ints
    use_means: bool
    n_patterns: int
    declared: Floats | None
    row_group: Ints
    calibrated: Floats | None = None
    shrunk: Floats | None = None

    @property
    def n_groups(self) -> int:
        """How many blocks are left out in turn."""
        return int(self.group.max()) + 1

    def lift(self, feature: Floats) -> Floats:
        """Carry a feature of the rows (F, ...) to the regression's rows (S, ...): means, then deviations."""
        n = int(self.index.max()) + 1
        count = np.bincount(self.index, minlength=n).reshape(-1, *[1] * (feature.ndim - 1))
        mean = sums_of(self.index, feature, n) / count
        deviation = feature[self.keep] - mean[self.index[self.keep]]
        return np.concatenate([mean, deviation]) if self.use_means else deviation

    @cached_property
    def products(self) -> Floats:
        """Mode-by-mode products of each row, (S, m, m)."""
        M = self.modes
        out = np.empty((len(self.source), M.shape[1], M.shape[1]))
        for i, capture in enumerate(self.source):
            out[i] = (M[capture] * self.weight[i]) @ M[capture].T
        return out

    @cached_property
    def projected(self) -> Floats:
        """Products of modes and residuals, (S, m), the base's own parameters fitted to all blocks."""
        return self.project(self.residual)

    @cached_property
    def base_left(self) -> Floats:
        """What the base leaves of each block when its own parameters are fitted to the others, (S, K)."""
        return self.residual - self.nothing

    @cached_property
    def nothing(self) -> Floats:
        """What the base's own parameters, fitted without each block, change in it, (S, K)."""
        out = np.zeros_like(self.residual)
        if self.declared is None and self.calibrated is None:
            return out
        for g, own in enumerate(self.blocks):
            left = self.fold_residuals[g][0]
            out[own] = (self.residual - left)[own]
            if calibration := self.calibration(g):
                out[own] += calibration.fields[own] @ calibration.fitted(left, self.group != g)
        return out

    def calibration(self, without: int | None) -> "Calibration | None":
        """The calibrated parameters beside the declared ones, which are fitted to all blocks or `without` one."""
        if self.calibrated is None:
            return None
        key = None if self.declared is None else without
        if key not in self._calibrations:
            fields = self.partial(self.calibrated, key)
            weighted = self.weight[..., None] * fields
            products = np.matmul(self.modes[self.source], weighted)
            self._calibrations[key] = Calibration(fields, weighted, products)
        return self._calibrations[key]

    @cached_property
    def _calibrations(self) -> "dict[int | None, Calibration]":
        """The calibrations that were worked out, by the block that is left out."""
        return {}

    @property
    def patterns(self) -> Floats:
        """The free directions over the observables, (r, K)."""
        return self.modes[0, self.modes.shape[1] - self.n_patterns :]

    @cached_property
    def base_squares(self) -> Floats:
        """Weighted square of what the base leaves in each block, (G,)."""
        each = self.square(self.base_left)
        return np.array([each[own].sum() for own in self.blocks])

    @cached_property
    def counted(self) -> Ints:
        """The observables that errors are quoted for: those of the commonest unit of those that were seen; or, where
        these are few or hardly off themselves, those that are off by far more of their noise. No parts of quaternions
        are, unless nothing else was seen.
        """
        units, seen = self.context.rows.unit, np.flatnonzero((self.weight > 0).any(axis=0))
        able = quoted_from(units, self.context.rows.values, self.context.base)
        able = able if np.isin(able, seen).any() else np.arange(len(units))
        seen = np.intersect1d(able, seen)
        units_seen = [units[k] for k in seen]
        quoted = max(dict.fromkeys(units_seen), key=units_seen.count)
        left, counts = self.residual[:, seen], self.weight[:, seen] > 0  # without what was mistaken
        square = np.where(counts, (left / self.floor.row[seen]) ** 2, 0.0).sum(axis=0) / counts.sum(axis=0)
        off = {u: float(square[[v == u for v in units_seen]].mean()) for u in dict.fromkeys(units_seen)}
        if units_seen.count(quoted) <= FEW_OBSERVABLES or off[quoted] < _FAR_MORE**2:
            farthest = max(off, key=lambda unit: off[unit])
            if off[farthest] > _FAR_MORE**2 * off[quoted]:
                quoted = farthest
        return np.array([k for k in able if units[k] == quoted])

    @property
    def units(self) -> str:
        """The units that errors are quoted in: those of the `counted` observables."""
        return self.context.rows.unit[int(self.counted[0])]

    @cached_property
    def blocks(self) -> list[Ints]:
        """The rows of each left-out block."""
        return [np.flatnonzero(self.group == g) for g in range(self.n_groups)]

    @cached_property
    def modes_change(self) -> bool:
        """Whether any mode differs from capture to capture: else features on the modes can be projected alone."""
        size = np.abs(self.modes).max(axis=(0, 2))
        return bool((np.abs(self.modes - self.modes[:1]).max(axis=(0, 2)) > 1e-6 * size).any())

    def partial(self, target: Floats, without: int | None = None) -> Floats:
        """What the base's own parameters, fitted to all blocks or `without` one, leave of `target` (S, ...)."""
        if self.declared is None or target.size == 0:
            return target
        flat = target.reshape(len(target), -1)
        return (flat - self.declared @ (self._fitting(without) @ flat)).reshape(target.shape)

    def _fitting(self, without: int | None) -> Floats:
        """The matrix (D, S) that fits the base's own parameters to a target; worked out once for each block."""
        if without not in self._fittings:
            assert self.declared is not None
            train = np.ones(len(self.group), dtype=bool) if without is None else self.group != without
            w = np.sqrt(self.weight.max(axis=1)) * train
            A = self.declared * w[:, None]
            if self.shrunk is not None:
                solved = np.linalg.pinv(A.T @ A + self._shrinking, rcond=1e-12, hermitian=True) @ A.T
            else:
                solved = np.linalg.pinv(A, rcond=1e-9)
            self._fittings[without] = solved * w
        return self._fittings[without]

    @cached_property
    def _shrinking(self) -> Floats:
        """What is added to the Gram matrix of the base's own regressors, (D, D)."""
        assert self.declared is not None
        assert self.shrunk is not None
        return np.diag(self.shrunk * (self.weight.max(axis=1) @ np.square(self.declared)))

    @cached_property
    def declared_weighted(self) -> list[tuple[Floats, Floats]]:
        """For each block, the base's own regressors times the weights: (K, d, S) of each observable, (d, S) of all."""
        assert self.declared is not None
        D, common = self.declared.T, self.weight.max(axis=1)
        return [
            (D[None, :, own] * self.weight[own].T[:, None], D[:, own] * common[own]) for own in self.blocks
        ]

    @cached_property
    def declared_sums(self) -> Floats:
        """Gram matrices of the base's own regressors, for each block and observable, (G, K, d, d)."""
        assert self.declared is not None
        each = zip(self.blocks, self.declared_weighted, strict=True)
        return np.array([weighted @ self.declared[own] for own, (weighted, _) in each])

    @cached_property
    def declared_inverses(self) -> list[Floats]:
        """Inverses of the regressors' common Gram matrix over all blocks but each one, (d, d)."""
        assert self.declared is not None
        blocks = zip(self.blocks, self.declared_weighted, strict=True)
        grams = [common @ self.declared[own] for own, (_, common) in blocks]
        total = np.sum(grams, axis=0) + (0.0 if self.shrunk is None else self._shrinking)
        return [np.linalg.pinv(total - gram, rcond=1e-12, hermitian=True) for gram in grams]

    @cached_property
    def _fittings(self) -> dict[int | None, Floats]:
        """The matrices that were worked out, by the block that is left out; see `_fitting`."""
        return {}

    @cached_property
    def fold_residuals(self) -> list[tuple[Floats, Floats]]:
        """For each block, the residual when the base's own parameters are fitted without it, and its products."""
        left = [self.partial(self.residual, g) for g in range(self.n_groups)]
        return [(residual, self.project(residual)) for residual in left]

    def project(self, residual: Floats) -> Floats:
        """Products of modes and residuals of each row, (S, m), for residuals (S, K)."""
        return np.einsum("smk,sk->sm", self.modes[self.source], self.weight * residual, optimize=True)

    def square(self, residual: Floats) -> Floats:
        """Weighted square of residuals, (S,)."""
        return (self.weight * residual**2).sum(axis=1)

    def gains(self, before: Floats, after: Floats) -> Floats:
        """By how much the weighted square of each block (G,) falls from residuals (S, K) to others."""
        fallen = self.square(before) - self.square(after)
        return np.asarray(np.bincount(self.group, weights=fallen), dtype=float)


def solve_calibrated(gram: Floats, right: Floats) -> Floats:
    """The calibrated parameters for right sides (D, ...); what the runs say nothing of stays as it is."""
    own = np.diag(gram)
    ridge = _CALIBRATION_RIDGE * np.maximum(own, 1e-6 * max(float(own.max(initial=0.0)), 1e-300))
    return np.asarray(np.linalg.solve(gram + np.diag(ridge), right), dtype=float)


def regression_of(
    context: Context,
    floor: Floor,
    residual: Floats,
    declared: Floats | None,
    calibrated: Floats | None = None,
    *,
    as_it_stands: bool = False,
) -> Regression:
    """Lay out the regression for what the base leaves, `residual` (F, K), outliers already NaN.

    `declared` (F, D) and `calibrated` (F, K, D) are the base's own parameters, refitted beside every effect. Captures'
    means count where there are several, where nothing else says anything, and where nothing is fitted, `as_it_stands`:
    of one or two captures a fit would follow any mean.
    """
    captures, first, index = np.unique(context.rows.capture, return_index=True, return_inverse=True)
    count = np.bincount(index)
    keep = np.flatnonzero((count[index] > 1) & (floor.within.max() > 0))
    use_means = as_it_stands or len(captures) >= _FEW_CAPTURES or not len(keep)
    row_group = blocks_of(context, index, use_means)
    means, _ = capture_means(residual, context.rows.capture)
    streams = []  # of the means, and of the deviations from them: what is left, its weight, its capture, its block
    if use_means:
        weight = np.isfinite(means) / _blurred(floor.mean, means) ** 2
        streams.append((means, weight, np.arange(len(captures)), row_group[first]))
    if len(keep):
        deviation = residual[keep] - means[index[keep]]
        crowd = np.minimum(1.0, _ROWS_THAT_COUNT / count[index[keep]])[:, None]
        noise = _blurred(np.where(floor.within > 0, floor.within, np.inf), deviation)
        weight = np.isfinite(deviation) * crowd / noise**2
        streams.append((deviation, weight, index[keep], row_group[keep]))
    left, weight, source, group = (np.concatenate(each) for each in zip(*streams, strict=True))
    patterns = _patterns(left, weight)
    if declared is not None:
        of_means = [_of_captures(declared, index)] if use_means else []
        declared = np.concatenate([*of_means, np.zeros((len(keep), declared.shape[1]))])
    regression = Regression(
        context=context,
        floor=floor,
        residual=np.where(np.isfinite(left), left, 0.0),
        weight=weight,
        modes=_modes(context, first, patterns),
        group=group,
        source=source,
        index=index,
        keep=keep,
        use_means=use_means,
        n_patterns=len(patterns),
        declared=declared,
        row_group=row_group,
    )
    return regression if calibrated is None else replace(regression, calibrated=regression.lift(calibrated))


def _modes(context: Context, first: Ints, patterns: Floats) -> Floats:
    """The modes (n, m, K) of captures that begin at the rows `first` (n,): chambers, motions of the frame, patterns."""
    modes = [np.moveaxis(context.jacobian[first], 2, 1)]
    if (context.rows.axis >= 0).any():
        modes.append(np.moveaxis(frame_modes(context)[first], 2, 1))
    return np.concatenate([*modes, np.broadcast_to(patterns, (len(first), *patterns.shape))], axis=1)


def _blurred(noise: Floats, residual: Floats) -> Floats:
    """Noise with a share of the residual's own size: no formula is exact, so none is judged more finely."""
    size = np.sqrt(np.nanmean(np.where(np.isfinite(residual), residual, np.nan) ** 2))
    return np.sqrt(noise**2 + (FORM * size) ** 2)


def _of_captures(values: Floats, index: Ints) -> Floats:
    """One row per capture of values (F, D) that are the same in all its rows, (n, D)."""
    out = np.zeros((int(index.max()) + 1, values.shape[1]))
    out[index] = values
    return out


def _patterns(left: Floats, weight: Floats) -> Floats:
    """Directions over the observables in which what is `left` (S, K) stands clear of the noise, (r, K)."""
    K = left.shape[1]
    if K <= MAX_PATTERNS:
        return np.eye(K)
    whitened = np.where(weight > 0, left * np.sqrt(weight), np.nan)
    seen = np.isfinite(whitened).any(axis=1)
    _, s, Vt = svd(filled(whitened[seen]))
    clear = int((s > bulk_edge(int(seen.sum()), K)).sum())
    scale = 1 / np.sqrt(np.where(weight.max(axis=0) > 0, weight.max(axis=0), 1.0))
    return Vt[: int(np.clip(clear, 2, MAX_PATTERNS))] * scale
