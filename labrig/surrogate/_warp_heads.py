"""What gives the coefficients of the warp at a pressure: networks as in the source paper, and labrig's own field."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular

from labrig.arrays import Floats
from labrig.surface import SLACK, bells, identity_coefficients, interpolation_matrix
from labrig.surrogate._kernel import Kernel
from labrig.surrogate._network import Network

_NUGGET = 1e-6


@dataclass(frozen=True)
class State:
    """The simulated shape at one set of pressures, and how it changes with each chamber's fraction x (C,).

    `z` (K,) latent coordinates, `z_change` (K, C); `centers_mm` (N, 3), `centers_change` (N, 3, C); `c_per_mm2`.
    """

    x: Floats
    z: Floats
    z_change: Floats
    centers_mm: Floats
    centers_change: Floats
    c_per_mm2: float


@dataclass(frozen=True)
class FunctionHead:
    """N_rbf of the source paper: a network from the shape to what the coefficients are besides the identity's.

    `scale` (N + 4,) is the unit of each row of coefficients.
    """

    kind = "function"

    network: Network
    scale: Floats

    def coefficients(self, state: State) -> tuple[Floats, Floats]:
        """Coefficients (N + 4, 3) and their change (N + 4, 3, C)."""
        value, change = self.network.slopes(state.z[None], state.z_change[None])
        rows, C = len(self.scale), len(state.x)
        moved = value.reshape(rows, 3) * self.scale[:, None]
        return identity_coefficients(rows - 4) + moved, change.reshape(rows, 3, C) * self.scale[:, None, None]

    def doubt(self, x: Floats) -> Floats:
        """One (F,): a single network knows nothing of its doubt."""
        return np.ones(len(x))


@dataclass(frozen=True)
class MarkerHead:
    """N_mk of the source paper: a network from the virtual markers to the real ones, through which a warp is laid.

    `slack` is added to the diagonal of the bells' matrix in the linear system; hardly any is interpolation.
    """

    kind = "marker"

    network: Network
    slack: float = SLACK

    def coefficients(self, state: State) -> tuple[Floats, Floats]:
        """Coefficients (N + 4, 3) and their change (N + 4, 3, C): those of a linear system that moves too."""
        N, C = len(state.centers_mm), len(state.x)
        value, change = self.network.slopes(state.z[None], state.z_change[None])
        matrix = interpolation_matrix(state.centers_mm, state.c_per_mm2, self.slack)
        solved = np.linalg.solve(matrix, np.concatenate([value.reshape(N, 3), np.zeros((4, 3))]))
        q, dq = state.centers_mm, state.centers_change
        weight = bells(q, q, state.c_per_mm2)
        apart = np.einsum("ijd,ijdc->ijc", q[:, None] - q[None], dq[:, None] - dq[None])
        by_bells = -2.0 * state.c_per_mm2 * weight[:, :, None] * apart
        right = np.zeros((N + 4, 3, C))
        right[:N] = change.reshape(N, 3, C) - np.einsum("ijc,jd->idc", by_bells, solved[4:])
        right[:N] -= np.einsum("ikc,kd->idc", dq, solved[1:4])
        right[N + 1 :] -= np.einsum("jkc,jd->kdc", dq, solved[4:])
        solved_change = np.linalg.solve(matrix, right.reshape(N + 4, -1)).reshape(N + 4, 3, C)
        return identity_coefficients(N) + solved, np.asarray(solved_change, np.float64)

    def doubt(self, x: Floats) -> Floats:
        """One (F,): a single network knows nothing of its doubt."""
        return np.ones(len(x))


@dataclass(frozen=True)
class FieldHead:
    """labrig's own: coefficients are a Gaussian process of the pressures, `constant` + sum_j k(x, x_j) weights_j.

    `points` (J, C) are the fractions of the captures it learned from; `constant` (N + 4, 3); `weights` (J, N + 4, 3).
    """

    kind = "field"

    kernel: Kernel
    points: Floats
    constant: Floats
    weights: Floats

    def coefficients(self, state: State) -> tuple[Floats, Floats]:
        """Coefficients (N + 4, 3) and their change (N + 4, 3, C)."""
        t = self.kernel.bent(state.x[None])
        value, first, _ = self.kernel.parts(t, self._bent)
        by_x = (value * first)[:, 0] * self.kernel.slope(state.x)[:, None]
        moved = np.tensordot(value[0], self.weights, axes=1)
        return self.constant + moved, np.moveaxis(np.tensordot(by_x, self.weights, axes=1), 0, -1)

    def doubt(self, x: Floats) -> Floats:
        """How far (F,) fractions x are from the captures, 0 to 1."""
        cross = self.kernel.covariance(self._bent, self.kernel.bent(x))
        known = solve_triangular(self._factor, cross, lower=True, check_finite=False)
        return np.sqrt(np.maximum(1.0 - (known * known).sum(axis=0), _NUGGET))

    @cached_property
    def _bent(self) -> Floats:
        return self.kernel.bent(self.points)

    @cached_property
    def _factor(self) -> Floats:
        matrix = self.kernel.covariance(self._bent, self._bent)
        matrix[np.diag_indices(len(matrix))] += _NUGGET
        return np.asarray(np.linalg.cholesky(matrix), np.float64)
