"""When the rig changed at one moment, for good or for a while: a fibre that breaks, something that lies on the body.

Beyond it the same pressures do something else. The moments are where two regressions have most of the likelihood
(R. E. Quandt, J. American Statistical Association 53 (1958) 873-880).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.effects import Context, Space, acting, errors_by_capture, pattern, pressure

_FEWEST = 8
"""Fewest captures that a change lasts, and that are left without it."""
_MOMENTS = 64
"""How many moments are looked at first, and then those about the best: numerical."""
_SMALL = 1e-6


@dataclass(frozen=True)
class Stretch:
    """Captures `first` to `end` (without it; None: for good) in which the rig was another, `among` of how many."""

    first: int
    end: int | None
    among: int

    def holds(self, captures: Ints) -> Floats:
        """Which captures lie in it, of 0 and 1."""
        return ((captures >= self.first) & (self.end is None or captures < self.end)).astype(float)

    def __str__(self) -> str:
        if self.end is None:
            return f"a sudden change before capture {self.first}"
        return f"a sudden change from capture {self.first} to {self.end - 1}"


def sudden(context: Context) -> Iterator[Space]:
    """What each chamber does otherwise in the stretch that the residuals speak for most: zero, gain and bend."""
    if not context.moves:
        return
    found = stretch(context)
    if found is None:
        return
    held, x = found.holds(context.rows.capture)[:, None], context.rows.fraction
    features = [
        pressure("zero then", held * np.ones_like(x), 0.5),
        pressure("gain then", held * x),
        pressure("bend then", held * x * x, 0.5),
    ]
    yield Space(str(found), "sudden", acting(features), 0.5, scanned=found.among, absolute=False)
    yield Space(str(found), "sudden place", (pattern("place then", held[:, 0]),), scanned=found.among)


def stretch(context: Context) -> Stretch | None:
    """The stretch of captures that is likeliest to be another: of those that end and of those that do not the one that
    is clearer for so many tried; None of too few captures.
    """
    captures, error = errors_by_capture(context)
    n = len(captures)
    if n < 2 * _FEWEST:
        return None
    lines = _Lines.of(context, captures, error)
    best = []
    for for_good in (True, False):
        coarse = np.unique(np.linspace(0, n, min(n, _MOMENTS) + 1).astype(int))
        a, b, gain = lines.best(coarse, np.array([n]) if for_good else coarse)
        step = int(np.diff(coarse).max())
        if step > 1:
            near = [np.arange(max(i - step, 0), min(i + step, n) + 1) for i in (a, b)]
            a, b, gain = lines.best(near[0], np.array([n]) if for_good else near[1])
        among = n if for_good else n * (n - 1) // 2
        best.append((gain - np.log(among), a, b, among))
    _, a, b, among = max(best)
    return Stretch(int(captures[a]), int(captures[b]) if b < n else None, among)


@dataclass(frozen=True)
class _Lines:
    """Sums, up to each capture, of straight lines of each chamber's change by its own pressure."""

    G: Floats
    """(n + 1, C, 2, 2)"""
    b: Floats
    """(n + 1, C, 2)"""
    square: Floats
    """(C,)"""

    @classmethod
    def of(cls, context: Context, captures: Ints, error: Floats) -> "_Lines":
        """The captures' errors (n, K) as changes of the chambers' pressures, least squares."""
        index = np.searchsorted(captures, context.rows.capture)
        first = np.unique(index, return_index=True)[1]
        x, J = context.rows.fraction[first], context.jacobian[first] * context.span
        normal = np.einsum("nkc,nkd->ncd", J, J)
        normal += _SMALL * np.trace(normal.mean(axis=0)) * np.eye(normal.shape[1])
        change = np.linalg.solve(normal, np.einsum("nkc,nk->nc", J, error)[:, :, None])[:, :, 0]
        phi = np.stack([np.ones_like(x), x], axis=2)
        G, b = phi[..., :, None] * phi[..., None, :], phi * change[..., None]
        G, b = (np.concatenate([0 * v[:1], np.cumsum(v, axis=0)]) for v in (G, b))
        return cls(G + 0.0, b, (change**2).sum(axis=0))

    def best(self, begins: Ints, ends: Ints) -> tuple[int, int, float]:
        """The begin and the end where two lines of each chamber are likeliest beside one, and by how much, nats."""
        a, b = (v.ravel() for v in np.meshgrid(begins, ends, indexing="ij"))
        long = (b - a >= _FEWEST) & (len(self.G) - 1 - (b - a) >= _FEWEST) & (a > 0)
        if not long.any():
            return 0, len(self.G) - 1, -np.inf
        a, b = a[long], b[long]
        G, y = self.G[b] - self.G[a], self.b[b] - self.b[a]
        both = _explained(G, y) + _explained(self.G[-1] - G, self.b[-1] - y)
        least = _SMALL * self.square + 1e-300
        one = np.maximum(self.square - _explained(self.G[-1:], self.b[-1:]), least)
        two = np.maximum(self.square - both, least)
        gain = 0.5 * (len(self.G) - 1) * np.log(one / two).sum(axis=1)
        at = int(np.argmax(gain))
        return int(a[at]), int(b[at]), float(gain[at])


def _explained(G: Floats, b: Floats) -> Floats:
    """What a line explains of the sum of squares, (m, C)."""
    return np.einsum("mci,mci->mc", b, np.linalg.solve(G + 1e-9 * np.eye(2), b[..., None])[..., 0])
