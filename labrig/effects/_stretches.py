"""When something was another for a stretch of captures: from one moment on, for good or for a while.

The moments are where two regressions have most of the likelihood (R. E. Quandt, J. American Statistical Association 53
(1958) 873-880).
"""

from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats, Ints

_FEWEST = 8
"""Fewest captures that a change lasts, and that are left without it: of fewer than 80 in all a tenth, but three."""
_MOMENTS = 64
"""How many moments are looked at first, and then those about the best: numerical."""
_SMALL = 1e-6


@dataclass(frozen=True)
class Stretch:
    """Captures `first` to `end` (without it; None: for good), and among how many it was chosen."""

    first: int
    end: int | None
    among: int

    def holds(self, captures: Ints) -> Floats:
        """Which captures lie in it, of 0 and 1."""
        return ((captures >= self.first) & (self.end is None or captures < self.end)).astype(float)

    def __str__(self) -> str:
        return (
            f"before capture {self.first}"
            if self.end is None
            else f"from capture {self.first} to {self.end - 1}"
        )


def stretch_of(captures: Ints, y: Floats, phi: Floats, part: Ints | None = None) -> Stretch | None:
    """The stretch of captures (n,) in which y (n, D) goes another way with phi (n, D, q) than in the others, beside a
    way of its own of each `part` (n,).

    Of those that end and of those that do not the one that is clearer for so many tried; None of too few captures.
    """
    n = len(captures)
    fewest = min(_FEWEST, max(3, n // 10))
    if n < 2 * fewest + 2:
        return None
    ways = _Ways.of(y, phi, np.zeros(n, dtype=np.int64) if part is None else part, fewest)
    best = []
    for for_good in (True, False):
        coarse = np.unique(np.linspace(0, n, min(n, _MOMENTS) + 1).astype(int))
        a, b, gain = ways.best(coarse, np.array([n]) if for_good else coarse)
        step = int(np.diff(coarse).max())
        if step > 1 and np.isfinite(gain):
            near = [np.arange(max(i - step, 0), min(i + step, n) + 1) for i in (a, b)]
            a, b, gain = ways.best(near[0], np.array([n]) if for_good else near[1])
        among = n if for_good else n * (n - 1) // 2
        best.append((gain - np.log(among), a, b, among))
    gain, a, b, among = max(best)
    if not np.isfinite(gain):
        return None
    return Stretch(int(captures[a]), int(captures[b]) if b < n else None, among)


@dataclass(frozen=True)
class _Ways:
    """Sums, up to each capture, of what y does with phi in each of P parts."""

    G: Floats
    """(n + 1, P, D, q, q)"""
    b: Floats
    """(n + 1, P, D, q)"""
    square: Floats
    """(D,)"""
    fewest: int

    @classmethod
    def of(cls, y: Floats, phi: Floats, part: Ints, fewest: int) -> "_Ways":
        own = (part[:, None] == np.unique(part)).astype(float)[:, :, None, None]
        G = own[..., None] * (phi[..., :, None] * phi[..., None, :])[:, None]
        b = own * (phi * y[..., None])[:, None]
        G, b = (np.concatenate([0 * v[:1], np.cumsum(v, axis=0)]) for v in (G, b))
        return cls(G, b, (y**2).sum(axis=0), fewest)

    def best(self, begins: Ints, ends: Ints) -> tuple[int, int, float]:
        """The begin and the end where another way is likelier than none by most, and by how much, nats.

        What the parts explain is taken off the others first (R. Frisch, F. V. Waugh, Econometrica 1 (1933) 387-401).
        """
        a, b = (v.ravel() for v in np.meshgrid(begins, ends, indexing="ij"))
        n = len(self.G) - 1
        long = (b - a >= self.fewest) & (n - (b - a) >= self.fewest) & (a > 0)
        if not long.any():
            return 0, n, -np.inf
        a, b = a[long], b[long]
        all_G = self.G[-1] + _SMALL * np.eye(self.G.shape[-1])
        ways = np.linalg.solve(all_G, self.b[-1][..., None])[..., 0]  # of each part, (P, D, q)
        H, h = self.G[b] - self.G[a], self.b[b] - self.b[a]
        R = (H - H @ np.linalg.solve(all_G, H)).sum(axis=1)
        r = (h - np.einsum("mpdij,pdj->mpdi", H, ways)).sum(axis=1)
        least = _SMALL * self.square + 1e-300
        one = np.maximum(self.square - np.einsum("pdi,pdi->d", self.b[-1], ways), least)
        R = R + _SMALL * np.eye(R.shape[-1])
        gone = np.einsum("mdi,mdi->md", r, np.linalg.solve(R, r[..., None])[..., 0])
        gain = -0.5 * n * np.log(np.maximum(one - gone, least) / one).sum(axis=1)
        at = int(np.argmax(gain))
        return int(a[at]), int(b[at]), float(gain[at])
