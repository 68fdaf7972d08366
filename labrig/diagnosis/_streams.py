"""The regression problem: rows become two streams, observables become a few modes.

Each capture gives its mean over the hold and, where the hold has several rows, the deviations from it;
each stream is weighted by its own noise, so that what changes within a hold (creep, leak) and what differs
between captures are both seen at their true worth. An effect's column is then a short vector over the
modes (chambers through the Jacobian, rigid motions of the frame, free patterns), and everything that
scoring needs are sums over rows of mode-by-mode products: no step depends on the number of observables.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from labrig.diagnosis._floor import Floor, capture_means
from labrig.diagnosis._spectrum import bulk_edge, fill
from labrig.effects import Context
from labrig.effects._fields import frame_modes
from labrig.effects._rows import Floats, Ints

MAX_PATTERNS = 8
MAX_GROUPS = 12
_SESSIONS_AS_GROUPS = 6
_FEW_CAPTURES = 3
_FAR = 8.0
_MOST_FAR = 0.2
_SMOOTH_RANK = 10
_STAYS = 4
_FORM = 0.03
_ROWS_THAT_COUNT = 12
_CAPTURES_PER_TERM = 7
_CAPTURES_PER_LINE = 3
_STATIC_RIDGE = 0.01


@dataclass(frozen=True)
class Streams:
    """Weighted rows ready for regression; S stream rows, m modes, K observables.

    `weight` (S, K) is 1 / noise^2, 0 where nothing was seen; `residual` (S, K); `modes` (captures, m, K);
    `group` (S,) is which block is left out with it; `source` (S,) its capture, as an index.
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
    has_frame: bool
    declared: Floats | None
    row_group: Ints
    as_features: bool = False

    @property
    def n_groups(self) -> int:
        """How many blocks are left out in turn."""
        return int(self.group.max()) + 1

    def lift(self, feature: Floats) -> Floats:
        """Carry a feature of the rows (F, ...) to the streams (S, ...): means, then deviations."""
        n = int(self.index.max()) + 1
        count = np.bincount(self.index, minlength=n).reshape(-1, *[1] * (feature.ndim - 1))
        mean = np.zeros((n, *feature.shape[1:]))
        np.add.at(mean, self.index, feature)
        mean /= count
        deviation = feature[self.keep] - mean[self.index[self.keep]]
        return np.concatenate([mean, deviation]) if self.use_means else deviation

    @cached_property
    def products(self) -> Floats:
        """Mode-by-mode products of each stream row, (S, m, m)."""
        M = self.modes
        out = np.empty((len(self.source), M.shape[1], M.shape[1]))
        for i, c in enumerate(self.source):
            weighted = M[c] * self.weight[i]
            out[i] = weighted @ M[c].T
        return out

    @cached_property
    def projected(self) -> Floats:
        """Products of modes and residuals, (S, m), the base's own parameters fitted to all blocks."""
        return self.project(self.residual)

    @cached_property
    def nothing(self) -> Floats:
        """What the base's own parameters, fitted without each block, change in it, (S, K)."""
        if self.declared is None:
            return np.zeros_like(self.residual)
        out = np.zeros_like(self.residual)
        for g, own in enumerate(self.blocks):
            out[own] = (self.residual - self.partial(self.residual, self.group != g))[own]
        return out

    @property
    def patterns(self) -> Floats:
        """The free directions over the observables, (r, K)."""
        return self.modes[0, self.modes.shape[1] - self.n_patterns :]

    @property
    def within_holds(self) -> NDArray[np.bool_]:
        """Which stream rows are deviations within a hold, (S,)."""
        n = int(self.index.max()) + 1 if self.use_means else 0
        return np.arange(len(self.source)) >= n

    @cached_property
    def base_squares(self) -> Floats:
        """Weighted square of what the base leaves in each block, (G,)."""
        each = self.square(self.residual - self.nothing)
        return np.array([each[own].sum() for own in self.blocks])

    @cached_property
    def counted(self) -> Ints:
        """The observables that errors are quoted for: those of the commonest unit."""
        units = self.context.rows.unit
        commonest = max(dict.fromkeys(units), key=units.count)
        return np.array([k for k, u in enumerate(units) if u == commonest])

    @cached_property
    def blocks(self) -> list[Ints]:
        """The stream rows of each left-out block."""
        return [np.flatnonzero(self.group == g) for g in range(self.n_groups)]

    def beside_static(self) -> "Streams | None":
        """The same with a smooth static map of the pressures as the base's own; None with too few captures.

        Its powers of each pressure, up to the third where there are captures enough, explain what they can
        first (features are projected as if the modes did not change between captures), so that what is left
        of an effect is its own.
        """
        x = self.context.rows.fraction
        n = int(self.index.max()) + 1
        if not self.use_means:
            return self
        width = x.shape[1]
        enough = {1: _CAPTURES_PER_LINE * (1 + width), 2: _CAPTURES_PER_TERM * (1 + 2 * width)}
        enough[3] = _CAPTURES_PER_TERM * (1 + 3 * width)
        degree = max((k for k, least in enough.items() if n >= least), default=0)
        if degree == 0:
            return None
        columns = np.column_stack([np.ones(len(x)), *(x**k for k in range(1, degree + 1))])
        static = np.concatenate(
            [_per_capture(columns, self.index), np.zeros((len(self.keep), columns.shape[1]))]
        )
        both = static if self.declared is None else np.column_stack([self.declared, static])
        return replace(self, declared=both, as_features=True)

    @cached_property
    def constant_modes(self) -> bool:
        """Whether the modes are the same in every capture, so that a feature can be projected on its own."""
        return self.as_features or bool(
            np.allclose(self.modes, self.modes[:1], rtol=1e-6, atol=1e-9 * np.abs(self.modes).max())
        )

    def partial(self, target: Floats, train: NDArray[np.bool_]) -> Floats:
        """What the base's own parameters, fitted to the rows `train`, leave of `target` (S, ...)."""
        if self.declared is None or target.size == 0:
            return target
        w = np.sqrt(self.weight.max(axis=1))
        fit = train & (w > 0)
        flat = target.reshape(len(target), -1)
        A, b = self.declared[fit] * w[fit, None], flat[fit] * w[fit, None]
        if self.as_features:
            ridge = _STATIC_RIDGE * np.diag(np.square(A).sum(axis=0))
            beta = np.linalg.solve(A.T @ A + ridge + 1e-12 * np.eye(A.shape[1]), A.T @ b)
        else:
            beta = np.linalg.lstsq(A, b, rcond=1e-9)[0]
        return (flat - self.declared @ beta).reshape(target.shape)

    def project(self, residual: Floats) -> Floats:
        """Products of modes and residuals of each stream row, (S, m), for residuals (S, K)."""
        return np.einsum("smk,sk->sm", self.modes[self.source], self.weight * residual, optimize=True)

    def square(self, residual: Floats) -> Floats:
        """Weighted square of residuals, (S,)."""
        return (self.weight * residual**2).sum(axis=1)


def clean(residual: Floats, capture: Ints) -> tuple[Floats, int]:
    """Drop entries that lie far from what their neighbours in time and space say; returns how many.

    Where there are several observables, "far" is against a low-rank fit of all rows (what is physical has
    low rank, a mistaken marker has not); with few, against the running median along the campaign. Captures
    and rows are looked at in turn, since a mistake may last for a whole hold or for one frame.
    """
    if len(np.unique(capture)) < 6 and len(residual) < 20:
        return residual, 0
    seen = np.isfinite(residual).any(axis=0)
    if not seen.all():
        rows = residual.copy()
        rows[:, seen], dropped = clean(residual[:, seen], capture)
        return rows, dropped
    captures, index = np.unique(capture, return_inverse=True)
    rows = np.where(_passing(_far(residual), index), np.nan, residual)
    means, _ = capture_means(rows, capture)
    if len(captures) >= 6:
        rows = np.where(_passing(_far(means), np.arange(len(captures)))[index], np.nan, rows)
    return rows, int((np.isfinite(residual) & ~np.isfinite(rows)).sum())


def _passing(far: NDArray[np.bool_], index: Ints) -> NDArray[np.bool_]:
    """Only what passes: an entry that stays far for several captures on end has moved, and is no mistake."""
    n = int(index.max()) + 1
    touched = np.zeros((n, far.shape[1]), dtype=bool)
    np.logical_or.at(touched, index, far)
    if n < _STAYS:
        return far
    whole = np.logical_and.reduce([touched[shift : n - _STAYS + 1 + shift] for shift in range(_STAYS)])
    stays = np.zeros_like(touched)
    for shift in range(_STAYS):
        stays[shift : shift + len(whole)] |= whole
    return far & ~stays[index]


def _far(values: Floats) -> NDArray[np.bool_]:
    """Which entries are far from what the others say, (n, K)."""
    if values.shape[1] >= 8 and len(values) >= 12:
        off = np.abs(values - _smooth(values))
    else:
        off = np.abs(values - _running_median(fill(values)))
    middle = np.nanmedian(values, axis=0)
    spread = 1.4826 * np.nanmedian(np.abs(values - middle), axis=0)
    bad = off > _FAR * np.maximum(1.4826 * np.nanmedian(off), _FORM * spread)
    structure = bad.mean(axis=1) > _MOST_FAR
    return bad & ~structure[:, None] if values.shape[1] >= 8 else bad


def _smooth(values: Floats) -> Floats:
    """A low-rank fit that outlying entries cannot pull: directions from clipped values, Huber weights by row."""
    middle = np.nanmedian(values, axis=0)
    spread = 1.4826 * np.nanmedian(np.abs(values - middle), axis=0)
    limit = 4 * np.maximum(spread, np.median(spread))
    clipped = fill(np.clip(values, middle - limit, middle + limit))
    _, _, Vt = np.linalg.svd(clipped, full_matrices=False)
    V = Vt[: min(_SMOOTH_RANK, min(values.shape) // 3)]
    known = np.where(np.isfinite(values), values, 0.0)
    w = np.isfinite(values).astype(float)
    expected = clipped @ V.T @ V
    for _ in range(6):
        off = np.abs(known - expected)
        scale = 1.4826 * np.median(off[w > 0])
        weight = np.where(w > 0, np.minimum(1.0, 2 * scale / np.maximum(off, 1e-12)), 0.0)
        H = np.einsum("rk,nk,qk->nrq", V, weight, V, optimize=True) + 1e-9 * np.eye(len(V))
        z = np.linalg.solve(H, ((weight * known) @ V.T)[:, :, None])[:, :, 0]
        expected = z @ V
    return expected


def _running_median(values: Floats, half: int = 3) -> Floats:
    """Median of the neighbours along the campaign, with the spread of the values added as slack."""
    padded = np.pad(values, ((half, half), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0)
    low, high = np.quantile(windows, [0.15, 0.85], axis=-1)
    return np.clip(values, low - (high - low), high + (high - low))


def build_streams(context: Context, floor: Floor, residual: Floats, declared: Floats | None) -> Streams:
    """Lay out the regression for what the base leaves, `residual` (F, K), outliers already NaN.

    `declared` (F, D) are the regressors of the base's own parameters, refitted beside every effect.
    """
    rows = context.rows
    captures, index = np.unique(rows.capture, return_inverse=True)
    n = len(captures)
    count = np.bincount(index)
    use_means = n >= _FEW_CAPTURES or count.max() == 1
    keep = np.flatnonzero((count[index] > 1) & (floor.within.max() > 0))
    means, _ = capture_means(residual, rows.capture)
    parts, weights, sources = [], [], []
    if use_means:
        parts.append(means)
        weights.append(np.isfinite(means) / _blurred(floor.mean, means) ** 2)
        sources.append(np.arange(n))
    if len(keep):
        deviation = residual[keep] - means[index[keep]]
        parts.append(deviation)
        crowd = np.minimum(1.0, _ROWS_THAT_COUNT / count[index[keep]])[:, None]
        noise = _blurred(np.where(floor.within > 0, floor.within, np.inf), deviation)
        weights.append(np.isfinite(deviation) * crowd / noise**2)
        sources.append(index[keep])
    stacked = np.concatenate(parts)
    weight = np.concatenate(weights)
    source = np.concatenate(sources)
    group_of_row = _groups(context, index, use_means)
    group = np.concatenate(
        ([group_of_row[np.searchsorted(index, np.arange(n))]] if use_means else [])
        + ([group_of_row[keep]] if len(keep) else [])
    )
    patterns = _patterns(stacked, weight)
    if declared is not None:
        constant = [_per_capture(declared, index)] if use_means else []
        declared = np.concatenate([*constant, np.zeros((len(keep), declared.shape[1]))])
    first = np.searchsorted(rows.capture, captures)
    modes = [np.moveaxis(context.jacobian[first], 2, 1)]
    has_frame = bool((rows.axis >= 0).any())
    if has_frame:
        modes.append(np.moveaxis(frame_modes(context)[first], 2, 1))
    modes.append(np.broadcast_to(patterns, (n, *patterns.shape)))
    return Streams(
        context=context,
        floor=floor,
        residual=np.where(np.isfinite(stacked), stacked, 0.0),
        weight=weight,
        modes=np.concatenate(modes, axis=1),
        group=group,
        source=source,
        index=index,
        keep=keep,
        use_means=use_means,
        n_patterns=len(patterns),
        has_frame=has_frame,
        declared=declared,
        row_group=group_of_row,
    )


def _blurred(noise: Floats, residual: Floats) -> Floats:
    """Noise with a share of the residual's own size: no formula is exact, so none is judged more finely."""
    size = np.sqrt(np.nanmean(np.where(np.isfinite(residual), residual, np.nan) ** 2))
    return np.sqrt(noise**2 + (_FORM * size) ** 2)


def _per_capture(values: Floats, index: Ints) -> Floats:
    """One row per capture of what is the same in all its rows."""
    out = np.zeros((int(index.max()) + 1, values.shape[1]))
    out[index] = values
    return out


def _groups(context: Context, index: Ints, use_means: bool) -> Ints:
    """Which block each row is left out with: sessions where there are enough, else stretches of captures."""
    rows = context.rows
    if not use_means:
        place = np.arange(len(index)) - np.searchsorted(index, index)
        length = np.bincount(index)[index]
        return np.minimum((place * MAX_GROUPS) // length, MAX_GROUPS - 1).astype(np.int64)
    n = int(index.max()) + 1
    sessions = np.unique(rows.session)
    if len(sessions) >= min(_SESSIONS_AS_GROUPS, n):
        order = {s: i for i, s in enumerate(sessions)}
        each = np.array([order[s] for s in rows.session])
        return (each * min(len(sessions), MAX_GROUPS)) // len(sessions)
    return (index * min(n, MAX_GROUPS)) // n


def _patterns(stacked: Floats, weight: Floats) -> Floats:
    """Directions over the observables in which the residuals stand clear of the noise, (r, K)."""
    K = stacked.shape[1]
    if K <= MAX_PATTERNS:
        return np.eye(K)
    whitened = np.where(weight > 0, stacked * np.sqrt(weight), np.nan)
    seen = np.isfinite(whitened).any(axis=1)
    _, s, Vt = np.linalg.svd(fill(whitened[seen]), full_matrices=False)
    clear = int((s > bulk_edge(int(seen.sum()), K)).sum())
    scale = 1 / np.sqrt(np.where(weight.max(axis=0) > 0, weight.max(axis=0), 1.0))
    return Vt[: int(np.clip(clear, 2, MAX_PATTERNS))] * scale
