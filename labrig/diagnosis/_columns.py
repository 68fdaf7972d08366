"""The columns of a design, kept as small as what they are made of: those that act through pressures as pressures."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from labrig.arrays import Floats, Ints

_AT_ONCE = 128
"""How many columns are carried to the directions at once: it bounds the memory, and changes no number."""


@dataclass(frozen=True)
class Columns:
    """P columns over the numbers of S observations along r directions.

    The first p act through the pressures of C chambers: `through` (S, C, p) is what each does to them, and the slopes
    `moves` (n, r, C) of each observation's `capture` (S,) carry it to the directions. All others are `plain`
    (S, r, P - p). Written out they would be a matrix (S r, P) of several times the size.
    """

    through: Floats
    moves: Floats
    capture: Ints
    plain: Floats

    @property
    def width(self) -> int:
        """How many columns there are, P."""
        return self.through.shape[2] + self.plain.shape[2]

    @property
    def dtype(self) -> "np.dtype[Any]":
        """The precision in which they are kept."""
        return self.plain.dtype

    def of(self, at: slice) -> Floats:
        """Some of them written out, (S r, q)."""
        p = self.through.shape[2]
        acting = self.through[:, :, slice(min(at.start, p), min(at.stop, p))]
        plain = self.plain[:, :, slice(max(at.start - p, 0), max(at.stop - p, 0))]
        both = np.concatenate([self._slopes @ acting, plain], axis=2)
        return both.reshape(len(both) * both.shape[1], both.shape[2])

    @property
    def whole(self) -> Floats:
        """All of them written out, (S r, P)."""
        return self.of(slice(0, self.width))

    def some(self, rows: Any) -> "Columns":
        """Those of some observations, by number or by mask (S,)."""
        return replace(self, through=self.through[rows], capture=self.capture[rows], plain=self.plain[rows])

    def turned(self, to: Floats) -> "Columns":
        """The same along other directions, each a combination (r, s) of these."""
        return replace(
            self,
            moves=np.einsum("nrc,rs->nsc", self.moves, to),
            plain=np.einsum("orq,rs->osq", self.plain, to),
        )

    @cached_property
    def _slopes(self) -> Floats:
        return self.moves[self.capture]

    def gram(self) -> Floats:
        """The Gram matrix (P, P), in double precision.

        What acts through pressures lies within the C directions of its capture's slopes: with these as Q R, products
        are those of R times the pressures, among each other and with the part Q' of the others.
        """
        p, (S, r, d), C = self.through.shape[2], self.plain.shape, self.moves.shape[2]
        out = np.empty((p + d, p + d))
        out[p:, p:] = gram(self.plain.reshape(S * r, d))
        if p == 0:
            return out
        if r > C:
            Q, R = np.linalg.qr(self.moves)
            seen = Q.transpose(0, 2, 1)[self.capture] @ self.plain
        else:
            R, seen = self.moves, self.plain
        acting = (R[self.capture] @ self.through).reshape(-1, p)
        out[:p, :p] = gram(acting)
        out[:p, p:] = acting.T @ seen.reshape(len(acting), d)
        out[p:, :p] = out[:p, p:].T
        return out

    def times(self, values: Floats) -> Floats:
        """Products (P,) with values (S, r)."""
        values = values.astype(self.dtype)
        through = np.einsum("src,sr->sc", self._slopes, values)
        parts = [_products(self.through, through), _products(self.plain, values)]
        return np.concatenate(parts).astype(np.float64)

    def beside(self, G: Floats) -> Floats:
        """Products (g, r, P) with regressors (S, g) along each direction by itself."""
        (S, r, d), p = self.plain.shape, self.through.shape[2]
        to = np.ascontiguousarray(G.T.astype(self.dtype))
        out = np.empty((len(to), r, self.width), dtype=self.dtype)
        for start in range(0, p, _AT_ONCE):
            some = self._slopes @ self.through[:, :, start : start + _AT_ONCE]
            q = some.shape[2]
            out[:, :, start : start + q] = (to @ some.reshape(S, r * q)).reshape(len(to), r, q)
        out[:, :, p:] = (to @ self.plain.reshape(S, r * d)).reshape(len(to), r, d)
        return out

    def made(self, weights: Floats) -> Floats:
        """What they make together with such weights (P,), written out, (S, r)."""
        p, weights = self.through.shape[2], weights.astype(self.dtype)
        through = self.through @ weights[:p]
        return np.einsum("src,sc->sr", self._slopes, through) + self.plain @ weights[p:]


def _products(columns: Floats, values: Floats) -> Floats:
    """Products (q,) of columns (S, n, q) and values (S, n)."""
    return columns.reshape(values.size, columns.shape[2]).T @ values.reshape(-1)


def gram(W: Floats) -> Floats:
    """W' W of columns, in double precision."""
    return (W.T @ W).astype(np.float64)
