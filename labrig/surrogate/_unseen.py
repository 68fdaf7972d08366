"""How far the field may be from what is expected of it, at any pressures and places: a Gaussian process' own variance.

For J frames and Q places that were all seen, with K0 = P x B + noise and directions of prior deviation s (Rasmussen,
Williams, Gaussian Processes for Machine Learning, 2006, eq. 2.26 and 2.42):

    var = P(a, a) B(p, p) - k K0^-1 k + r H^-1 r,   r = g - G K0^-1 k,   H = diag(1 / s^2) + G K0^-1 G
"""

import numpy as np

from labrig.arrays import Floats
from labrig.surrogate._field_settings import Grid, Settings, Spatial, places_of
from labrig.surrogate._forward import ForwardModel

_NUGGET = 1e-10


def unseen(grid: Grid, pressure: Floats, own: Floats, across: Floats, directions: Floats) -> Floats:
    """Variances (F, N), mm^2, of N coordinates in F frames after what `grid` says was seen, J frames by D coordinates.

    `pressure` (J, F) is P between the frames, `across` (D, N) B between the coordinates, in units of the precision of
    those that were seen; `own` (N,) B of each; `directions` (K, F, N) mm per unit.
    """
    alike = (grid.Q.T @ pressure) ** 2
    known = alike.T @ (1.0 / grid.total) @ (grid.spatial.V.T @ across) ** 2
    rest = directions - np.einsum("jf,kjn->kfn", pressure, grid.GK @ across)
    by_directions = (rest * np.tensordot(np.linalg.inv(grid.H), rest, axes=1)).sum(axis=0)
    return np.maximum(grid.variance * own - known + by_directions, 0.0)


def apart(spatial: Spatial, own: Floats, across: Floats) -> Floats:
    """What exact knowledge of some coordinates (D,) would leave of the variances `own` (N,) of B of others, (N,).

    `across` (D, N) is B between them, in units of the precision of those that are known.
    """
    known = (spatial.V.T @ across) ** 2 / (spatial.E + _NUGGET * spatial.E[-1])[:, None]
    return np.maximum(own - known.sum(axis=0), 0.0)


def by_gain(forward: ForwardModel, gain: Floats, pressure_kpa: Floats, uv: Floats) -> Floats:
    """How places (Q, 2) move, (C, J, Q, 3), mm, for each unit by which a chamber's pressure (J, C) counts for more."""
    above = pressure_kpa - forward.low_kpa
    moved = forward.jacobian(forward.low_kpa + gain * above, uv) * above[:, None, None, :]
    return np.moveaxis(moved, -1, 0)


class Unseen:
    """The variance of a field that was seen at places (Q, 2), of a `precision` (Q,), at fractions x (J, C).

    `simulated` is the forward model as it was simulated, `gain` (C,) how much of the pressures counts, known beforehand
    to `gain_sd` (C,); `rough` the variance, mm^2, per unit of what the places leave open of B. `along` (Q, 3): unit
    vectors, where each place was seen along one of them only; None: whole.
    """

    def __init__(
        self,
        simulated: ForwardModel,
        settings: Settings,
        x: Floats,
        uv: Floats,
        precision: Floats,
        gain: Floats,
        gain_sd: Floats,
        rough: float,
        along: Floats | None = None,
    ) -> None:
        self._rough, self._along = rough, along
        self._simulated, self._settings, self._gain, self._x = simulated, settings, gain, x
        self._places = places_of(simulated, uv, precision)
        self._root = np.repeat(np.sqrt(precision), 3)
        pressure = simulated.low_kpa + x * (simulated.high_kpa - simulated.low_kpa)
        directions = by_gain(simulated, gain, pressure, uv)
        covariance = self._places.covariance(settings)
        self._between = Spatial(covariance, self._root)
        if along is None:
            seen = directions.reshape(len(gain), len(x), -1) * self._root
            self._grid = Grid(x, self._between, seen, gain_sd, settings)
            return
        root = np.sqrt(precision)
        both = self._sighted(self._sighted(covariance).T)
        seen = np.einsum("cjqa,qa->cjq", directions, along) * root
        self._grid = Grid(x, Spatial(both, root), seen, gain_sd, settings)

    def _sighted(self, coordinates: Floats) -> Floats:
        """What was seen (D, N) of coordinates (3 Q, N): all, or that along the places' vectors."""
        if self._along is None:
            return coordinates
        return np.einsum("qa,qan->qn", self._along, coordinates.reshape(*self._along.shape, -1))

    def variance(self, pressure_kpa: Floats, uv: Floats) -> Floats:
        """Variance (F, P), mm^2, of the distance at pressures (F, C) and places (P, 2)."""
        across, own = self._places.towards(places_of(self._simulated, uv), self._settings)
        pressure = self._settings.pressure(self._x, self._simulated.fraction(pressure_kpa))
        directions = by_gain(self._simulated, self._gain, pressure_kpa, uv)
        flat = directions.reshape(len(directions), len(pressure_kpa), own.size)
        root = self._root if self._along is None else self._root[::3]
        seen = self._sighted(across) * root[:, None]
        found = unseen(self._grid, pressure, own, seen, flat)
        found += self._rough * apart(self._between, own, across * self._root[:, None])
        return found.reshape(len(pressure_kpa), own.size // 3, 3).sum(axis=2)
