"""What a record says of the rig at rest, though it never rests in it: the base's map, and how the record began."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats, Ints
from labrig.effects import Context

_ALL = slice(None)
_BLOCKS = 12
"""Stretches of a record that are left out in turn."""
_ROWS = 6000
"""A longer record is thinned to so many, after its lags were computed."""
_RIDGES = tuple(10.0**n for n in range(-5, 2))
"""From hardly any, against the variance of a lag, to more than all of it."""
_STEP = 2.0
"""From one lag to the next."""
_APART = 4.0
"""From one decay of what was before a record to the next."""
_PART = 10
"""The longest lag, a part of the record: what is slower has hardly come to its end in it."""
_ROUNDS = 10
_FAR = 3.0
"""Standard deviations beyond which a value counts as one so far off (Huber): three in a thousand of white noise."""


def begun(context: Context, X: Floats) -> Context:
    """The context of a record as it began; unchanged where that is known, or where set-points are held.

    Where nobody said what came before its first sample, a record began with vented chambers, or at rest at that sample:
    lags beside the regressors `X` (F, D) of the base say which, by what they explain of the residual.
    """
    if not context.sample_s or context.rows.between_sessions != "unknown":
        return context
    ways = [
        replace(context, rows=replace(context.rows, between_sessions=way), _memo={})
        for way in ("vented", "rest")
    ]
    return min(ways, key=lambda way: _Lagged.of(way, X, way.residual).error)


def transients(context: Context) -> Floats:
    """How each session of a record may come to rest from where it began, (F, D): decays of one sample and longer."""
    rows, out = context.rows, []
    longest = context.sample_s * len(rows.capture) / _PART
    taus = context.sample_s * _APART ** np.arange(
        1 + int(np.log(max(longest / context.sample_s, 1.0)) / np.log(_APART))
    )
    for session in range(len(rows.sessions)):
        own = rows.session == session
        since_s = np.where(own, context.session_time_s, np.inf)
        out += [np.exp(-since_s / tau) for tau in taus]
    return np.stack(out, axis=1)


def at_rest(context: Context, X: Floats) -> Floats:
    """Coefficients (D, K) of a map's regressors `X` (F, D), fitted beside lags of each chamber.

    What lags behind its input is seen at no set-point long enough: a map that is fitted alone is flatter than the rig
    is at rest, and may even fall where that rises. Beside first-order lags of one to a tenth of the record's samples,
    each less the input, the map is what is left when all lags have ended (the gain at frequency zero; L. Ljung, System
    Identification, 2nd ed. 1999, ch. 3). Lags are held by a ridge, which stretches left out in turn choose. What is far
    off counts less (Huber).
    """
    return _Lagged.of(begun(context, X), X, context.rows.values).map


@dataclass(frozen=True)
class _Lagged:
    """Regressors (n, P), of which the first `own` are the base's and the others lags, and the values (n, K)."""

    X: Floats
    own: int
    Y: Floats
    block: Ints

    @classmethod
    def of(cls, context: Context, X: Floats, Y: Floats) -> "_Lagged":
        rows, dt = context.rows, context.sample_s
        keep = np.unique(np.linspace(0, len(X) - 1, _ROWS).astype(int))
        many = max(1, int(np.log(max(len(X) / _PART, _STEP)) / np.log(_STEP)))
        u, vented = rows.event_actuation, context.vented
        lags = [(context.lagged(dt * _STEP**n, u, vented) - rows.actuation)[keep] for n in range(many)]
        behind = np.concatenate(lags, axis=1)
        both = np.concatenate([X[keep], behind / np.maximum(behind.std(axis=0), 1e-300)], axis=1)
        return cls(both, X.shape[1], Y[keep], np.arange(len(keep)) * _BLOCKS // len(keep))

    @property
    def error(self) -> float:
        """What is left of stretches that are left out in turn: mean squares as shares of the variance, summed.

        Everything counts: what is far off may be how the record began.
        """
        return float(self._left(self._believed(np.inf)).min(axis=0).sum())

    @property
    def map(self) -> Floats:
        """Coefficients (D, K) of the base's regressors."""
        Y = self._believed(_FAR)
        best = self._left(Y).argmin(axis=0)
        fits = [self._solved(*self._sums(Y), len(Y) * ridge) for ridge in _RIDGES]
        return np.stack([fits[way][: self.own, k] for k, way in enumerate(best)], axis=1)

    def _believed(self, far: float) -> Floats:
        """The values (n, K), nearer where they are further off than so many times the usual (Huber's pseudo-values);
        what was not seen is what lags say.
        """
        seen = np.isfinite(self.Y)
        mean = np.where(seen, self.Y, 0.0).sum(axis=0) / np.maximum(seen.sum(axis=0), 1)
        Y, ridge = np.where(seen, self.Y, mean), len(self.Y) * _RIDGES[len(_RIDGES) // 2]
        for _ in range(_ROUNDS):
            fitted = self.X @ self._solved(*self._sums(Y), ridge)
            off = np.where(seen, self.Y - fitted, 0.0)
            each = zip(off.T, seen.T, strict=True)
            scale = 1.4826 * np.array([np.median(np.abs(o[s])) if s.any() else 0.0 for o, s in each])
            limit = far * np.where(scale > 0, scale, np.inf)
            Y = fitted + np.clip(off, -limit, limit)
        return Y

    def _left(self, Y: Floats) -> Floats:
        """What is left of each observable with each ridge (ridges, K)."""
        A, b = self._sums(Y)
        out = np.zeros((len(_RIDGES), Y.shape[1]))
        for number in range(_BLOCKS):
            own = self.block == number
            less, minus = self._sums(Y, own)
            for way, ridge in enumerate(_RIDGES):
                fit = self._solved(A - less, b - minus, (~own).sum() * ridge)
                out[way] += ((Y[own] - self.X[own] @ fit) ** 2).sum(axis=0)
        return out / np.maximum(len(Y) * Y.var(axis=0), 1e-300)

    def _sums(self, Y: Floats, own: NDArray[np.bool_] | slice = _ALL) -> tuple[Floats, Floats]:
        return self.X[own].T @ self.X[own], self.X[own].T @ Y[own]

    def _solved(self, A: Floats, b: Floats, ridge: float) -> Floats:
        """Coefficients (P, K) of which those of lags are held by a ridge."""
        held = np.diag(np.where(np.arange(len(A)) < self.own, 0.0, ridge))
        return np.asarray(np.linalg.lstsq(A + held, b, rcond=1e-12)[0], dtype=np.float64)
