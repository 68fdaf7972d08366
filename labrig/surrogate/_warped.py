"""The model that was learned on the rig: the forward model's surface, moved by a warp that depends on the pressures."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from labrig.arrays import Floats
from labrig.surface import Warp, design
from labrig.surrogate._field_settings import Settings
from labrig.surrogate._forward import ForwardModel
from labrig.surrogate._unseen import Unseen
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
class Doubt:
    """What tells how well a field is known, beside where it was seen.

    The values of its `settings`; the relative `precision` (N,) of what was seen at each center; `gain_sd` (C,), how far
    pressures were expected to count otherwise than simulated; `rough`, see `Unseen`. `along` (N, 3): the surface's
    normal at each center, where scans alone showed how far it moved along that; None where markers showed it whole.
    """

    settings: Floats
    precision: Floats
    gain_sd: Floats
    rough: float
    along: Floats | None = None


@dataclass(frozen=True)
class WarpedModel:
    """p* = R Phi_a(B(u, v, N_fk(a))) + t: the forward model's surface after a warp, in the rig's frame.

    Centers of the bells are the forward model's points at `marker_uv` (N, 2), which move with the shape; `c` is their
    width, mm^-2; `rotation` (3, 3) and `translation_mm` (3,) take the simulator's frame to the rig's. Deviations:
    `noise_mm` everywhere, the field's by its `doubt`, and the forward model's own, all times `factor`. In files from
    before there was a `doubt`, the field's are `field_mm` (n_u, n_v), on a regular grid of the surface, per unit of the
    head's doubt. `confidence` (n_u, n_v), 0 to 1, says where scans stand behind the model; ones without scans.
    """

    forward: ForwardModel
    marker_uv: Floats
    c: float
    head: WarpHead
    noise_mm: float = 0.0
    field_mm: Floats = field(default_factory=lambda: np.zeros((1, 1)))
    factor: float = 1.0
    confidence: Floats = field(default_factory=lambda: np.ones((1, 1)))
    rotation: Floats = field(default_factory=lambda: np.eye(3))
    translation_mm: Floats = field(default_factory=lambda: np.zeros(3))
    provenance: dict[str, Any] = field(default_factory=dict)
    doubt: Doubt | None = None

    def __repr__(self) -> str:
        noise_mm = self.noise_mm if self.doubt is None else Settings(self.doubt.settings)["noise_mm"]
        across = self.doubt is not None and self.doubt.along is not None
        seen = " across the surface" if across else ""
        return f"WarpedModel: {self.forward!r}, moved by {len(self.marker_uv)} bells; noise{seen} {noise_mm:.2g} mm"

    @property
    def chamber_names(self) -> tuple[str, ...]:
        """The chambers, in order."""
        return self.forward.chamber_names

    @property
    def low_kpa(self) -> Floats:
        """The lowest pressures, (C,)."""
        return self.forward.low_kpa

    @property
    def high_kpa(self) -> Floats:
        """The highest pressures, (C,)."""
        return self.forward.high_kpa

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
        result = np.empty_like(simulated)
        for f, one in enumerate(pressure):
            result[f] = self.warp(one).apply(simulated[f])
        return result

    def jacobian(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """d points / d pressure (F, P, 3, C), mm/kPa."""
        pressure = np.atleast_2d(np.asarray(pressure_kpa, dtype=float))
        simulated, moved = self.forward.points(pressure, uv), self.forward.jacobian(pressure, uv)
        result = np.empty_like(moved)
        span = self._span
        for f, one in enumerate(pressure):
            state = self._state(one)
            coefficients, change = self._coefficients(state)
            warp = Warp(state.centers_mm, coefficients, self.c)
            p = simulated[f]
            by_x = warp.by_centers(p, state.centers_change)
            by_x += np.tensordot(design(p, state.centers_mm, self.c), change, axes=1)
            result[f] = warp.jacobian(p) @ moved[f] + by_x / span
        return result

    def sd_mm(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """Standard deviation (F, P), mm, a distance: about 95 % of the real surface lies within 1.96 of it.

        From scans alone, how points move along the surface was not seen: it counts as large as it is expected to be.
        """
        pressure = np.atleast_2d(np.asarray(pressure_kpa, dtype=float))
        if self.doubt is not None:
            learned = self._unseen.variance(pressure, np.asarray(uv, dtype=float).reshape(-1, 2))
        else:
            doubt = self.head.doubt(self.forward.fraction(pressure))
            learned = (doubt[:, None] * on_grid(self.field_mm, uv)[None]) ** 2
        return self.factor * np.sqrt(self.noise_mm**2 + learned + self.forward.sd_mm(pressure, uv) ** 2)

    @cached_property
    def _unseen(self) -> Unseen:
        assert self.doubt is not None
        corrected: Any = self.forward.head
        return Unseen(
            replace(self.forward, head=corrected.base),
            Settings(self.doubt.settings),
            corrected.points,
            self.marker_uv,
            self.doubt.precision,
            corrected.gain,
            self.doubt.gain_sd,
            self.doubt.rough,
            self.doubt.along,
        )

    def confidence_at(self, uv: ArrayLike) -> Floats:
        """How far scans stand behind the model at (u, v) (P, 2): (P,), 0 to 1."""
        return on_grid(self.confidence, uv)

    def warp(self, pressure_kpa: ArrayLike) -> Warp:
        """The warp at one set of pressures (C,), kPa, the change of frame included."""
        state = self._state(np.asarray(pressure_kpa, dtype=float))
        return Warp(state.centers_mm, self._coefficients(state)[0], self.c)

    def warp_state(self, pressure_kpa: ArrayLike) -> tuple[Floats, Floats]:
        """The warp's coefficients (N + 4, 3) at pressures (C,), and their derivative (N + 4, 3, C) by kPa."""
        coefficients, change = self._coefficients(self._state(np.asarray(pressure_kpa, dtype=float)))
        return coefficients, change / self._span

    def _coefficients(self, state: State) -> tuple[Floats, Floats]:
        """The head's coefficients and their change by fractions, turned into the rig's frame."""
        coefficients, change = self.head.coefficients(state)
        turned = coefficients @ self.rotation.T
        turned[0] += self.translation_mm
        return turned, np.einsum("ij,njc->nic", self.rotation, change)

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
