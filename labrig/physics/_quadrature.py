"""Where a shell's energy is summed: Gauss points of every knot span, in orthonormal directions of the surface."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats, Ints
from labrig.surface import Spline


@dataclass(frozen=True)
class Quadrature:
    """A resting surface cut into elements (E, the knot spans) with their quadrature points (Q, by element).

    `control_mm` (K, 3) control points; `node` (E, N) those that an element depends on, `free` (E, N) the same
    numbered among the `n_free` that may move, or -1; `n_free_v` of them in a row.
    `uv` (Q, 2), `area_mm2` (Q,), `basis` (Q, 6, N): value, derivatives along the two directions, and 11, 22, 12;
    `normal` (Q, 3) outwards, `curvature` (Q, 3): 11, 22, 12. `moving` (K,) is true for free control points.
    """

    spline: Spline
    control_mm: Floats
    node: Ints
    free: Ints
    moving: NDArray[np.bool_]
    n_free_v: int
    uv: Floats
    area_mm2: Floats
    basis: Floats
    normal: Floats
    curvature: Floats

    @property
    def n_free(self) -> int:
        """Control points that may move."""
        return int(self.moving.sum())

    @property
    def points_per_element(self) -> int:
        """Quadrature points in a knot span."""
        return len(self.area_mm2) // len(self.node)

    def at_points(self, control_mm: Floats, derivative: int = 0) -> Floats:
        """A field with control points (K, ...) at the quadrature points (Q, ...), or a derivative (0..5)."""
        node = np.repeat(self.node, self.points_per_element, axis=0)
        return np.einsum("qn,qn...->q...", self.basis[:, derivative], control_mm[node])


def make_quadrature(
    spline: Spline, points_mm: Callable[[Floats, Floats], Floats], fixed_rings: int, name: str
) -> Quadrature:
    """The quadrature of the surface that meets `points_mm(u, v)`, degree x degree points in every knot span.

    The outer `fixed_rings` rings of control points do not move: one holds the border, two its slope as well.
    """
    control = spline.interpolate(points_mm).reshape(-1, 3)
    places, weights, first, along = zip(*(_gauss(spline, axis) for axis in (0, 1)), strict=True)
    n_u, n_v = spline.count
    per = spline.degree
    spans = (n_u - per, n_v - per)

    node = (first[0][::per, None, None, None] + np.arange(per + 1)[:, None]) * n_v
    node = node + first[1][None, ::per, None, None] + np.arange(per + 1)[None, None, None, :]
    node = np.broadcast_to(node, (*spans, per + 1, per + 1)).reshape(-1, (per + 1) ** 2)

    def by_element(pairs: Floats) -> Floats:
        """From [u point, v point, ...] to [element, point within it, ...]."""
        cut = pairs.reshape(spans[0], per, spans[1], per, *pairs.shape[2:]).swapaxes(1, 2)
        return np.ascontiguousarray(cut).reshape(-1, *pairs.shape[2:])

    def product(du: int, dv: int) -> Floats:
        outer = along[0][du][:, None, :, None] * along[1][dv][None, :, None, :]
        return by_element(outer.reshape(*outer.shape[:2], -1))

    uv = by_element(np.stack(np.meshgrid(places[0], places[1], indexing="ij"), axis=-1))
    parametric = np.stack([product(*d) for d in ((0, 0), (1, 0), (0, 1), (2, 0), (0, 2), (1, 1))], axis=-1)
    basis, normal, stretch = _orthonormal(parametric, control[np.repeat(node, per * per, axis=0)], name)
    area = by_element(weights[0][:, None] * weights[1][None, :]) * stretch

    moving = np.zeros((n_u, n_v), dtype=bool)
    moving[fixed_rings : n_u - fixed_rings, fixed_rings : n_v - fixed_rings] = True
    number = np.where(moving.ravel(), np.cumsum(moving.ravel()) - 1, -1)
    corners = control[np.repeat(node, per * per, axis=0)]
    curvature = np.stack([(_sum(basis[:, k], corners) * normal).sum(-1) for k in (3, 4, 5)], axis=-1)
    return Quadrature(
        spline=spline,
        control_mm=control,
        node=np.ascontiguousarray(node, dtype=np.int64),
        free=np.ascontiguousarray(number[node], dtype=np.int64),
        moving=moving.ravel(),
        n_free_v=n_v - 2 * fixed_rings,
        uv=uv,
        area_mm2=area,
        basis=basis,
        normal=normal,
        curvature=curvature,
    )


def gauss_places(spline: Spline, axis: int) -> Floats:
    """Where the quadrature points lie along one direction of the unit square, ascending, (n,)."""
    breaks = np.unique(spline.knots[axis])
    x, _ = np.polynomial.legendre.leggauss(spline.degree)
    return (0.5 * (breaks[:-1] + breaks[1:])[:, None] + 0.5 * np.diff(breaks)[:, None] * x).ravel()


def _gauss(spline: Spline, axis: int) -> tuple[Floats, Floats, Ints, Floats]:
    """Gauss points of one direction's spans, weights, first basis functions, values and two derivatives."""
    _, w = np.polynomial.legendre.leggauss(spline.degree)
    half = 0.5 * np.diff(np.unique(spline.knots[axis]))[:, None]
    places = gauss_places(spline, axis)
    first, _ = spline.local(axis, places)
    along = np.stack([spline.local(axis, places, derivative)[1] for derivative in range(3)])
    return places, (half * w).ravel(), first, along


def _sum(weight: Floats, corners: Floats) -> Floats:
    return np.einsum("qn,qnc->qc", weight, corners)


def _orthonormal(parametric: Floats, corners: Floats, name: str) -> tuple[Floats, Floats, Floats]:
    """Derivatives by (u, v) turned into derivatives along orthonormal tangents; normals; area per du dv.

    The first direction is that of v, the second is 90 degrees to its left, so their cross product is outwards.
    """
    by_u, by_v = _sum(parametric[..., 1], corners), _sum(parametric[..., 2], corners)
    normal = np.cross(by_v, by_u)
    stretch = np.linalg.norm(normal, axis=1)
    if not (stretch > 1e-9 * np.median(stretch)).all():
        raise LabrigError(
            f"shell {name}: its core is folded or has no area somewhere, so no sheet can lie on it"
        )
    normal /= stretch[:, None]
    first = by_v / np.linalg.norm(by_v, axis=1, keepdims=True)
    second = np.cross(normal, first)
    metric = np.stack(
        [np.stack([(d * e).sum(-1) for e in (first, second)], axis=-1) for d in (by_u, by_v)], axis=1
    )
    turn = np.linalg.inv(metric)  # turn[q, direction, parameter]
    gradient = np.einsum("qda,qna->qnd", turn, parametric[..., 1:3])
    second_by = np.stack(
        [parametric[..., 3], parametric[..., 5], parametric[..., 5], parametric[..., 4]], axis=-1
    ).reshape(*parametric.shape[:2], 2, 2)
    hessian = np.einsum("qda,qnab,qeb->qnde", turn, second_by, turn)
    basis = np.stack(
        [
            parametric[..., 0], gradient[..., 0], gradient[..., 1],
            hessian[..., 0, 0], hessian[..., 1, 1], hessian[..., 0, 1],
        ],
        axis=1,
    )  # fmt: skip
    return np.ascontiguousarray(basis), normal, stretch
