"""A shell as a function to be minimised: energy, gradient and second derivatives by its free control points."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats, Ints
from labrig.physics._quadrature import Quadrature
from labrig.physics._shell_file import ShellFile


@dataclass(frozen=True)
class History:
    """What a shell remembers, per quadrature point (Q) and layer (L); the default is a shell that is new.

    `eigenstrain` (Q, L, 3): inelastic stretch minus one, 11, 22 and 12, of the directions of `Quadrature`;
    positive where the material has crept longer. `damage` (Q, L): the part of its stiffness that is lost, 0..1.
    """

    eigenstrain: Floats
    damage: Floats

    @classmethod
    def new(cls, points: int, layers: int) -> "History":
        """No memory."""
        return cls(np.zeros((points, layers, 3)), np.zeros((points, layers)))

    def checked(self, points: int, layers: int, name: str) -> "History":
        """This history, if it fits; raises `LabrigError` otherwise."""
        eigenstrain = np.asarray(self.eigenstrain, dtype=float)
        damage = np.asarray(self.damage, dtype=float)
        if eigenstrain.shape != (points, layers, 3) or damage.shape != (points, layers):
            raise LabrigError(
                f"shell {name}: history: eigenstrain {eigenstrain.shape} and damage {damage.shape} given, "
                f"{(points, layers, 3)} and {(points, layers)} needed"
            )
        if not (np.abs(eigenstrain).max(initial=0.0) < 0.5 and (damage >= 0).all() and (damage < 1).all()):
            raise LabrigError(
                f"shell {name}: history: eigenstrains must be finite and below 0.5, damage from 0 to below 1"
            )
        return History(eigenstrain, damage)


def soft_range(x: Floats, limits: tuple[float, float], edge: float) -> Floats:
    """One within limits, zero outside, and between them along an edge of that width; at x (n,)."""
    low, high = limits
    return 0.25 * (1.0 + np.tanh((x - low) / edge)) * (1.0 + np.tanh((high - x) / edge))


@dataclass(frozen=True)
class System:
    """The energy of one shell with its parameters' values and its history.

    Free coordinates x (D,), mm, are displacements from the resting surface: [control point, layer, xyz]. Chamber
    pressures enter as a field (Q, L) at the quadrature points, `field(pressure_kpa)`.
    """

    quadrature: Quadrature
    file: ShellFile
    values: Mapping[str, float]
    history: History

    def with_values(self, **values: float) -> "System":
        """The same with some parameters at other values."""
        return replace(self, values={**self.values, **values})

    @property
    def n_layers(self) -> int:
        """Sheets, one or two."""
        return len(self.file.layers)

    @property
    def size(self) -> int:
        """Free coordinates."""
        return self.quadrature.n_free * 3 * self.n_layers

    @property
    def bandwidth(self) -> int:
        """Rows below the diagonal in the band of the second derivatives."""
        degree, per_point = self.quadrature.spline.degree, 3 * self.n_layers
        return (degree * self.quadrature.n_free_v + degree) * per_point + per_point - 1

    @cached_property
    def patch(self) -> Floats:
        """How much of each chamber's pressure bears on each quadrature point, (Q, C)."""
        u, v = self.quadrature.uv.T
        columns = []
        for chamber in self.file.chambers:
            soft = np.full(len(u), self.values[f"share_{chamber.name}"])
            for x, limits in ((u, chamber.u), (v, chamber.v)):
                soft *= soft_range(x, limits, chamber.edge)
            columns.append(soft)
        return np.stack(columns, axis=1)

    def field(self, pressure_kpa: Floats) -> Floats:
        """Pressure below each layer at the quadrature points, (Q, L), kPa, from chamber pressures (C,)."""
        own = [self._below == layer for layer in range(self.n_layers)]
        return np.stack([self.patch[:, below] @ pressure_kpa[below] for below in own], axis=1)

    @cached_property
    def _below(self) -> Ints:
        """The layer that each chamber lies below, (C,)."""
        return np.array([chamber.layer - 1 for chamber in self.file.chambers])

    @cached_property
    def mass(self) -> Floats:
        """Area that each free coordinate stands for, mm^2, (D,): the metric of a shift of the second derivatives."""
        q = self.quadrature
        share = q.area_mm2[:, None] * q.basis[:, 0]
        node = np.repeat(q.node, q.points_per_element, axis=0)
        area = np.bincount(node.ravel(), weights=share.ravel(), minlength=len(q.control_mm))
        return np.repeat(area[q.moving], 3 * self.n_layers).astype(float)

    @cached_property
    def push_at_rest(self) -> Floats:
        """Force of each chamber's air on the resting shape, per kPa, (D, C)."""
        return self.push(np.zeros(self.size))

    def push(self, x: Floats) -> Floats:
        """Force of each chamber's air on a shape, per kPa, (D, C)."""
        from labrig.physics._shell_push import push

        q = self.quadrature
        force = np.zeros((self.size, len(self.file.chambers)))
        push(
            np.ascontiguousarray(x), q.control_mm, q.free, q.node, q.basis, q.points_per_element, q.area_mm2,
            self._core, self.patch, self._below, self.n_layers, force,
        )  # fmt: skip
        return force

    @cached_property
    def rounding(self) -> float:
        """What an energy may be off by rounding, kPa mm^3: strains are differences of numbers around one."""
        stiffness = float((self._layers[:, 0] * self._layers[:, 1]).sum())
        return 1e-14 * stiffness * float(self.quadrature.area_mm2.sum())

    def energy(self, x: Floats, field: Floats) -> tuple[float, Floats]:
        """Energy, kPa mm^3, and gradient (D,); the energy is infinite for an impossible shape."""
        return self._assemble(x, field, np.zeros((1, 1)), False, True)

    def second(self, x: Floats, field: Floats, band: Floats, convex: bool) -> tuple[float, Floats]:
        """Energy and gradient; writes the second derivatives to `band` (D, bandwidth + 1), see `assemble`.

        `convex` leaves out what compressive stress takes from the stiffness.
        """
        band[:] = 0.0
        return self._assemble(x, field, band, True, convex)

    def _assemble(
        self, x: Floats, field: Floats, band: Floats, curved: bool, convex: bool
    ) -> tuple[float, Floats]:
        from labrig.physics._shell_assembly import assemble
        from labrig.physics._shell_terms import IMPOSSIBLE

        gradient = np.zeros(self.size)
        q = self.quadrature
        energy = assemble(
            np.ascontiguousarray(x), q.control_mm, q.free, q.node, q.basis, q.area_mm2, q.points_per_element,
            self._core, q.normal, q.curvature, field, self._seam, self._inner, 1.0 - self.history.damage,
            self._layers, self._springs, self._down, gradient, band, curved, convex,
        )  # fmt: skip
        return (np.inf if energy >= IMPOSSIBLE or not np.isfinite(energy) else float(energy)), gradient

    @cached_property
    def _core(self) -> Floats:
        """Position and tangents of the core (Q, 3, 3): the resting surface, set off along its normals.

        The offset fades out at the border, where the sheets are held.
        """
        q = self.quadrature
        rest = np.stack([q.at_points(q.control_mm, k) for k in range(3)], axis=1)
        offset = self.values["core_offset_mm"]
        if offset == 0.0:
            return np.ascontiguousarray(rest)
        return np.ascontiguousarray(rest + offset * self._offset_mode)

    @cached_property
    def _offset_mode(self) -> Floats:
        """Position and tangents per mm of core offset, (Q, 3, 3)."""
        q = self.quadrature
        u, v = np.meshgrid(*q.spline.greville, indexing="ij")
        uv = np.stack([u.ravel(), v.ravel()], axis=1)
        control = q.control_mm.reshape(*q.spline.count, 3)
        normal = np.cross(q.spline.evaluate(control, uv, dv=1), q.spline.evaluate(control, uv, du=1))
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        fade = (1.0 - (2.0 * uv[:, 0] - 1.0) ** 8) * (1.0 - (2.0 * uv[:, 1] - 1.0) ** 8)
        mode = fade[:, None] * normal
        return np.stack([q.at_points(mode, k) for k in range(3)], axis=1)

    @cached_property
    def _seam(self) -> Floats:
        """Stiffness that holds layer 1 down between the chambers under it, kPa/mm, (Q,)."""
        covered = np.zeros(len(self.quadrature.uv))
        for k, chamber in enumerate(self.file.chambers):
            if chamber.layer == 1:
                covered += self.patch[:, k] / self.values[f"share_{chamber.name}"]
        return self.values["seam_kpa_per_mm"] * (1.0 - np.clip(covered, 0.0, 1.0))

    @cached_property
    def _inner(self) -> Floats:
        """What takes (C11, C22, C12) as measured to the elastic part's, (Q, L, 3, 3)."""
        stretch = np.array([self.values[f"prestretch_{i + 1}"] for i in range(self.n_layers)])
        e = self.history.eigenstrain
        a, b, c = 1.0 + e[..., 0], 1.0 + e[..., 1], e[..., 2]
        scale = stretch / (a * b - c * c)  # inverse of the inelastic stretch [[a, c], [c, b]]
        p, r, o = scale * b, scale * a, -scale * c
        rows = [[p * p, o * o, 2 * p * o], [o * o, r * r, 2 * o * r], [p * o, o * r, p * r + o * o]]
        return np.ascontiguousarray(np.moveaxis(np.array(rows), (0, 1), (-2, -1)))

    @cached_property
    def _layers(self) -> Floats:
        rows = []
        for i, layer in enumerate(self.file.layers):
            thickness = self.values[f"thickness_{i + 1}_mm"]
            weight = layer.density * self.values["gravity_m_per_s2"] * thickness * 1e-6
            rows.append(
                [self.values[f"modulus_{i + 1}_kpa"], thickness, self.values[f"stiffening_{i + 1}"], weight]
            )
        return np.array(rows)

    @cached_property
    def _springs(self) -> Floats:
        return np.array([self.values[f"{name}_kpa_per_mm"] for name in ("seam", "adhesion", "contact")])

    @cached_property
    def _down(self) -> Floats:
        direction = np.array(self.file.gravity.direction)
        return direction / np.linalg.norm(direction)
