"""The forward model: chamber pressures in, the control points of the surface out, with derivatives and doubt."""

import hashlib
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.surface import Spline

LEAST_SD_MM = 1e-6
_KEPT = 8
"""Sets of surface points whose basis is kept: callers ask for the same few again and again."""


class Head(Protocol):
    """What turns fractions x (F, C) of the pressure range into latent coordinates z (F, K)."""

    kind: str

    def latent(self, x: Floats) -> Floats:
        """z (F, K)."""
        ...

    def slopes(self, x: Floats) -> Floats:
        """dz/dx (F, K, C)."""
        ...

    def doubt(self, x: Floats) -> Floats:
        """How little is known at x (F,), in a unit of its own."""
        ...


@dataclass(frozen=True)
class ForwardModel:
    """control = mean + sum_k z_k(pressure) modes_k, points = B-spline(u, v) of the control points.

    `mean_mm` (nu, nv, 3); `modes_mm` (K, nu, nv, 3); `spread` (K, R): covariance of the latent errors per unit of
    the head's doubt is spread @ spread.T; `factor` scales standard deviations so that 95 % of the surface lies
    within 1.96 of them. `marker_uv` (M, 2) places the markers by name. `provenance` says where it comes from.
    """

    chamber_names: tuple[str, ...]
    low_kpa: Floats
    high_kpa: Floats
    spline: Spline
    mean_mm: Floats
    modes_mm: Floats
    head: Head
    spread: Floats
    factor: float
    marker_names: tuple[str, ...] = ()
    marker_uv: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    provenance: dict[str, Any] = field(default_factory=dict)
    _kept: dict[bytes, csr_array] = field(default_factory=dict, repr=False, compare=False)

    def __repr__(self) -> str:
        ranges = zip(self.chamber_names, self.low_kpa, self.high_kpa, strict=True)
        chambers = ", ".join(f"{name} {low:g} to {high:g} kPa" for name, low, high in ranges)
        return f"ForwardModel: {chambers}; {len(self.modes_mm)} modes, {len(self.marker_names)} markers"

    def control(self, pressure_kpa: ArrayLike) -> Floats:
        """Control points (F, nu, nv, 3), mm, at pressures (F, C), kPa."""
        z = self.head.latent(self.fraction(pressure_kpa))
        flat = z @ self.modes_mm.reshape(len(self.modes_mm), -1) + self.mean_mm.ravel()
        return flat.reshape(len(z), *self.mean_mm.shape)

    def points(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """Surface points (F, P, 3), mm, at pressures (F, C) and (u, v) (P, 2)."""
        return self._decode(self.control(pressure_kpa), uv)

    def jacobian(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """d points / d pressure (F, P, 3, C), mm/kPa."""
        x = self.fraction(pressure_kpa)
        by_x = np.einsum("fkc,kd->fdc", self.head.slopes(x), self.modes_mm.reshape(len(self.modes_mm), -1))
        by_kpa = by_x / (self.high_kpa - self.low_kpa)
        moved = self._decode(by_kpa.reshape(len(x), self.spline.size, 3 * x.shape[1]), uv)
        return moved.reshape(*moved.shape[:2], 3, x.shape[1])

    def sd_mm(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """Standard deviation (F, P), mm: 95 % of the surface lies within 1.96 of it (a distance, not a coordinate)."""
        doubt = self.head.doubt(self.fraction(pressure_kpa))
        return np.maximum(self.factor * doubt[:, None] * self.pattern_mm(uv)[None, :], LEAST_SD_MM)

    def pattern_mm(self, uv: ArrayLike) -> Floats:
        """Where on the surface errors are large, (P,), mm per unit of doubt."""
        moved = self.spread.T @ self.modes_mm.reshape(len(self.modes_mm), -1)
        return np.sqrt((self._decode(moved.reshape(-1, self.spline.size, 3), uv) ** 2).sum(axis=(0, 2)))

    def latent(self, pressure_kpa: ArrayLike) -> tuple[Floats, Floats]:
        """z (K,) and dz/dpressure (K, C) at one set of pressures (C,), kPa."""
        x = self.fraction(np.asarray(pressure_kpa, dtype=float)[None])
        return self.head.latent(x)[0], self.head.slopes(x)[0] / (self.high_kpa - self.low_kpa)

    def fraction(self, pressure_kpa: ArrayLike) -> Floats:
        """Pressures (F, C) as fractions of each chamber's range."""
        pressure = np.atleast_2d(np.asarray(pressure_kpa, dtype=float))
        if pressure.ndim != 2 or pressure.shape[1] != len(self.chamber_names):
            raise LabrigError(
                f"forward model: pressures of shape {np.shape(pressure_kpa)} given, "
                f"(captures, {len(self.chamber_names)}) needed"
            )
        return (pressure - self.low_kpa) / (self.high_kpa - self.low_kpa)

    def markers(self, names: tuple[str, ...]) -> Floats:
        """(u, v) (M, 2) of named markers; raises `LabrigError` for one that the model does not know."""
        places = dict(zip(self.marker_names, self.marker_uv, strict=True))
        for name in names:
            if name not in places:
                known = f"{self.marker_names[0]} to {self.marker_names[-1]}" if places else "none"
                raise LabrigError(f"forward model: it has no marker {name!r} (it has {known})")
        return np.array([places[name] for name in names]).reshape(-1, 2)

    def _decode(self, control: Floats, uv: ArrayLike) -> Floats:
        """Points (F, P, D) of control points (F, nu, nv, D), or (F, nu * nv, D)."""
        F, size, D = len(control), self.spline.size, control.shape[-1]
        flat = self.basis(uv) @ control.reshape(F, size, D).transpose(1, 0, 2).reshape(size, F * D)
        return np.ascontiguousarray(flat.reshape(len(flat), F, D).transpose(1, 0, 2))

    def basis(self, uv: ArrayLike) -> csr_array:
        """The spline's basis at (u, v) (P, 2), kept for the next time."""
        places = np.ascontiguousarray(uv, dtype=float)
        key = hashlib.blake2b(places.tobytes(), digest_size=16).digest()
        if key not in self._kept:
            while len(self._kept) >= _KEPT:
                self._kept.pop(next(iter(self._kept)), None)
            self._kept[key] = self.spline.basis(places)
        return self._kept[key]
