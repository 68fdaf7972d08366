"""The model that was learned on the rig: the forward model's surface, moved by a warp that depends on the pressures."""

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from labrig.surface._warp import Warp, design
from labrig.surrogate._forward import ForwardModel
from labrig.surrogate._kernel import Floats
from labrig.surrogate._warp_heads import State


class WarpHead(Protocol):
    """What gives the coefficients of the warp at a pressure."""

    kind: str

    def coefficients(self, state: State) -> tuple[Floats, Floats]:
        """Coefficients (N + 4, 3) and their change by the fractions (N + 4, 3, C)."""
        ...

    def doubt(self, x: Floats) -> Floats:
        """How little is known at fractions x (F, C): (F,)."""
        ...


@dataclass(frozen=True)
class WarpedModel:
    """p* = Phi_a(B(u, v, N_fk(a))): the forward model's surface after a warp.

    `forward` may take pressures for more or less than its own range says (a chamber that is stiffer than simulated);
    `low_kpa`, `high_kpa` (C,) are the limits that hold. Centers of the bells are the forward model's points at
    `marker_uv` (N, 2), which move with the shape; `c` is their width, mm^-2. Deviations: `noise_mm` everywhere,
    `field_mm` (n_u, n_v) on a regular grid of the surface per unit of the head's doubt, and the forward model's
    own, all times `factor`. `confidence` (n_u, n_v), 0 to 1, says where scans stand behind the model; ones without.
    """

    forward: ForwardModel
    marker_uv: Floats
    c: float
    head: WarpHead
    low_kpa: Floats
    high_kpa: Floats
    noise_mm: float
    field_mm: Floats
    factor: float
    confidence: Floats
    provenance: dict[str, Any] = field(default_factory=dict)

    @property
    def chamber_names(self) -> tuple[str, ...]:
        """The chambers, in order."""
        return self.forward.chamber_names

    @property
    def marker_names(self) -> tuple[str, ...]:
        """The forward model's markers."""
        return self.forward.marker_names

    @property
    def spline(self) -> Any:
        """The spline of the forward model's surface."""
        return self.forward.spline

    def markers(self, names: tuple[str, ...]) -> Floats:
        """(u, v) (M, 2) of named markers."""
        return self.forward.markers(names)

    def points(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """Surface points (F, P, 3), mm, at pressures (F, C) and (u, v) (P, 2)."""
        pressure = np.atleast_2d(np.asarray(pressure_kpa, dtype=float))
        simulated = self.forward.points(pressure, uv)
        return np.stack([self._warp(one).apply(p) for one, p in zip(pressure, simulated, strict=True)])

    def jacobian(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """d points / d pressure (F, P, 3, C), mm/kPa."""
        pressure = np.atleast_2d(np.asarray(pressure_kpa, dtype=float))
        simulated, moved = self.forward.points(pressure, uv), self.forward.jacobian(pressure, uv)
        result = np.empty_like(moved)
        span = self._span
        for f, one in enumerate(pressure):
            state = self._state(one)
            coefficients, change = self.head.coefficients(state)
            warp = Warp(state.centers_mm, coefficients, self.c)
            p = simulated[f]
            by_x = warp.by_centers(p, state.centers_change)
            by_x += np.tensordot(design(p, state.centers_mm, self.c), change, axes=1)
            result[f] = warp.jacobian(p) @ moved[f] + by_x / span
        return result

    def sd_mm(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """Standard deviation (F, P), mm, a distance: about 95 % of the real surface lies within 1.96 of it."""
        pressure = np.atleast_2d(np.asarray(pressure_kpa, dtype=float))
        doubt = self.head.doubt(self.forward.fraction(pressure))
        learned = doubt[:, None] * on_grid(self.field_mm, uv)[None]
        simulated = self.forward.sd_mm(pressure, uv)
        return self.factor * np.sqrt(self.noise_mm**2 + learned**2 + simulated**2)

    def confidence_at(self, uv: ArrayLike) -> Floats:
        """How far scans stand behind the model at (u, v) (P, 2): (P,), 0 to 1."""
        return on_grid(self.confidence, uv)

    def warp(self, pressure_kpa: ArrayLike) -> Warp:
        """The warp at one set of pressures (C,), kPa."""
        return self._warp(np.asarray(pressure_kpa, dtype=float))

    def warp_state(self, pressure_kpa: ArrayLike) -> tuple[Floats, Floats]:
        """The warp's coefficients (N + 4, 3) at pressures (C,), and their derivative (N + 4, 3, C) by kPa."""
        state = self._state(np.asarray(pressure_kpa, dtype=float))
        coefficients, change = self.head.coefficients(state)
        return coefficients, change / self._span

    def _warp(self, pressure: Floats) -> Warp:
        state = self._state(pressure)
        return Warp(state.centers_mm, self.head.coefficients(state)[0], self.c)

    def _state(self, pressure: Floats) -> State:
        z, by_kpa = self.forward.latent(pressure)
        span = self._span
        return State(
            x=self.forward.fraction(pressure)[0],
            z=z,
            z_change=by_kpa * span,
            centers_mm=self.forward.points(pressure, self.marker_uv)[0],
            centers_change=self.forward.jacobian(pressure, self.marker_uv)[0] * span,
            c_per_mm2=self.c,
        )

    @property
    def _span(self) -> Floats:
        return self.forward.high_kpa - self.forward.low_kpa


def on_grid(values: Floats, uv: ArrayLike) -> Floats:
    """Values on a regular grid of the unit square (n_u, n_v), interpolated at (u, v) (P, 2): (P,)."""
    places = np.asarray(uv, dtype=float).reshape(-1, 2)
    if values.size == 1:
        return np.full(len(places), float(values.ravel()[0]))
    last = np.array(values.shape) - 1
    x = np.clip(places, 0.0, 1.0) * last
    low = np.minimum(x.astype(int), np.maximum(last - 1, 0))
    high = np.minimum(low + 1, last)
    s = x - low
    along = values[low[:, 0], low[:, 1]] * (1 - s[:, 0]) + values[high[:, 0], low[:, 1]] * s[:, 0]
    beside = values[low[:, 0], high[:, 1]] * (1 - s[:, 0]) + values[high[:, 0], high[:, 1]] * s[:, 0]
    return along * (1 - s[:, 1]) + beside * s[:, 1]
