"""The evidence: how probable the observations are when some spaces act at some size, and all others hardly."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_blas_funcs, get_lapack_funcs, solve_triangular

from labrig.arrays import Floats
from labrig.diagnosis._design import DECLARED, Design

_NEGLIGIBLE = 1e-4
_SYRK = get_blas_funcs(("syrk",), dtype=np.float32)[0]
_POTRI = get_lapack_funcs(("potri",), dtype=np.float64)[0]
EVEN = (DECLARED, "?place")
"""Free patterns that spread evenly over the observables, wherever the base moves them."""
DECLARED_FLOORS = 300.0
"""What a base calls its own may have any size; of a static map, far more floors than any rig moves."""


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
        S, r = len(Y), V.shape[1]
        G = np.concatenate([f.G for f in design.free], axis=1) if design.free else np.zeros((S, 0))
        W3 = W.reshape(S, r, -1)
        if keep is not None:
            Y, G, W3 = Y[keep], G[keep], W3[keep]
        flat = W3.reshape(-1, W.shape[1])
        YV = (Y @ V).astype(np.float32)
        return cls(
            A=worth * (flat.T @ flat).astype(np.float64),
            b=worth * (flat.T @ YV.reshape(-1)).astype(np.float64),
            GG=worth * (G.T @ G),
            GY=worth * (G.T @ YV),
            GW=worth
            * np.asarray(G.T.astype(np.float32) @ W3.reshape(len(Y), -1)).reshape(G.shape[1], r, W.shape[1]),
            square=worth * float((YV.astype(np.float64) ** 2).sum()),
            worth=worth,
            r=r,
        )


@dataclass(frozen=True)
class Beside:
    """The same sums once free patterns are marginalised: A (P, P), b (P,), square, log determinant."""

    A: Floats
    b: Floats
    square: float
    logdet: float


def beside_free(sums: Sums, variance: Floats) -> Beside:
    """Marginalise free patterns with prior variances `variance` (g, r) along each direction: Woodbury, one by one."""
    halves, square, logdet = [], sums.square, 0.0
    power = np.diag(sums.GG)
    for j in range(sums.r):
        use = variance[:, j] * power > _NEGLIGIBLE
        if not use.any():
            continue
        h = np.sqrt(variance[use, j])
        L = np.linalg.cholesky(np.eye(use.sum()) + h[:, None] * sums.GG[np.ix_(use, use)] * h)
        right = h[:, None] * np.column_stack([sums.GY[use, j], sums.GW[use, j, :]])
        z = solve_triangular(L, right, lower=True, check_finite=False)
        halves.append(z)
        square -= float(z[:, 0] @ z[:, 0])
        logdet += 2 * float(np.log(np.diag(L)).sum())
    if not halves:
        return Beside(sums.A, sums.b, square, logdet)
    half = np.concatenate(halves).astype(np.float32)
    upper = _SYRK(1.0, half, trans=1)
    gram = (np.triu(upper) + np.triu(upper, 1).T).astype(np.float64)
    return Beside(sums.A - gram[1:, 1:], sums.b - gram[1:, 0], square, logdet)


@dataclass(frozen=True)
class State:
    """The posterior when every column has a prior sd `sd` (P,), from which some are raised at little cost."""

    sums: Beside
    sd: Floats

    @cached_property
    def _inverse(self) -> tuple[Floats, Floats, float]:
        precision = self.sums.A + np.diag(self.sd**-2.0)
        L = np.linalg.cholesky(precision)
        half = _POTRI(L, lower=1)[0]
        cov = np.tril(half) + np.tril(half, -1).T
        logdet = 2 * float(np.log(np.diag(L)).sum()) + 2 * float(np.log(self.sd).sum())
        return cov, cov @ self.sums.b, logdet

    @property
    def covariance(self) -> Floats:
        return self._inverse[0]

    @property
    def mean(self) -> Floats:
        return self._inverse[1]

    def parts(self) -> tuple[float, float]:
        """The quadratic form y' C^-1 y and log det C, as things stand."""
        _, mean, logdet = self._inverse
        return self.sums.square - float(self.sums.b @ mean), self.sums.logdet + logdet

    def raised(self, slices: Sequence[slice], sds: Sequence[float]) -> tuple[float, float]:
        """The same two when the columns of some blocks have larger prior sds."""
        index = np.concatenate([np.arange(s.start, s.stop) for s in slices])
        wanted = np.concatenate([np.full(s.stop - s.start, sd) for s, sd in zip(slices, sds, strict=True)])
        cov, mean, _ = self._inverse
        quad, logdet = self.parts()
        delta = np.sqrt(np.maximum(self.sd[index] ** -2.0 - wanted**-2.0, 0.0))
        M = np.eye(len(index)) - delta[:, None] * cov[np.ix_(index, index)] * delta
        L = np.linalg.cholesky(M + 1e-12 * np.eye(len(M)))
        z = solve_triangular(L, delta * mean[index], lower=True)
        more = 2 * float(np.log(np.diag(L)).sum()) + 2 * float(np.log(wanted / self.sd[index]).sum())
        return quad - float(z @ z), logdet + more

    def fitted(self, slices: Sequence[slice], sds: Sequence[float]) -> "State":
        """The state itself with those blocks raised, for posterior means."""
        sd = self.sd.copy()
        for s, value in zip(slices, sds, strict=True):
            sd[s] = value
        return State(self.sums, sd)


def free_fit(sums: Sums, variance: Floats, columns: Floats) -> Floats:
    """Posterior means (g, r) of the free patterns' coefficients, beside the columns' coefficients (P,)."""
    out = np.zeros_like(variance)
    left = sums.GY - sums.GW @ columns.astype(sums.GW.dtype)
    for j in range(sums.r):
        h = np.sqrt(variance[:, j])
        out[:, j] = h * np.linalg.solve(np.eye(len(h)) + h[:, None] * sums.GG * h, h * left[:, j])
    return out


def unexplained(sums: Beside, slices: Sequence[slice], sds: Sequence[float]) -> float:
    """The penalised square that is left when only these blocks act, in units of the noise."""
    if not slices:
        return sums.square
    index = np.concatenate([np.arange(s.start, s.stop) for s in slices])
    sd = np.concatenate([np.full(s.stop - s.start, v) for s, v in zip(slices, sds, strict=True)])
    M = np.eye(len(index)) + sd[:, None] * sums.A[np.ix_(index, index)] * sd
    z = solve_triangular(np.linalg.cholesky(M), sd * sums.b[index], lower=True)
    return sums.square - float(z @ z)


def free_variances(design: Design, sd: Mapping[str, float]) -> Floats:
    """Prior variance (g, r) of the free blocks' regressors along each direction, by the owner's size in floors."""
    even = np.ones_like(design.spread)
    parts = [
        np.full(f.G.shape[1], sd[f.owner] ** 2)[:, None] * (even if f.owner in EVEN else design.spread)
        for f in design.free
    ]
    return np.concatenate(parts) if parts else np.zeros((0, len(even)))
