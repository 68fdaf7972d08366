"""A reduced model of an inflated surface: each chamber is a membrane, the surface follows their deflections.

A chamber's deflection d solves  d + d^3 / limit^2 = gain * p  (a pre-tensioned membrane: linear at first,
cubic when stretched), so it grows monotonically with pressure and has a closed form. Points move along their
normals by the weighted sum of the deflections, and tangentially by the second-order term of a membrane that
is pulled up a slope, -b h grad(h).
"""

from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.physics._geometry import GEOMETRIES, Geometry, profiles, tangents
from labrig.physics._rig_file import places_of


@dataclass(frozen=True)
class _Points:
    """What is needed to move a set of points: rest (P, 3), normal (P, 3), weight (P, C), gradient (P, C, 3)."""

    rest_mm: Floats
    normal: Floats
    weight: Floats
    gradient_per_mm: Floats

    @classmethod
    def at(cls, geometry: Geometry, u: Floats, v: Floats) -> "_Points":
        along_u, along_v, normal = tangents(geometry, u, v)
        weight, slope_u, slope_v = profiles(geometry, u, v)
        uu, uv, vv = (
            (a * b).sum(-1)[:, None] for a, b in ((along_u, along_u), (along_u, along_v), (along_v, along_v))
        )
        determinant = uu * vv - uv * uv
        up = (vv * slope_u - uv * slope_v) / determinant
        right = (uu * slope_v - uv * slope_u) / determinant
        gradient = up[..., None] * along_u[:, None] + right[..., None] * along_v[:, None]
        return cls(geometry.rest(u, v), normal, weight, gradient)

    def moved(self, deflection_mm: Floats, tangential: float) -> Floats:
        """Positions, mm, (F, P, 3) for deflections (F, C)."""
        height = deflection_mm @ self.weight.T
        slope = np.tensordot(deflection_mm, self.gradient_per_mm, axes=([1], [1]))
        return self.rest_mm + height[..., None] * (self.normal - tangential * slope)


class Surface:
    """The base simulator of a rig: pressures in, marker positions and a mesh out; no memory, no noise.

    Attributes: `chamber_names` (C), `marker_names` (M), `rest_mm` (M, 3), and `parameters`, the physical
    parameters that the model declares as its own (none: its stiffnesses are taken as known).
    """

    def __init__(
        self, geometry: Geometry, chamber_names: tuple[str, ...], marker_names: tuple[str, ...]
    ) -> None:
        self.geometry = geometry
        self.chamber_names = chamber_names
        self.marker_names = marker_names
        self.parameters: MappingProxyType[str, float] = MappingProxyType({})
        index = [int(name[1:]) - 1 for name in marker_names]
        self.marker_uv = geometry.markers_uv[index]
        self._markers = _Points.at(geometry, self.marker_uv[:, 0], self.marker_uv[:, 1])
        self._gain = np.array([patch.gain_mm_per_kpa for patch in geometry.patches])
        self._limit = np.array([patch.limit_mm for patch in geometry.patches])

    def at(self, uv: ArrayLike) -> "Surface":
        """The same surface, predicting the points at `uv` (P, 2) in place of its markers; they have no names."""
        other = copy(self)
        other.marker_uv = np.asarray(uv, dtype=float).reshape(-1, 2)
        other.marker_names = ()
        other._markers = _Points.at(self.geometry, other.marker_uv[:, 0], other.marker_uv[:, 1])
        return other

    @property
    def rest_mm(self) -> Floats:
        """Marker positions with every chamber vented, mm, (M, 3)."""
        return self._markers.rest_mm

    @property
    def normal(self) -> Floats:
        """Outward unit normals at the markers at rest, (M, 3)."""
        return self._markers.normal

    @property
    def weight(self) -> Floats:
        """Normal displacement of each marker per mm of deflection of each chamber, (M, C)."""
        return self._markers.weight

    @property
    def compliance_mm_per_kpa(self) -> Floats:
        """Deflection per pressure at rest, (C,)."""
        return self._gain

    @property
    def limit_mm(self) -> Floats:
        """Deflection at which the cubic stiffness of a chamber equals its linear one, (C,)."""
        return self._limit

    @property
    def tangential(self) -> float:
        """The second-order tangential coefficient, dimensionless."""
        return self.geometry.tangential

    def deflection_mm(self, pressure_kpa: ArrayLike) -> Floats:
        """Deflection of each chamber at the middle of its patch, mm, same shape as the pressures (..., C)."""
        load = self._gain * np.asarray(pressure_kpa, dtype=float)
        scale = 2.0 * self._limit / np.sqrt(3.0)
        return scale * np.sinh(np.arcsinh(1.5 * np.sqrt(3.0) * load / self._limit) / 3.0)

    def shape_mm(self, deflection_mm: Floats) -> Floats:
        """Marker positions for chamber deflections (F, C): (F, M, 3), mm."""
        return self._markers.moved(np.atleast_2d(deflection_mm), self.tangential)

    def predict(self, pressure_kpa: ArrayLike) -> Floats:
        """Marker positions, mm, (F, M, 3), for pressures (F, C), kPa; NaN in, NaN out."""
        return self.shape_mm(self.deflection_mm(self._checked(pressure_kpa)))

    def jacobian(self, pressure_kpa: ArrayLike) -> Floats:
        """d position / d pressure, mm/kPa, (F, M, 3, C), at pressures (F, C); analytic."""
        deflection = self.deflection_mm(self._checked(pressure_kpa))
        points = self._markers
        height = deflection @ points.weight.T
        slope = np.tensordot(deflection, points.gradient_per_mm, axes=([1], [1]))
        gradient = points.gradient_per_mm.transpose(0, 2, 1)
        by_deflection = (points.normal - self.tangential * slope)[..., None] * points.weight[:, None]
        by_deflection = by_deflection - self.tangential * height[..., None, None] * gradient
        by_pressure = self._gain / (1.0 + 3.0 * (deflection / self._limit) ** 2)
        return by_deflection * by_pressure[:, None, None, :]

    def mesh(self, pressure_kpa: ArrayLike) -> tuple[Floats, NDArray[np.int64]]:
        """The whole surface at one set of pressures (C,): vertices mm (V, 3), triangles (T, 3), wound
        outwards.
        """
        return self.mesh_at(self.deflection_mm(self._checked(pressure_kpa)[0])), self.triangles

    def mesh_at(self, deflection_mm: Floats) -> Floats:
        """Mesh vertices, mm, (V, 3), for chamber deflections (C,)."""
        return self._mesh_points.moved(np.atleast_2d(deflection_mm), self.tangential)[0]

    _MESH_ACROSS, _MESH_UP = 61, 81

    @cached_property
    def _mesh_points(self) -> _Points:
        u, v = np.meshgrid(
            np.linspace(0, 1, self._MESH_ACROSS), np.linspace(0, 1, self._MESH_UP), indexing="xy"
        )
        return _Points.at(self.geometry, u.ravel(), v.ravel())

    @property
    def triangles(self) -> NDArray[np.int64]:
        """Triangles of the mesh, (T, 3) vertex indices, wound so that normals point outwards."""
        return self._triangles

    @cached_property
    def _triangles(self) -> NDArray[np.int64]:
        corner = np.arange(self._MESH_ACROSS * self._MESH_UP).reshape(self._MESH_UP, self._MESH_ACROSS)
        a, b, c, d = (x.ravel() for x in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]))
        return np.concatenate([np.stack([a, c, b], 1), np.stack([a, d, c], 1)]).astype(np.int64)

    def _checked(self, pressure_kpa: ArrayLike) -> Floats:
        return as_pressures(pressure_kpa, len(self.chamber_names), f"surface {self.geometry.name}")


def as_pressures(pressure_kpa: ArrayLike, chambers: int, whose: str) -> Floats:
    """Pressures as an array (F, C) of its own; raises `LabrigError` for another number of chambers."""
    pressure = np.atleast_2d(np.array(pressure_kpa, dtype=float))
    if pressure.ndim != 2 or pressure.shape[1] != chambers:
        raise LabrigError(
            f"{whose}: pressures of shape {np.shape(pressure_kpa)} given, (captures, {chambers}) needed"
        )
    return pressure


def reduced_surface(rig: dict) -> Surface:
    """The reduced model of a rig, from the content of its rig.yaml.

    The surface is named by `simulated: {surface: ...}` (mannequin, the default here, or membrane). Chambers are
    c1, c2, ... by name where all are called so, in whatever order, else they take the rig's names in order;
    `markers`, where given, selects and orders the surface's own m01, m02, ...
    Raises `LabrigError` for a surface that does not exist, or names or numbers that do not fit it.
    """
    name = (rig.get("simulated") or {}).get("surface", "mannequin")
    if name not in GEOMETRIES:
        raise LabrigError(
            f"rig: simulated.surface: there is no surface '{name}' (known: {', '.join(GEOMETRIES)})"
        )
    geometry = GEOMETRIES[name]
    count = len(geometry.patches)
    listed = [c["name"] if isinstance(c, dict) else str(c) for c in rig.get("chambers") or []]
    own = [f"c{i + 1}" for i in range(count)]
    chambers = listed or own
    if len(chambers) != count:
        raise LabrigError(f"rig: chambers: surface '{name}' has {count}, the rig names {len(chambers)}")
    known = [f"m{i + 1:02d}" for i in range(len(geometry.markers_uv))]
    markers = [str(m) for m in rig.get("markers") or known]
    for marker in markers:
        if marker not in known:
            raise LabrigError(
                f"rig: markers: surface '{name}' has no marker '{marker}' (it has m01..{known[-1]})"
            )
    patches = tuple(geometry.patches[k] for k in places_of(chambers, own))
    return Surface(replace(geometry, patches=patches), tuple(chambers), tuple(markers))
