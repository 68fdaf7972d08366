"""Spaces as columns: features under their prior, whitened, along the directions of a design, on principal axes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from labrig.arrays import Floats, Ints
from labrig.diagnosis._columns import Columns, flushed, gram
from labrig.diagnosis._observations import Observations
from labrig.diagnosis._spectra import factor, prior_of
from labrig.diagnosis._unnamed import slow_noise
from labrig.effects import Feature, Space, motion_scale

_MOST_COLUMNS = 64
"""Most columns of a space."""
_FREE_COLUMNS = 160
"""Most columns of a space with free patterns, which take one for each direction."""
_TOGETHER = 0.1
"""Of a free pattern each direction is one of many: as many that the data say a tenth as much of as the prior are heard
together."""
LEAST_SHARE = 2e-5
"""Share of a family's variance below which a direction is left out: half a per cent of its size."""


@dataclass(frozen=True)
class Made:
    """A space that was laid out, once for all its owners, without its features: (S, C, q) where it acts through
    pressures, or (S, r, q); of the first observations alone where the others are nothing.
    """

    columns: Floats
    through: bool
    owners: list[tuple[str, Space]]


def _side_by_side(made: list[Made], rows: tuple[int, int], dtype: "np.dtype[Any]") -> Floats:
    """The columns of all of these in one array; the list is empty after it."""
    out, at = np.zeros((*rows, sum(m.columns.shape[2] for m in made)), dtype=dtype), 0
    while made:
        columns = made.pop(0).columns
        out[: len(columns), :, at : (at := at + columns.shape[2])] = columns
    return out


def _shown(L: Floats, shows: Floats) -> Floats:
    """Functions L (a, q) as principal ones, their squares' sums L' `shows` L, without those that hardly show: all
    that are left out together are a direction that would be.
    """
    power, turn = np.linalg.eigh(L.T @ shows @ L)
    return L @ turn[:, np.cumsum(power) > LEAST_SHARE * max(power.sum(), 0.0)]


def _fewer(moves: Floats) -> Floats:
    """Slopes (n, r, C) whose products are the same, in fewer directions where there are fewer chambers."""
    return moves if moves.shape[1] <= moves.shape[2] else np.linalg.qr(moves)[1]


@dataclass(frozen=True)
class _Rows:
    """Rows at which features are asked: their numbers in `index` (m,), the number of their `capture` (m,), and how many
    rows each stands for; `still`: the first of each capture for all of it, as nothing changes within holds.
    """

    index: Ints
    capture: Ints
    count: Floats
    still: bool


class Layout:
    """Turns features into whitened columns along the directions V."""

    def __init__(self, observations: Observations, V: Floats) -> None:
        self.observations, self.V = observations, V
        self.dtype = V.dtype
        self.moves = self._along(V)
        self.fewer = _fewer(self.moves)
        self.T = csr_matrix(observations.whiten, dtype=self.dtype)

    def rows(self, features: Sequence[Feature]) -> _Rows:
        """The rows at which to ask for these features."""
        of = self.observations
        if all(np.array_equal(f.values, f.values[of.first][of.index]) for f in features):
            count = np.bincount(of.index).astype(float)
            return _Rows(of.first, np.arange(of.n_captures), count, still=True)
        return self.every

    @property
    def every(self) -> _Rows:
        """All rows."""
        index = self.observations.index
        return _Rows(np.arange(len(index)), index, np.ones(len(index)), still=False)

    def _along(self, V: Floats) -> Floats:
        """How far each chamber's whole range moves each capture along directions V (K, r), in floors, (n, r, C)."""
        return np.einsum("nkc,kr->nrc", self.observations.slopes.astype(self.dtype), V.astype(self.dtype))

    def columns(self, space: Space) -> Floats | None:
        """Whitened columns (S, r, q), of one floor in all, rotated to principal axes; (n, r, q) of what stays as it is
        within each hold, whose other observations are nothing.
        """
        if space.apart is not None:
            return self.apart(space, space.apart)
        at = self.rows(space.features)
        raw = self.raw(space, at)
        square = float((at.count * np.einsum("frq,frq->f", raw, raw)).sum())
        W = self.lift(raw, at)
        U = self.axes(space, square, W.reshape(-1, W.shape[2]))
        return None if U is None else flushed(W @ U)

    def axes(self, space: Space, square: float, W: Floats) -> Floats | None:
        """The principal axes (q, p) of whitened columns whose rows have this square, for one floor in all."""
        total = square / (len(self.observations.index) * len(self.observations.unit))
        if total <= 0:
            return None
        power, U = np.linalg.eigh(gram(W) / total)
        heard = self._said() * (_TOGETHER if self.wide(space) else 1.0)
        keep = power > max(heard, LEAST_SHARE * power.sum())
        keep[: max(0, len(keep) - max(_MOST_COLUMNS, self.wide(space)))] = False
        return (U[:, keep][:, ::-1] / np.sqrt(total)).astype(self.dtype) if keep.any() else None

    def apart(self, space: Space, groups: Floats) -> Floats | None:
        """`columns` of changes of pressures that each group of observables (n, K) shows in a measure of its own; all
        groups count alike.
        """
        out, most = [], _FREE_COLUMNS // len(groups)
        for own in groups:
            moves = self._along(own[:, None] * self.V)
            Z = self.through_pressures(space, moves)
            if Z is not None:
                slopes = moves[self.observations.capture[: len(Z)]]
                out.append(slopes @ (Z[:, :, :most] / np.sqrt(len(groups))))
        return np.concatenate(out, axis=2) if out else None

    def through_pressures(self, space: Space, within: Floats | None = None) -> Floats | None:
        """`columns` of changes of pressures alone, as what they do to the pressures, (S or n, C, q).

        How they move the observables is one matrix (r, C) all through a capture. So only the pressures are whitened,
        and the axes are found in the chambers' own coordinates, where these are fewer. `within` (n, r, C): the
        slopes of each capture, where they are not those of all observables.
        """
        moves = self.moves if within is None else within
        fewer = self.fewer if within is None else _fewer(within)
        prior, capture, at = prior_of(space), self.observations.capture, self.rows(space.features)
        P = flushed(np.stack([f.values[at.index] for f in space.features], axis=2).astype(self.dtype))
        C = P.shape[1]  # (m, C, a)
        both = (moves.transpose(0, 2, 1) @ moves)[at.capture]
        alone = np.einsum("fcc->fc", both)
        size = np.average(alone, axis=0, weights=at.count)
        shows = np.sum([size[c] * (P[:, c] * at.count[:, None]).T @ P[:, c] for c in range(C)], axis=0)
        shared, own = (_shown(factor(L), shows).astype(self.dtype) for L in (prior.shared, prior.own))
        if C == 1:
            own = own[:, :0]
        if shared.shape[1] + own.shape[1] == 0:
            return None
        rows = P @ shared
        square = np.einsum("fcq,fcq->f", both @ rows, rows) + np.einsum("fc,fcq->f", alone, (P @ own) ** 2)
        lifted = self.lift(P, at)
        Z = np.zeros((len(lifted), C, shared.shape[1] + C * own.shape[1]), dtype=self.dtype)
        Z[:, :, : shared.shape[1]] = lifted @ shared
        for c in range(C):
            start = shared.shape[1] + c * own.shape[1]
            Z[:, c, start : start + own.shape[1]] = lifted[:, c] @ own
        seen = fewer[capture[: len(Z)]] @ Z
        U = self.axes(space, float(at.count @ square), seen.reshape(-1, Z.shape[2]))
        return None if U is None else flushed(Z @ U)

    def together(self, made: "list[Made]") -> Columns:
        """All columns: first those that act through pressures, then the others. Each is let go once it is copied, so
        `made` is empty after it: of many captures there would not be room for all of them twice.
        """
        capture, C, r = self.observations.capture, self.moves.shape[2], self.V.shape[1]
        of = {acts: [m for m in made if m.through == acts] for acts in (True, False)}
        made.clear()
        through = _side_by_side(of[True], (len(capture), C), self.dtype)
        return Columns(through, self.moves, capture, _side_by_side(of[False], (len(capture), r), self.dtype))

    def _said(self) -> float:
        """The power of a direction of which the data say as much as its prior, at the size of all to explain."""
        return 1.0 / (self.observations.worth * max(1.0, self.observations.to_explain) ** 2)

    def wide(self, space: Space) -> int:
        """How many columns a space may keep: a free pattern takes one for each direction."""
        return _FREE_COLUMNS if any(f.kind == "pattern" for f in space.features) else 0

    def raw(self, space: Space, at: _Rows) -> Floats:
        """Columns (m, r, q) of some rows in floors, each of unit prior variance."""
        prior = prior_of(space)
        unit, V = self.observations.unit, self.V
        pressures, fields, patterns = (
            [f.values[at.index] for f in space.features if f.kind == kind]
            for kind in ("pressure", "field", "pattern")
        )
        out = []
        shared = []
        if pressures:
            P = flushed(np.stack(pressures, axis=2).astype(self.dtype))  # (m, C, a)
            moves = self.moves[at.capture]
            shared.append(moves @ P)
            own = factor(prior.own).astype(self.dtype)
            if own.shape[1] and P.shape[1] > 1:
                each = P @ own
                out.append((moves[:, :, :, None] * each[:, None]).reshape(len(P), V.shape[1], -1))
        if fields:
            shared.append(np.stack([(f / unit).astype(self.dtype) @ V for f in fields], axis=2))
        if shared:
            out.append(np.concatenate(shared, axis=2) @ factor(prior.shared).astype(self.dtype))
        if patterns:
            r = V.shape[1]
            L = factor(prior.pattern)
            L = L[:, np.argsort(-(L**2).sum(axis=0))][:, : max(1, _FREE_COLUMNS // r)]
            size = float(np.sqrt(np.mean((motion_scale(self.observations.context) / unit) ** 2)))
            Q = (size * np.stack(patterns, axis=1) @ L).astype(self.dtype)
            wide = np.zeros((len(Q), r, Q.shape[1], r), dtype=self.dtype)
            wide[:, np.arange(r), :, np.arange(r)] = Q[None]
            out.append(wide.reshape(len(Q), r, -1))
        return np.concatenate(out, axis=2)

    def way(self, along: Feature, W: Columns, at: slice) -> Floats:
        """How much of a feature's own change each column of a block has, (q,): of pressures in each chamber by itself,
        by how far it moves the rig, since chambers that move it against each other are no less held back.
        """
        if along.kind == "pressure":
            shows = np.einsum("nrc,nrc->nc", self.moves, self.moves)[self.observations.capture]
            held = self.T @ along.values.astype(self.dtype)
            return np.einsum("sc,scq->q", shows * held, W.through[:, :, at]).astype(float)
        raw = ((along.values / self.observations.unit).astype(self.dtype) @ self.V)[:, :, None]
        return np.asarray(self.lift(raw).reshape(-1) @ W.of(at), dtype=float)

    def lift(self, raw: Floats, at: _Rows | None = None) -> Floats:
        """Rows (F, r, q), or some of them, to observations (S, r, q); still ones to means (n, r, q), which they are."""
        if at is not None and at.still:
            return raw
        F, r, q = raw.shape
        return self.observations.of_rows(raw.reshape(F, r * q), self.T).reshape(-1, r, q)

    def regressors(self, space: Space) -> Floats:
        """Regressors (S, g) of free patterns, of one floor in all, as principal axes."""
        f = np.stack(
            [np.sqrt(q.weight) * q.values / (np.sqrt(np.mean(q.values**2)) + 1e-12) for q in space.features],
            axis=1,
        )
        f = f / np.sqrt((f**2).sum() / len(f))
        G = self.observations.of_rows(f)
        power, U = np.linalg.eigh(G.T @ G)
        keep = power > max(_TOGETHER * self._said(), 1e-7 * power[-1])
        return (G @ U[:, keep])[:, ::-1]

    def fields(self, values: Floats) -> Floats:
        """Columns of fields (F, K, q) in the observables' units, each of one floor."""
        raw = np.einsum("fkq,kr->frq", values / self.observations.unit[None, :, None], self.V).astype(
            self.dtype
        )
        raw = raw / np.maximum(np.sqrt((raw**2).sum(axis=1).mean(axis=0) / len(self.V)), 1e-12)
        return self.lift(raw)

    def slow(self) -> Floats:
        """Slow noise along each axis (of unmarked observables: of all together), one floor."""
        rows = self.observations.context.rows
        series = slow_noise(self.observations.index).astype(self.dtype)
        axes = [rows.axis == a for a in (-1, 0, 1, 2) if (rows.axis == a).any()]
        raw = np.concatenate(
            [series[:, None, :] * self.V[a].sum(axis=0)[None, :, None] for a in axes], axis=2
        )
        return self.lift(raw)
