"""What is known of the field between simulation and reality after it was seen at some places of some frames.

Each place of a frame may have been seen whole, along a direction only, or not at all. The equations are those of
a Gaussian process, solved by conjugate gradients: products with the covariance are cheap, for it is one of frames
times one of places, and the solution for frames that were seen whole is the preconditioner.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.surrogate._field_settings import Grid, Settings, Spatial

_ITERATIONS = 300
_TOLERANCE = 1e-5


@dataclass(frozen=True)
class Seen:
    """Displacements of Q places in J frames.

    `x` (J, C) fractions; `value_mm` (J, Q, 3); `known` (J, Q, 3, 3) projectors onto what was seen of each: all, a
    direction, or nothing. `directions` (D, J, Q, 3) mm per unit; `direction_sd` (D,) what is expected of theta.
    """

    x: Floats
    value_mm: Floats
    known: Floats
    directions: Floats
    direction_sd: Floats

    @property
    def share(self) -> Floats:
        """The share of the frames that saw each place, whole or in part, (Q,)."""
        return np.asarray((np.trace(self.known, axis1=2, axis2=3) > 0.5).mean(axis=0), np.float64)

    @property
    def used(self) -> NDArray[np.bool_]:
        """Which places were seen in which frames, whole or in part, (J, Q)."""
        return np.asarray(np.trace(self.known, axis1=2, axis2=3) > 0.5)

    def part(self, frames: NDArray[np.int64], places: NDArray[np.int64]) -> "Seen":
        """Some of the frames and places."""
        chosen = np.ix_(frames, places)
        return replace(
            self,
            x=self.x[frames],
            value_mm=self.value_mm[chosen],
            known=self.known[chosen],
            directions=self.directions[:, frames][:, :, places],
        )


@dataclass(frozen=True)
class Posterior:
    """What is known of the field.

    `weights` (J, Q, 3): the displacement at any place is its prior covariance times them; `theta` (D,) the sizes of the
    directions; `expected` (J, Q, 3) displacements after all, at the places themselves. `grid` is the process as if all
    had been seen.
    """

    settings: Settings
    weights: Floats
    theta: Floats
    expected: Floats
    grid: Grid


def infer(
    seen: Seen, covariance: Floats, precision: Floats, settings: Settings, start: Floats | None = None
) -> Posterior:
    """What is known of the field, given B (3 Q, 3 Q) and the places' precision (Q,).

    `start` (J, Q, 3): weights that were found for nearly the same.
    """
    J, Q = seen.value_mm.shape[:2]
    root = np.repeat(np.sqrt(precision), 3)
    directions = seen.directions.reshape(len(seen.directions), J, 3 * Q) * root
    grid = Grid(seen.x, Spatial(covariance, root), directions, seen.direction_sd, settings)
    B, variance = grid.spatial.B, seen.direction_sd**2

    def only_seen(values: Floats) -> Floats:
        return np.einsum("jqab,jqb->jqa", seen.known, values.reshape(J, Q, 3)).reshape(J, -1)

    def spread(weights: Floats) -> Floats:
        """The prior covariance times weights, all places."""
        theta = variance * np.tensordot(directions, weights, axes=([1, 2], [0, 1]))
        return grid.P @ weights @ B + np.tensordot(theta, directions, axes=1)

    def product(weights: Floats) -> Floats:
        return only_seen(spread(weights)) + grid.noise * weights

    wanted = only_seen(np.nan_to_num(seen.value_mm)) * root
    first = np.zeros(wanted.shape) if start is None else only_seen(start) / root
    weights = _conjugate_gradients(product, lambda v: only_seen(grid.solve(v)), wanted, first)
    theta = variance * np.tensordot(directions, weights, axes=([1, 2], [0, 1]))
    expected = (spread(weights) / root).reshape(J, Q, 3)
    return Posterior(settings, (weights * root).reshape(J, Q, 3), theta, expected, grid)


def _conjugate_gradients(product, precondition, wanted: Floats, x: Floats) -> Floats:
    """Solve product(x) = wanted; both maps are symmetric and positive."""
    residual = wanted - product(x)
    z = precondition(residual)
    step, inner = z, float((residual * z).sum())
    enough = _TOLERANCE**2 * max(float((wanted * precondition(wanted)).sum()), 1e-300)
    for _ in range(_ITERATIONS):
        if inner <= enough:
            break
        moved = product(step)
        length = inner / float((step * moved).sum())
        x = x + length * step
        residual = residual - length * moved
        z = precondition(residual)
        inner, before = float((residual * z).sum()), inner
        step = z + inner / before * step
    return x


def coordinates(places: NDArray[np.int64]) -> NDArray[np.int64]:
    """The places of their three coordinates in flat arrays."""
    return (3 * places[:, None] + np.arange(3)).ravel()
