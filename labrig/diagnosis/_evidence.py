"""The evidence: how probable the observations are when some spaces act at some size, and all others hardly."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs, solve_triangular

from labrig.arrays import Floats, Ints
from labrig.diagnosis._constants import NEGLIGIBLE
from labrig.diagnosis._design import DECLARED, Design
from labrig.diagnosis._freed import Taken
from labrig.diagnosis._ripple import RIPPLE

_PANEL = 256
"""How many rows of a matrix are mirrored at once: numerical, it changes no number."""
_MANY = 1 / 3
"""Rows taken off a matrix, as a share of its own, from which on it is factored anew, which is quicker; numerical."""
TOGETHER = 400_000
"""Numbers of small matrices that are factored, or solved, together; numerical."""
_JITTER = 1e-12
"""Added to a unit diagonal against rounding; numerical, it decides nothing."""
_POTRF, _POTRI = get_lapack_funcs(("potrf", "potri"), dtype=np.float64)
EVEN = (DECLARED, RIPPLE.key, "?place")
"""Free patterns that spread evenly over the observables, wherever the base moves them."""


@dataclass(frozen=True)
class Sums:
    """Normal equations of a design: sums over its observations, after which their number plays no role."""

    A: Floats
    b: Floats
    GG: Floats
    GY: Floats
    GW: Floats
    square: float
    worth: float
    r: int

    @classmethod
    def of(cls, design: Design, worth: float = 1.0, keep: NDArray[np.bool_] | None = None) -> "Sums":
        """The sums over all observations, or over those with `keep` (S,); each counts for `worth` of one.

        The likelihood to a power (Grünwald and van Ommen, Bayesian Analysis 12 (2017) 1069): what models are
        wrong in is not independent from number to number. The prior keeps its whole weight.
        """
        Y, W, V = design.observations.values, design.W, design.V
        G = np.concatenate([f.G for f in design.free], axis=1) if design.free else np.zeros((len(Y), 0))
        if keep is not None:
            Y, G, W = Y[keep], G[keep], W.some(keep)
        YV = (Y @ V).astype(W.dtype)
        return cls(
            A=worth * W.gram(),
            b=worth * W.times(YV),
            GG=worth * (G.T @ G),
            GY=worth * (G.T @ YV),
            GW=worth * W.beside(G),
            square=worth * float((YV.astype(np.float64) ** 2).sum()),
            worth=worth,
            r=V.shape[1],
        )

    def some(self, columns: Ints) -> "Sums":
        """The sums of some of the design's columns (N,)."""
        A, GW = self.A[np.ix_(columns, columns)], self.GW[..., columns]
        return replace(self, A=A, b=self.b[columns], GW=GW)


@dataclass(frozen=True)
class Beside:
    """The normal equations once free patterns are marginalised: A (P, P), b (P,), square, log determinant.

    `grain` (P,) is what the diagonal of A may be off by, as the columns are rounded.
    """

    A: Floats
    b: Floats
    square: float
    logdet: float
    grain: Floats

    def less(self, taken: Taken) -> "Beside":
        """What is left where free patterns are larger, which take so much."""
        said = taken.rows.T @ taken.rows  # taken off in double precision, without a copy in it
        return replace(
            self,
            A=self.A - said,
            b=self.b - taken.rows.T.astype(np.float64) @ taken.values,
            square=self.square - taken.square,
            logdet=self.logdet + taken.logdet,
        )


def beside_free(sums: Sums, variance: Floats) -> Beside:
    """Marginalise free patterns with prior variances `variance` (g, r): those that spread evenly first, then the rest.

    The variances of the others must be multiples of one spread. So each set is diagonal in one basis for all directions
    (Woodbury); what the data say next to nothing about is left out of A and b, and counts in the rest.
    """
    most = variance.max(axis=1, initial=0.0)
    even = (most > 0) & (np.ptp(variance, axis=1) <= 1e-9 * most)
    other = (most > 0) & ~even
    out = Beside(sums.A, sums.b, sums.square, 0.0, 10 * np.finfo(sums.GW.dtype).eps * np.diag(sums.A))
    if even.any():
        out, sums = _without_even(out, sums, variance[even, 0], even, other)
    elif other.any():
        sums = _of(sums, other)
    return _marginalised(out, sums, variance[other]) if other.any() else out


def _of(sums: Sums, own: NDArray[np.bool_]) -> Sums:
    """The sums with some of the free regressors only."""
    if own.all():
        return sums
    return replace(sums, GG=sums.GG[np.ix_(own, own)], GY=sums.GY[own], GW=sums.GW[own])


def _without_even(
    out: Beside, sums: Sums, variance: Floats, even: NDArray[np.bool_], other: NDArray[np.bool_]
) -> tuple[Beside, Sums]:
    """The even regressors marginalised, and what the sums of the others are beside them."""
    own, rest, d = _of(sums, even), _of(sums, other), np.sqrt(variance)
    cross = sums.GG[np.ix_(other, even)]
    to = cross * d @ np.linalg.solve(np.eye(len(d)) + d[:, None] * own.GG * d, np.diag(d))
    rest = replace(
        rest,
        GG=rest.GG - to @ cross.T,
        GY=rest.GY - to @ own.GY,
        GW=rest.GW - np.tensordot(to.astype(own.GW.dtype), own.GW, axes=1),
    )
    return _marginalised(out, own, np.repeat(variance[:, None], sums.r, axis=1)), rest


def _marginalised(out: Beside, sums: Sums, variance: Floats) -> Beside:
    """What is left beside free patterns whose variances (g, r) are multiples of one spread."""
    d = np.sqrt(variance.mean(axis=1))
    spread = variance[np.argmax(d)] / d.max() ** 2
    power, U = np.linalg.eigh(d[:, None] * sums.GG * d)
    power = np.maximum(power, 0.0)
    T = U.T * d
    TY = T @ sums.GY
    gain = spread / (1 + power[:, None] * spread)
    keep = power[:, None] * spread > NEGLIGIBLE
    half = np.empty((int(keep.sum()), 1 + len(out.b)), dtype=sums.GW.dtype)
    start = 0
    for j, own in enumerate(keep.T):
        to = T[own] * np.sqrt(gain[own, j])[:, None]
        rows = slice(start, start + len(to))
        half[rows, 0], half[rows, 1:] = to @ sums.GY[:, j], to.astype(half.dtype) @ sums.GW[:, j]
        start += len(to)
    said = half.T @ half  # taken off in double precision, without a copy in it
    return replace(
        out,
        A=out.A - said[1:, 1:],
        b=out.b - said[1:, 0],
        square=out.square - float((gain * TY**2).sum()),
        logdet=out.logdet + float(np.log1p(power[:, None] * spread).sum()),
    )


@dataclass(frozen=True)
class State:
    """The posterior when every column has a prior sd `sd` (P,), from which some are raised at little cost.

    `covariance` (P, P) and `mean` (P,) of the columns' coefficients; `quad` is y' C^-1 y, `logdet` log det C, of
    the observations' covariance C.
    """

    sd: Floats
    covariance: Floats
    mean: Floats
    quad: float
    logdet: float

    @classmethod
    def of(cls, sums: Beside, sd: Floats) -> "State":
        """The posterior beside free patterns: covariance (P, P), mean (P,), y' C^-1 y and log det C."""
        precision = sums.A.copy()
        precision[np.diag_indices_from(precision)] += sd**-2.0 + sums.grain
        # the transpose is as LAPACK lays it out: nothing is copied
        L, wrong = _POTRF(precision.T, lower=1, overwrite_a=1)
        if wrong:
            raise np.linalg.LinAlgError("the precision is not positive definite")
        logdet = 2 * float(np.log(np.diag(L)).sum()) + 2 * float(np.log(sd).sum())
        cov = _mirrored(_POTRI(L, lower=1, overwrite_c=1)[0])
        mean = cov @ sums.b
        return cls(sd, cov, mean, sums.square - float(sums.b @ mean), sums.logdet + logdet)

    def beside(self, taken: Taken, sums: Beside) -> "State":
        """The posterior where free patterns are larger. `sums` are those of this posterior, `taken` what the larger
        patterns take off them; where these are few rows, no other matrix is factored.
        """
        if len(taken.rows) > _MANY * len(self.sd):
            return State.of(sums.less(taken), self.sd)
        H = taken.rows.astype(np.float64)
        rows = H @ self.covariance
        L = np.linalg.cholesky((1 + _JITTER) * np.eye(len(H)) - rows @ H.T)
        half = solve_triangular(L, rows, lower=True, check_finite=False)
        z = solve_triangular(L, H @ self.mean - taken.values, lower=True, check_finite=False)
        unheard = taken.square - float(taken.values @ taken.values)
        return State(
            self.sd,
            self.covariance + half.T @ half,
            self.mean + z @ half,
            self.quad - float(z @ z) - unheard,
            self.logdet + taken.logdet + 2 * float(np.log(np.diag(L)).sum()),
        )

    def raised(self, slices: Sequence[slice], sds: Sequence[float]) -> "RaisedState":
        """The posterior where the columns of some blocks have larger prior sds; of blocks with the same columns the
        squares of these add up.
        """
        square: dict[tuple[int, int], float] = {}
        for at, sd in zip(slices, sds, strict=True):
            square[at.start, at.stop] = square.get((at.start, at.stop), 0.0) + sd**2
        sd = self.sd.copy()
        for (start, stop), value in square.items():
            sd[start:stop] = np.sqrt(value)
        index = np.concatenate([np.zeros(0, dtype=np.int64), *(np.arange(*at) for at in square)])
        wanted, was = sd[index], self.sd[index]
        delta = np.sqrt(np.maximum(was**-2.0 - wanted**-2.0, 0.0))
        rows = delta[:, None] * self.covariance[index]
        L = np.linalg.cholesky((1 + _JITTER) * np.eye(len(index)) - rows[:, index] * delta)
        half = solve_triangular(L, rows, lower=True, check_finite=False)
        z = solve_triangular(L, delta * self.mean[index], lower=True, check_finite=False)
        more = 2 * float(np.log(np.diag(L)).sum() + np.log(wanted / was).sum())
        return RaisedState(self, sd, half, self.mean + z @ half, self.quad - float(z @ z), self.logdet + more)


def _mirrored(lower: Floats) -> Floats:
    """A symmetric matrix of which only the lower half was worked out, in its place."""
    for start in range(0, len(lower), _PANEL):
        stop = start + _PANEL
        corner = lower[start:stop, start:stop]
        corner[:] = np.tril(corner) + np.tril(corner, -1).T
        lower[start:stop, stop:] = lower[stop:, start:stop].T
    return lower.T  # rows lie together


@dataclass(frozen=True)
class RaisedState:
    """A state with some blocks raised, to prior sds `sd` (P,): what they add to its covariance (half' half) and mean,
    y' C^-1 y, log det C.
    """

    state: State
    sd: Floats
    half: Floats
    mean: Floats
    quad: float
    logdet: float

    @property
    def whole(self) -> State:
        """A state from which others are raised, at the cost of the covariance of all columns."""
        covariance = self.state.covariance + self.half.T @ self.half
        return State(self.sd, covariance, self.mean, self.quad, self.logdet)

    def covariance(self, at: slice | Ints) -> Floats:
        """The posterior covariance (q, q) of some columns, those of a block."""
        half = self.half[:, at]
        return self.state.covariance[at][:, at] + half.T @ half

    def further(self, ats: Sequence[slice], sds: Floats) -> tuple[Floats, Floats]:
        """The quadratic form and log det (B, n) when one more of some blocks is raised to each of some prior sds (n,).

        Both are read off one Cholesky factor of the block, bordered by its mean and the quadratic form as it stands:
        of all blocks of one width at a time.
        """
        quads, logdets = np.empty((2, len(ats), len(sds)))
        widths = np.array([at.stop - at.start for at in ats])
        for q in np.unique(widths).tolist():
            most = max(int(TOGETHER / (len(sds) * (q + 1) ** 2)), 1)
            alike = np.flatnonzero(widths == q)
            for some in np.split(alike, range(most, len(alike), most)):
                columns = np.array([ats[i].start for i in some])[:, None] + np.arange(q)
                quads[some], logdets[some] = self._further(columns, sds)
        return quads, logdets

    def _further(self, columns: Ints, sds: Floats) -> tuple[Floats, Floats]:
        """`further` for blocks of one width, whose columns are (B, q)."""
        was, q = self.sd[columns[:, 0]], columns.shape[1]
        again = was > self.state.sd[columns[:, 0]]  # raised already, by another owner of the same space
        sd = np.where(again[:, None], np.hypot(sds, was[:, None]), sds)
        delta = np.sqrt(np.maximum(was[:, None] ** -2.0 - sd**-2.0, 0.0))
        half = self.half[:, columns].transpose(1, 0, 2)
        covariance = (
            self.state.covariance[columns[:, :, None], columns[:, None]] + half.transpose(0, 2, 1) @ half
        )
        M = np.zeros((*delta.shape, q + 1, q + 1))
        M[:, :, :q, :q] = -(delta**2)[:, :, None, None] * covariance[:, None]
        M[:, :, range(q), range(q)] += 1 + _JITTER
        M[:, :, q, :q] = delta[:, :, None] * self.mean[columns][:, None]
        M[:, :, q, q] = self.quad
        pivots = np.asarray(np.diagonal(np.linalg.cholesky(M), axis1=2, axis2=3), dtype=float)
        more = 2 * np.log(pivots[:, :, :q]).sum(axis=2) + 2 * q * np.log(sd / was[:, None])
        return pivots[:, :, q] ** 2, self.logdet + more

    def further_along(self, at: slice, sds: Floats, way: Floats) -> tuple[Floats, Floats]:
        """How far such a block then acts along a `way` (q,) of its columns, and the sd of that, (n,) each."""
        mean, covariance, was = self.mean[at], self.covariance(at), self.sd[at.start]
        delta = np.maximum(was**-2.0 - sds**-2.0, 0.0)
        M = (1 + _JITTER) * np.eye(len(mean)) - delta[:, None, None] * covariance
        both = np.linalg.solve(M, np.stack([mean, covariance @ way], axis=1)[None])
        acts = np.einsum("q,nqk->kn", way, both)
        return acts[0], np.sqrt(np.maximum(acts[1], 0.0))


def free_fit(sums: Sums, variance: Floats, columns: Floats) -> Floats:
    """Posterior means (g, r) of the free patterns' coefficients, beside the columns' coefficients (P,)."""
    out = np.zeros_like(variance)
    left = sums.GY - sums.GW @ columns.astype(sums.GW.dtype)
    for j in range(sums.r):
        h = np.sqrt(variance[:, j])
        out[:, j] = h * np.linalg.solve(np.eye(len(h)) + h[:, None] * sums.GG * h, h * left[:, j])
    return out


def unexplained(sums: Beside, sd: Floats) -> float:
    """The penalised square that is left when the columns act with these prior sds (P,), in units of the noise."""
    M = np.eye(len(sd)) + sd[:, None] * (sums.A + np.diag(sums.grain)) * sd
    z = solve_triangular(np.linalg.cholesky(M), sd * sums.b, lower=True)
    return sums.square - float(z @ z)


def free_variances(design: Design, sd: Mapping[str, float]) -> Floats:
    """Prior variance (g, r) of the free blocks' regressors along each direction, by the owner's size in floors."""
    even = np.ones_like(design.spread)
    parts = [
        np.full(f.G.shape[1], sd[f.owner] ** 2)[:, None] * (even if f.owner in EVEN else design.spread)
        for f in design.free
    ]
    return np.concatenate(parts) if parts else np.zeros((0, len(even)))
