"""What a record says of the rig at rest, though it never rests in it: the base's map, and how the record began."""

from dataclasses import dataclass, replace

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.effects import Context

_BLOCKS = 12
_ROWS = 6000
_RIDGES = tuple(10.0**n for n in range(-5, 2))
_STEP = 2.0
"""From one lag to the next."""
_APART = 4.0
"""From one decay of what was before a record to the next."""
_PART = 10
"""The longest lag, a part of the record: what is slower has hardly come to its end in it."""
_ROUNDS = 5
_FAR = 3.0


def begun(context: Context, X: Floats) -> Context:
    """The context of a record as it began; unchanged where that is known, or where set-points are held.

    Where nobody said what came before its first sample, a record began with vented chambers, or at rest at that sample:
    lags beside the regressors `X` (F, D) of the base say which.
    """
    if not context.sample_s or context.rows.between_sessions != "unknown":
        return context
    ways = [
        replace(context, rows=replace(context.rows, between_sessions=way), _memo={})
        for way in ("vented", "rest")
    ]
    return min(ways, key=lambda way: _Lagged.of(way, X).error)


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
    return _Lagged.of(begun(context, X), X).map


@dataclass(frozen=True)
class _Lagged:
    """Regressors (n, P), of which the first `own` are the base's and the others lags, and the values (n, K)."""

    X: Floats
    own: int
    Y: Floats
    block: Ints

    @classmethod
    def of(cls, context: Context, X: Floats) -> "_Lagged":
        rows, dt = context.rows, context.sample_s
        many = max(1, int(np.log(max(len(X) / _PART, _STEP)) / np.log(_STEP)))
        lags = [(context.relaxed(dt * _STEP**n) - rows.actuation) / context.span for n in range(many)]
        keep = np.unique(np.linspace(0, len(X) - 1, _ROWS).astype(int))
        behind = np.concatenate(lags, axis=1)[keep]
        both = np.concatenate([X[keep], behind / np.maximum(behind.std(axis=0), 1e-300)], axis=1)
        Y = rows.values[keep]
        return cls(both, X.shape[1], Y, np.arange(len(Y)) * _BLOCKS // len(Y))

    @property
    def error(self) -> float:
        """What is left of stretches that are left out in turn: mean squares as shares of the variance, summed.

        Everything counts: what is far off may be how the record began.
        """
        return sum(self._fit(y, robust=False).error for y in self.Y.T)

    @property
    def map(self) -> Floats:
        """Coefficients (D, K) of the base's regressors."""
        return np.stack([self._fit(y, robust=True).coefficients[: self.own] for y in self.Y.T], axis=1)

    def _fit(self, y: Floats, robust: bool) -> "_Fit":
        """One observable (n,), NaN where it was not seen."""
        seen = np.isfinite(y)
        X, y, block = self.X[seen], y[seen], self.block[seen]
        if not len(y) or y.var() <= 0:
            return _Fit(0.0, self._solved(X.T @ X, X.T @ y, _RIDGES[0] * len(y)))
        weight = self._weights(X, y) if robust else np.ones(len(y))
        WX = X * weight[:, None]
        parts = [block == b for b in range(_BLOCKS)]
        sums = [(WX[own].T @ X[own], WX[own].T @ y[own]) for own in parts]
        A, b = np.sum([A for A, _ in sums], axis=0), np.sum([b for _, b in sums], axis=0)

        def left(ridge: float) -> float:
            out = np.empty(len(y))
            for own, (less, minus) in zip(parts, sums, strict=True):
                out[own] = y[own] - X[own] @ self._solved(A - less, b - minus, ridge * (~own).sum())
            return float(weight @ out**2) / len(y) / float(y.var())

        error, ridge = min((left(ridge), ridge) for ridge in _RIDGES)
        return _Fit(error, self._solved(A, b, ridge * len(y)))

    def _weights(self, X: Floats, y: Floats) -> Floats:
        """Huber's weights (n,) of what a fit with a middling ridge leaves."""
        weight = np.ones(len(y))
        for _ in range(_ROUNDS):
            WX = X * weight[:, None]
            beta = self._solved(WX.T @ X, WX.T @ y, _RIDGES[len(_RIDGES) // 2] * len(y))
            off = np.abs(y - X @ beta)
            scale = 1.4826 * float(np.median(off))
            if scale <= 0:
                break
            weight = np.minimum(1.0, _FAR * scale / np.maximum(off, 1e-300))
        return weight

    def _solved(self, A: Floats, b: Floats, ridge: float) -> Floats:
        """Coefficients of which those of lags are held by a ridge."""
        held = np.diag(np.where(np.arange(len(A)) < self.own, 0.0, ridge))
        return np.asarray(np.linalg.lstsq(A + held, b, rcond=1e-12)[0], dtype=np.float64)


@dataclass(frozen=True)
class _Fit:
    """One observable: what is left of it where stretches are left out, and the coefficients (P,)."""

    error: float
    coefficients: Floats
