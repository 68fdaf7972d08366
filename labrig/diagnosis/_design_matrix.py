"""An effect's variant as columns of the regression, and the sums that scoring needs."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.diagnosis._regression import Regression, solve_calibrated
from labrig.effects import Term, Variant


@dataclass(frozen=True)
class Split:
    """Gram matrix (Q, Q) and products with the residual (Q,): of the blocks fitted to, and of the one left out."""

    gram: Floats
    product: Floats
    own_gram: Floats
    own_product: Floats


@dataclass(frozen=True)
class DesignMatrix:
    """Q columns over S rows: `X` (S, u, q) over the modes `used` (u,), then `E` (S, K, Q - q) as fields.

    `prior` (Q,) is what the run says on average of coefficients that are equally likely beforehand, 0 of free ones.
    """

    regression: Regression
    X: Floats
    used: Ints
    E: Floats
    prior: Floats

    @property
    def width(self) -> int:
        """How many columns there are."""
        return self.X.shape[2] + self.E.shape[2]

    @cached_property
    def sums(self) -> tuple[Floats, Floats]:
        """Per left-out block: Gram matrices (G, Q, Q) and products with the residual (G, Q)."""
        return self._beside_calibrated(*self._whole, None)

    @cached_property
    def _whole(self) -> tuple[Floats, Floats]:
        """Sums of these columns and the calibrated parameters, declared ones fitted to all blocks."""
        return self._sums(self.X, self.E, self.regression.residual, self.regression.projected, None)

    def held_out(self, fold: int) -> "Split":
        """The sums over all blocks but `fold`, and over that one, the base's own parameters fitted without it."""
        s = self.regression
        if s.declared is not None and s.calibrated is None and not self.X.shape[2]:
            return self._fields_held_out(fold)
        G, c = self._beside_calibrated(*self._all_sums(fold), fold)
        return Split(G.sum(axis=0) - G[fold], c.sum(axis=0) - c[fold], G[fold], c[fold])

    def _fields_held_out(self, fold: int) -> "Split":
        """`held_out` of fields alone, from sums that are worked out once for all folds.

        With Z the fields and the residual, D the declared regressors and B their coefficients, fitted to the other
        blocks, the sums of Z - D B are Z'Z - Z'D B - B'D'Z + B'D'D B, for each observable with its own weights.
        """
        square, cross, common = self._field_sums
        gram = self.regression.declared_sums
        B = self.regression.declared_inverses[fold] @ (common.sum(axis=0) - common[fold])

        def of(square: Floats, cross: Floats, gram: Floats) -> Floats:
            n = B.shape[-1]
            both = cross.reshape(-1, n).T @ B.reshape(-1, n)
            return square - both - both.T + B.reshape(-1, n).T @ (gram @ B).reshape(-1, n)

        train = of(*(x.sum(axis=0) - x[fold] for x in (square, cross, gram)))
        own = of(square[fold], cross[fold], gram[fold])
        return Split(train[:-1, :-1], train[:-1, -1], own[:-1, :-1], own[:-1, -1])

    @cached_property
    def _field_sums(self) -> tuple[Floats, Floats, Floats]:
        """Per block, of the fields and the residual Z (S, K, Q + 1): Z'WZ (G, Q + 1, Q + 1), and D'WZ for each
        observable (G, K, d, Q + 1) with its own weights W and with the common ones.
        """
        s = self.regression
        Z = np.concatenate([self.E, s.residual[:, :, None]], axis=2)
        square, cross, common = [], [], []
        for own, (weighted, alike) in zip(s.blocks, s.declared_weighted, strict=True):
            z = Z[own]
            square.append(
                (s.weight[own][:, :, None] * z).reshape(-1, z.shape[2]).T @ z.reshape(-1, z.shape[2])
            )
            of_each = np.ascontiguousarray(z.transpose(1, 0, 2))
            cross.append(weighted @ of_each)
            common.append(alike @ of_each)
        return np.array(square), np.array(cross), np.array(common)

    def _beside_calibrated(self, G: Floats, c: Floats, without: int | None) -> tuple[Floats, Floats]:
        """Sums of these columns alone: the calibrated parameters, which come last, are fitted to the other blocks."""
        n = self.width
        if n == G.shape[1]:
            return G, c
        train = np.arange(len(G)) != (len(G) if without is None else without)
        total, target = G[train].sum(axis=0), c[train].sum(axis=0)
        right = np.column_stack([total[n:, :n], target[n:]])
        answer = solve_calibrated(total[n:, n:], right)
        turn = np.vstack([np.eye(n), -answer[:, :n]])
        return turn.T @ G @ turn, (c - G[:, :, n:] @ answer[:, n]) @ turn

    def _answer(self, without: int | None) -> Floats:
        """How the calibrated parameters give way to the effect's coefficients, (D, Q)."""
        n, G = self.width, self._all_sums(without)[0]
        total = G.sum(axis=0) if without is None else G.sum(axis=0) - G[without]
        return -solve_calibrated(total[n:, n:], total[n:, :n])

    def _all_sums(self, without: int | None) -> tuple[Floats, Floats]:
        """Sums of these columns and the calibrated parameters, declared ones fitted to all blocks or `without` one."""
        s = self.regression
        if s.declared is None or without is None:
            return self._whole
        residual, projected = s.fold_residuals[without]
        return self._sums(
            s.partial(self.X, without), s.partial(self.E, without), residual, projected, without
        )

    def _sums(
        self, X: Floats, E: Floats, residual: Floats, g: Floats, fold: int | None
    ) -> tuple[Floats, Floats]:
        s = self.regression
        q, n = X.shape[2], X.shape[2] + E.shape[2]
        calibration = s.calibration(fold)
        width = n + (calibration.fields.shape[2] if calibration else 0)
        G = np.zeros((s.n_groups, width, width))
        c = np.zeros((s.n_groups, width))
        H = s.products[:, self.used[:, None], self.used] if q else None
        for group, own in enumerate(s.blocks):
            if H is not None:
                x = X[own]
                Hx = H[own] @ x
                flat = x.reshape(-1, q)
                G[group, :q, :q] = flat.T @ Hx.reshape(-1, q)
                c[group, :q] = flat.T @ g[own][:, self.used].reshape(-1)
            if E.shape[2]:
                e = E[own]
                we = s.weight[own][:, :, None] * e
                flat = e.reshape(-1, e.shape[2])
                G[group, q:n, q:n] = flat.T @ we.reshape(-1, e.shape[2])
                c[group, q:n] = we.reshape(-1, e.shape[2]).T @ residual[own].reshape(-1)
                if q:
                    modes = s.modes[s.source[own]][:, self.used]
                    cross = X[own].transpose(0, 2, 1) @ (modes @ we)
                    G[group, :q, q:n] = cross.sum(axis=0)
                    G[group, q:n, :q] = G[group, :q, q:n].T
            if calibration:
                weighted = calibration.weighted[own].reshape(-1, width - n)
                G[group, n:, n:] = calibration.fields[own].reshape(-1, width - n).T @ weighted
                c[group, n:] = residual[own].reshape(-1) @ weighted
                if q:
                    products = calibration.products[own][:, self.used].reshape(-1, width - n)
                    G[group, :q, n:] = X[own].reshape(-1, q).T @ products
                if n > q:
                    G[group, q:n, n:] = E[own].reshape(-1, n - q).T @ weighted
                G[group, n:, :n] = G[group, :n, n:].T
        return G, c

    def field(self, beta: Floats, rows: Any = slice(None), without: int | None = None) -> Floats:
        """What the columns predict with coefficients `beta` (Q,), over its rows (or some `rows`) and observables.

        The base's own parameters give way to them as all blocks say, or all `without` one.
        """
        s, X, E = self.regression, self.X, self.E
        if without is not None and s.declared is not None:
            X, E = s.partial(X, without), s.partial(E, without)
        modes = s.modes[:, self.used]
        out = np.einsum("su,suk->sk", X[rows] @ beta[: X.shape[2]], modes[s.source[rows]], optimize=True)
        calibration = s.calibration(without)
        if calibration:
            out += calibration.fields[rows] @ (self._answer(without) @ beta)
        return out + E[rows] @ beta[X.shape[2] :]


def columns_of(regression: Regression, variant: Variant) -> DesignMatrix:
    """Lay out a variant's terms; patterns are spread over the directions that stand clear of the noise."""
    S, K = regression.residual.shape
    over_modes = [_over_modes(regression, term) for term in variant.terms if term.kind != "field"]
    fields = [regression.lift(term.feature) for term in variant.terms if term.kind == "field"]
    X = np.concatenate([np.zeros((S, regression.modes.shape[1], 0)), *over_modes], axis=2)
    E = np.concatenate([np.zeros((S, K, 0)), *fields], axis=2)
    used = np.flatnonzero(np.abs(X).sum(axis=(0, 2)) > 0)
    X = X[:, used]
    if regression.declared is not None and X.shape[2] and regression.modes_change:
        # what the base's own parameters take off such modes is no longer along them
        moved = np.einsum("suq,suk->skq", X, regression.modes[:, used][regression.source], optimize=True)
        E = np.concatenate([moved, E], axis=2)
        X, used = np.zeros((S, 0, 0)), np.zeros(0, dtype=np.int64)
    X, E = regression.partial(X), regression.partial(E)
    out = DesignMatrix(regression, X, used, E, np.zeros(X.shape[2] + E.shape[2]))
    alike = np.zeros(out.width, dtype=bool)
    for term, own in columns_by_term(variant, regression.n_patterns):
        alike[own] = term.basis is not None
    if not alike.any():
        return out
    said = np.diagonal(out.sums[0].sum(axis=0))[alike].mean()
    return replace(out, prior=np.where(alike, said, 0.0))


def _over_modes(regression: Regression, term: Term) -> Floats:
    """A term that is no field as columns over the modes, (S, m, q)."""
    C, r = regression.context.jacobian.shape[2], regression.n_patterns
    feature = regression.lift(term.feature)
    S, m = len(feature), regression.modes.shape[1]
    if term.kind == "pressure":
        out = np.zeros((S, m, feature.shape[2]))
        out[:, :C] = feature
    elif term.kind == "frame":
        out = np.zeros((S, m, 6))
        out[:, range(C, C + 6), range(6)] = feature[:, None]
    else:
        out = np.zeros((S, m, feature.shape[1] * r))
        for j in range(feature.shape[1]):
            out[:, range(m - r, m), range(j * r, (j + 1) * r)] = feature[:, [j]]
    return out


def join(parts: Sequence[DesignMatrix]) -> DesignMatrix:
    """Put several effects' columns side by side. Fields come last, so use `order_of` to find a part's own."""
    if len(parts) == 1:
        return parts[0]
    used = np.unique(np.concatenate([p.used for p in parts]))
    S = len(parts[0].regression.source)
    blocks = []
    for p in parts:
        block = np.zeros((S, len(used), p.X.shape[2]))
        if p.X.shape[2]:
            block[:, np.searchsorted(used, p.used)] = p.X
        blocks.append(block)
    E = np.concatenate([p.E for p in parts], axis=2)
    prior = [p.prior[: p.X.shape[2]] for p in parts] + [p.prior[p.X.shape[2] :] for p in parts]
    return DesignMatrix(parts[0].regression, np.concatenate(blocks, axis=2), used, E, np.concatenate(prior))


def order_of(parts: Sequence[DesignMatrix]) -> list[Ints]:
    """For each part, where its own columns stand among those of `join(parts)`."""
    x_at, e_at = 0, sum(p.X.shape[2] for p in parts)
    out = []
    for p in parts:
        own_x = np.arange(x_at, x_at + p.X.shape[2])
        own_e = np.arange(e_at, e_at + p.E.shape[2])
        out.append(np.concatenate([own_x, own_e]).astype(np.int64))
        x_at, e_at = x_at + p.X.shape[2], e_at + p.E.shape[2]
    return out


def coefficients(columns: DesignMatrix, variant: Variant, beta: Floats) -> list[Floats]:
    """Split a variant's coefficients by term; a pattern's become one row (K,) for each of its columns."""
    r, patterns = columns.regression.n_patterns, columns.regression.patterns
    found = {
        id(term): beta[own].reshape(-1, r) @ patterns if term.kind == "pattern" else beta[own]
        for term, own in columns_by_term(variant, r)
    }
    return [found[id(term)] for term in variant.terms]


def columns_by_term(variant: Variant, n_patterns: int) -> Iterator[tuple[Term, slice]]:
    """The terms of a variant, each with its own columns: fields stand last."""
    start = 0
    for term in sorted(variant.terms, key=lambda term: term.kind == "field"):
        width = 6 if term.kind == "frame" else term.feature.shape[-1]
        if term.kind == "pattern":
            width *= n_patterns
        yield term, slice(start, start := start + width)
