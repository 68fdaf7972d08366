"""The columns of a design, kept as small as what they are made of: those that act through pressures as pressures."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from labrig.arrays import Floats, Ints

_AT_ONCE = 128
"""How many columns are carried to the directions at once: it bounds the memory, and changes no number."""
_NOTHING = 1e-18
"""Floors that are none; numerical."""


def flushed(values: Floats) -> Floats:
    """Set what is next to nothing to zero, in place; returns the values.

    What fades leaves numbers whose products no longer are normal ones of single precision, and a processor takes a
    hundred times as long for each of these.
    """
    values[np.abs(values) < _NOTHING] = 0.0
    return values


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

    def some(self, rows: Any, columns: Ints | None = None) -> "Columns":
        """The columns over some observations, by number or by mask (S,): all of them, or some `columns` by number."""
        through, plain, p = self.through[rows], self.plain[rows], self.through.shape[2]
        if columns is not None and len(columns) < self.width:
            through, plain = through[:, :, columns[columns < p]], plain[:, :, columns[columns >= p] - p]
        return replace(self, through=through, capture=self.capture[rows], plain=plain)

    def turned(self, to: Floats) -> "Columns":
        """The columns along other directions, which are combinations (r, s) of these."""
        return replace(
            self,
            moves=to.T @ self.moves,
            plain=to.T @ self.plain,
        )

    @cached_property
    def _slopes(self) -> Floats:
        return self.moves[self.capture]

    def gram(self) -> Floats:
        """The Gram matrix (P, P), in double precision.

        What acts through pressures lies within the C directions of its capture's slopes: with these as Q R, products
        are those of R times the pressures, among each other and with the part Q' of the others.
        """
        r, C = self.moves.shape[1:]
        Q, R = np.linalg.qr(self.moves) if r > C else (None, self.moves)
        out = np.zeros((self.width, self.width))
        for rows, used in self._halves():
            part = self.some(rows, used)
            p, (S, _, d) = part.through.shape[2], part.plain.shape
            own = np.empty((p + d, p + d))
            own[p:, p:] = gram(part.plain.reshape(S * r, d))
            if p:
                seen = part.plain if Q is None else Q.transpose(0, 2, 1)[part.capture] @ part.plain
                acting = (R[part.capture] @ part.through).reshape(-1, p)
                own[:p, :p], own[:p, p:] = gram(acting), acting.T @ seen.reshape(len(acting), d)
                own[p:, :p] = own[:p, p:].T
            _add(out, own, used, used)
        return out

    def _halves(self) -> Iterator[tuple[slice, Ints]]:
        """The rows of captures' means, then those of contrasts, each with the columns that are not zero there."""
        n = len(self.moves)
        for rows in (slice(n), slice(n, None)):
            if len(self.capture[rows]):
                used = [values[rows].any(axis=(0, 1)) for values in (self.through, self.plain)]
                yield rows, np.flatnonzero(np.concatenate(used))

    def times(self, values: Floats) -> Floats:
        """Products (P,) of the columns with values (S, r)."""
        values = values.astype(self.dtype)
        through = np.einsum("src,sr->sc", self._slopes, values)
        parts = [_products(self.through, through), _products(self.plain, values)]
        return np.concatenate(parts).astype(np.float64)

    def beside(self, G: Floats) -> Floats:
        """Products (g, r, P) of the columns with regressors (S, g), along each direction by itself."""
        r = self.plain.shape[1]
        out = np.zeros((G.shape[1], r, self.width), dtype=self.dtype)
        for rows, used in self._halves():
            acting = np.flatnonzero(G[rows].any(axis=0))
            to = np.ascontiguousarray(G[rows][:, acting].T.astype(self.dtype))
            part = self.some(rows, used)
            p, own = part.through.shape[2], np.empty((len(to), r, len(used)), dtype=self.dtype)
            for start in range(0, p, _AT_ONCE):
                some = part._slopes @ part.through[:, :, start : start + _AT_ONCE]
                own[:, :, start : start + some.shape[2]] = _carried(to, some)
            own[:, :, p:] = _carried(to, part.plain)
            _add(out, own, acting, np.arange(r), used)
        return out

    def made(self, weights: Floats) -> Floats:
        """The sum of the columns times weights (P,), written out, (S, r)."""
        p, weights = self.through.shape[2], weights.astype(self.dtype)
        through = self.through @ weights[:p]
        return np.einsum("src,sc->sr", self._slopes, through) + self.plain @ weights[p:]


def _products(columns: Floats, values: Floats) -> Floats:
    """Products (q,) of columns (S, n, q) and values (S, n)."""
    return columns.reshape(values.size, columns.shape[2]).T @ values.reshape(-1)


def _add(to: Floats, values: Floats, *at: Ints) -> None:
    """Add values where `at` says along each axis, in place."""
    if to.shape == values.shape:
        to += values
    else:
        to[np.ix_(*at)] += values


def _carried(to: Floats, columns: Floats) -> Floats:
    """Products (g, r, q) of regressors (g, S) with columns (S, r, q)."""
    S, r, q = columns.shape
    return (to @ columns.reshape(S, r * q)).reshape(len(to), r, q)


def gram(W: Floats) -> Floats:
    """W' W of columns, in double precision."""
    return (W.T @ W).astype(np.float64)
