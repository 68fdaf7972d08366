"""A space warp: an affine map plus Gaussian bells around centers, and the one through given points."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from labrig._errors import LabrigError
from labrig.arrays import Floats

SLACK = 1e-10
"""Added to the diagonal of the bells' matrix: wide bells at near centers are all but dependent."""


@dataclass(frozen=True)
class Warp:
    """Phi(p) = alpha + A p + sum_i beta_i exp(-c |p - q_i|^2).

    `centers_mm` q (N, 3); `coefficients` (N + 4, 3): alpha, the three rows of A transposed, the beta_i; `c_per_mm2`.
    A point is a row: Phi(p) = [1, p, bells(p)] @ coefficients.
    """

    centers_mm: Floats
    coefficients: Floats
    c_per_mm2: float

    def __post_init__(self) -> None:
        if self.coefficients.shape != (len(self.centers_mm) + 4, 3):
            raise LabrigError(
                f"warp: {len(self.centers_mm)} centers need coefficients ({len(self.centers_mm) + 4}, 3), "
                f"not {self.coefficients.shape}"
            )

    @classmethod
    def identity(cls, centers_mm: ArrayLike, c_per_mm2: float) -> "Warp":
        """The warp that moves nothing."""
        centers = np.asarray(centers_mm, dtype=float).reshape(-1, 3)
        return cls(centers, identity_coefficients(len(centers)), float(c_per_mm2))

    @classmethod
    def through(
        cls, centers_mm: ArrayLike, targets_mm: ArrayLike, c_per_mm2: float, slack: float = SLACK
    ) -> "Warp":
        """The warp that takes every center (N, 3) to its target (N, 3), or near to it with more `slack`.

        The linear system of interpolation by radial functions: the beta_i sum to zero, and so do their moments
        about the centers, so that what is affine is left to A.
        """
        centers = np.asarray(centers_mm, dtype=float).reshape(-1, 3)
        targets = np.asarray(targets_mm, dtype=float).reshape(-1, 3)
        if len(centers) < 4 or targets.shape != centers.shape or not np.isfinite(targets).all():
            raise LabrigError("warp: four or more centers, each with a finite target, are needed")
        rows = np.concatenate([targets - centers, np.zeros((4, 3))])
        solved = np.linalg.solve(interpolation_matrix(centers, c_per_mm2, slack), rows)
        return cls(centers, solved + identity_coefficients(len(centers)), float(c_per_mm2))

    def apply(self, points_mm: ArrayLike) -> Floats:
        """Where points (P, 3) go, (P, 3)."""
        return design(points_mm, self.centers_mm, self.c_per_mm2) @ self.coefficients

    def jacobian(self, points_mm: ArrayLike) -> Floats:
        """d Phi / d p at points (P, 3): (P, 3, 3), rows the components of Phi."""
        points = np.asarray(points_mm, dtype=float).reshape(-1, 3)
        weight = bells(points, self.centers_mm, self.c_per_mm2)
        beta = self.coefficients[4:]
        towards = (beta[:, :, None] * self.centers_mm[:, None, :]).reshape(-1, 9)
        pull = (weight @ beta)[:, :, None] * points[:, None, :] - (weight @ towards).reshape(-1, 3, 3)
        return self.coefficients[1:4].T - 2.0 * self.c_per_mm2 * pull

    def by_centers(self, points_mm: ArrayLike, centers_change: Floats) -> Floats:
        """The change of Phi at points (P, 3) when the centers move by `centers_change` (N, 3, C): (P, 3, C)."""
        points = np.asarray(points_mm, dtype=float).reshape(-1, 3)
        weight = bells(points, self.centers_mm, self.c_per_mm2)
        beta, C = self.coefficients[4:], centers_change.shape[-1]
        along = np.einsum("id,idk->ik", self.centers_mm, centers_change)
        fixed = (beta[:, :, None] * along[:, None, :]).reshape(len(beta), -1)
        turned = (beta[:, None, :, None] * centers_change[:, :, None, :]).reshape(len(beta), -1)
        by_point = (weight @ turned).reshape(-1, 3, 3, C)
        moved = np.einsum("pd,pdck->pck", points, by_point) - (weight @ fixed).reshape(-1, 3, C)
        return 2.0 * self.c_per_mm2 * moved


def identity_coefficients(count: int) -> Floats:
    """Coefficients (count + 4, 3) of the warp that moves nothing."""
    coefficients = np.zeros((count + 4, 3))
    coefficients[1:4] = np.eye(3)
    return coefficients


def bells(points_mm: ArrayLike, centers_mm: ArrayLike, c_per_mm2: float) -> Floats:
    """exp(-c |p - q|^2) for points (P, 3) and centers (N, 3): (P, N)."""
    p, q = np.asarray(points_mm, dtype=float), np.asarray(centers_mm, dtype=float)
    middle = q.mean(axis=0) if len(q) else np.zeros(3)
    p, q = p - middle, q - middle  # squares of small numbers lose less
    square = (p * p).sum(axis=1)[:, None] - 2.0 * p @ q.T + (q * q).sum(axis=1)[None, :]
    return np.exp(-c_per_mm2 * np.maximum(square, 0.0))


def design(points_mm: ArrayLike, centers_mm: ArrayLike, c_per_mm2: float) -> Floats:
    """[1, p, bells(p)] for points (P, 3): (P, N + 4)."""
    points = np.asarray(points_mm, dtype=float).reshape(-1, 3)
    return np.concatenate([np.ones((len(points), 1)), points, bells(points, centers_mm, c_per_mm2)], axis=1)


def interpolation_matrix(centers_mm: Floats, c_per_mm2: float, slack: float = SLACK) -> Floats:
    """The symmetric system (N + 4, N + 4) behind `Warp.through`; unknowns in the order of the coefficients."""
    N = len(centers_mm)
    matrix = np.zeros((N + 4, N + 4))
    matrix[:N] = design(centers_mm, centers_mm, c_per_mm2)
    matrix[:N, 4:] += slack * np.eye(N)
    matrix[N:, 4:] = matrix[:N, :4].T
    return matrix
