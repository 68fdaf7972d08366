"""What is expected of the field between simulation and reality before it was seen: covariances, and their fit.

    displacement(a, p) = sum_d theta_d g_d(a, p) + f(a, p),   cov f = P(a, a') B(p, p')

P: one part the same at all pressures, one that varies with them. B: how the simulated shape itself varies (the real one
differs from it where and how it moves), smooth bells as in the source paper, and an affine part. g_d: known directions,
above all more or less pressure in a chamber. Frames by places is a product covariance, so that the marginal
likelihood costs two small eigenvalue problems; what was not seen is filled in by what is expected of it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from labrig.arrays import Floats
from labrig.surface import bells
from labrig.surrogate._forward import ForwardModel
from labrig.surrogate._kernel import Kernel

_NAMES = ("still", "moving", "noise_mm", "length", "share", "shape_power", "bells", "affine", "c")
_START = np.log([1.0, 1.5, 0.2, 0.6, 0.4, 0.8, 0.2, 0.1, 6e-5])
_SD = np.array([1.5, 1.0, 1.5, 0.7, 1.0, 0.4, 1.5, 1.5, 0.8])
_EDGE = 4.0
LEAST_EXTENT_MM = 10.0
"""Places nearer together than this, such as a single one, count as far apart as this."""
_DRAWS = 400
_FILLINGS, _ROUNDS = 20, 3


@dataclass(frozen=True)
class Settings:
    """What is expected before anything was seen, as natural logarithms.

    `still`, `moving`: deviations, mm, of the two parts of P; `noise_mm`; `length`, `share` of the pressure kernel;
    `shape_power`: how much larger modes of the simulated shape differ more; `bells`, `affine`: these parts of B
    relative to that of the shape; `c`: width of the bells, mm^-2.
    """

    values: Floats

    @classmethod
    def usual(cls) -> "Settings":
        """What is assumed before the data say better."""
        return cls(_START.copy())

    def __getitem__(self, name: str) -> float:
        return float(np.exp(self.values[_NAMES.index(name)]))

    @property
    def variance(self) -> float:
        """P at any pressures, mm^2: what is expected of a place where B is one."""
        return self["still"] ** 2 + self["moving"] ** 2

    def kernel(self, chambers: int) -> Kernel:
        """The part of P that varies; all chambers alike."""
        ones = np.ones(chambers)
        return Kernel(self["length"] * ones, ones, self["share"] * ones)

    def pressure(self, x: Floats, y: Floats) -> Floats:
        """P, mm^2, between fractions x (J, C) and y (F, C): (J, F)."""
        kernel = self.kernel(x.shape[1])
        return self["still"] ** 2 + self["moving"] ** 2 * kernel.covariance(kernel.bent(x), kernel.bent(y))

    def facts(self) -> dict[str, float]:
        """The values by name."""
        return {name: self[name] for name in _NAMES}


@dataclass(frozen=True)
class Places:
    """Q places on the surface, and how they move.

    `modes` (3 Q, K) by the latent coordinates, whose variances are `size` (K,); `middle_mm` (Q, 3) where they are on
    average; `precision` (Q,) of what is seen there, relative.
    """

    modes: Floats
    size: Floats
    middle_mm: Floats
    precision: Floats

    def latent_prior(self, power: float) -> Floats:
        """Prior variances (K,) of the latent coordinates' error, of mean square 1 mm per coordinate at the places."""
        size = np.maximum(self.size / self.size.max(), 1e-12) ** power
        return size / max(float((self.modes**2 @ size).mean()), 1e-12)

    def affine(self, middle_mm: Floats | None = None) -> Floats:
        """Constant and linear functions (Q, 4) of the places, or of others; linear ones of unit size at the edge."""
        centred = (self.middle_mm if middle_mm is None else middle_mm) - self.middle_mm.mean(axis=0)
        return np.concatenate([np.ones((len(centred), 1)), centred / self.extent_mm], axis=1)

    @property
    def extent_mm(self) -> float:
        """How far from their middle the places reach."""
        off = self.middle_mm - self.middle_mm.mean(axis=0)
        return max(float(np.linalg.norm(off, axis=1).max()), LEAST_EXTENT_MM)

    def covariance(self, settings: Settings) -> Floats:
        """B between all coordinates of all places, (3 Q, 3 Q)."""
        return self.towards(self, settings)[0]

    def towards(self, others: "Places", settings: Settings) -> tuple[Floats, Floats]:
        """B between the coordinates of the places and of R others, (3 Q, 3 R), and of each of the others, (3 R,)."""
        prior = self.latent_prior(settings["shape_power"])
        smooth = settings["bells"] ** 2 * bells(self.middle_mm, others.middle_mm, settings["c"])
        there = self.affine(others.middle_mm)
        smooth += settings["affine"] ** 2 * self.affine() @ there.T
        own = settings["bells"] ** 2 + settings["affine"] ** 2 * (there**2).sum(axis=1)
        across = (self.modes * prior) @ others.modes.T + np.kron(smooth, np.eye(3))
        return across, others.modes**2 @ prior + np.repeat(own, 3)


def places_of(forward: ForwardModel, uv: Floats, precision: Floats | None = None) -> Places:
    """The places of a simulated surface at (u, v) (Q, 2), of some `precision` (Q,), by default of one."""
    rng = np.random.default_rng(0)
    z = forward.head.latent(rng.random((_DRAWS, len(forward.chamber_names))))
    basis = forward.basis(uv)
    modes = np.stack([(basis @ m.reshape(-1, 3)).ravel() for m in forward.modes_mm], axis=1)
    mean = (basis @ forward.mean_mm.reshape(-1, 3)).ravel()
    middle = (mean + modes @ z.mean(axis=0)).reshape(-1, 3)
    return Places(modes, z.var(axis=0), middle, np.ones(len(uv)) if precision is None else precision)


class Grid:
    """The process on J frames x D coordinates, all seen alike: what is quick to solve.

    `covariance` (D, D) is B in units of each coordinate's precision; `directions` (K, J, D) likewise, of which
    `direction_sd` (K,) is expected.
    """

    def __init__(
        self, x: Floats, spatial: "Spatial", directions: Floats, direction_sd: Floats, settings: Settings
    ) -> None:
        self.spatial = spatial
        self.P, self.variance = settings.pressure(x, x), settings.variance
        values, self.Q = np.linalg.eigh(self.P)
        self.noise = settings["noise_mm"] ** 2
        self.total = np.outer(np.maximum(values, 0.0), spatial.E) + self.noise
        self.G = directions
        self.GK = np.stack([self.solve(g) for g in directions]) if len(directions) else directions
        precision = np.diag(1.0 / direction_sd**2)
        self.H = precision + np.tensordot(self.G, self.GK, axes=([1, 2], [1, 2]))

    def solve(self, values: Floats) -> Floats:
        """Inverse of (P x B + noise), without the directions, times values (J, D)."""
        V = self.spatial.V
        return self.Q @ ((self.Q.T @ values @ V) / self.total) @ V.T

    def theta(self, values: Floats) -> Floats:
        """The directions' most probable sizes, given displacements (J, D)."""
        return np.asarray(
            np.linalg.solve(self.H, np.tensordot(self.GK, values, axes=([1, 2], [0, 1]))), np.float64
        )

    def cost(self, values: Floats) -> float:
        """Minus the log of the marginal likelihood of displacements (J, D), without constants."""
        inner = self.Q.T @ values @ self.spatial.V
        cost = 0.5 * float((inner**2 / self.total).sum()) + 0.5 * float(np.log(self.total).sum())
        if len(self.G):
            pulled = np.tensordot(self.GK, values, axes=([1, 2], [0, 1]))
            cost -= 0.5 * float(pulled @ np.linalg.solve(self.H, pulled))
            cost += 0.5 * float(np.linalg.slogdet(self.H)[1])
        return cost

    def filled(self, values: Floats, first: Floats) -> Floats:
        """Displacements (J, D) with what is NaN as expected after all else; from a `first` guess on."""
        missing = ~np.isfinite(values)
        filled = np.where(missing, first, values)
        for _ in range(_FILLINGS if missing.any() else 0):
            left = filled - np.tensordot(self.theta(filled), self.G, axes=1)
            expected = self.P @ self.solve(left) @ self.spatial.B + filled - left
            filled = np.where(missing, expected, values)
        return filled


class Spatial:
    """B of some coordinates (D, D) in units of each one's precision `root` (D,), its eigenvalues and vectors."""

    def __init__(self, covariance: Floats, root: Floats) -> None:
        self.B = covariance * root[:, None] * root
        values, self.V = np.linalg.eigh(self.B)
        self.E = np.maximum(values, 0.0)


def fit_settings(
    x: Floats,
    values: Floats,
    directions: Floats,
    direction_sd: Floats,
    spatial: Callable[[Settings], Spatial],
    start: Settings | None = None,
    iterations: int = 15,
) -> Settings:
    """The settings of the greatest evidence times a broad prior around the usual ones.

    `values` (J, D) displacements in frames at fractions `x` (J, C), NaN where not seen, in units of precision, as
    `directions` (K, J, D); `spatial` makes B.
    """
    settings = start or Settings.usual()
    filled = np.zeros(values.shape)
    for _ in range(_ROUNDS):
        filled = Grid(x, spatial(settings), directions, direction_sd, settings).filled(values, filled)
        guess = filled

        def cost(free: Floats, guess: Floats = guess) -> float:
            tried = Settings(free)
            try:
                evidence = Grid(x, spatial(tried), directions, direction_sd, tried).cost(guess)
            except np.linalg.LinAlgError:
                return 1e12
            return evidence + 0.5 * float((((free - _START) / _SD) ** 2).sum())

        bounds = [(m - _EDGE * s, m + _EDGE * s) for m, s in zip(_START, _SD, strict=True)]
        options = {"maxiter": iterations, "eps": 1e-4}
        found = minimize(cost, settings.values, method="L-BFGS-B", bounds=bounds, options=options)
        settings = Settings(np.asarray(found.x, dtype=float))
    return settings
