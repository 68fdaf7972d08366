"""B-spline surfaces over the unit square: a point keeps its (u, v) whatever shape the control points take."""

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_array, csr_array, eye_array, kron
from scipy.sparse.linalg import splu

from labrig._errors import LabrigError
from labrig.arrays import Floats

_OUTSIDE = 1e-9
_STIFFNESS = 1e-9
"""Weight of the control net's second differences in a fit, relative to the data: decides where no data is."""


class Spline:
    """A tensor-product B-spline basis with clamped uniform knots, u first and v second.

    `count` control points (n_u, n_v) of the given `degree`; `size` is n_u * n_v. Control points are arrays
    (..., n_u, n_v, 3) in mm, and flatten in C order: i_u * n_v + i_v.
    """

    def __init__(self, count: tuple[int, int] = (30, 30), degree: int = 2) -> None:
        n_u, n_v = (int(n) for n in count)
        if degree < 1 or min(n_u, n_v) <= degree:
            raise LabrigError(
                f"spline: {n_u} x {n_v} control points of degree {degree}: more control points per direction "
                f"than the degree, and a degree of at least 1, are needed"
            )
        self.count = (n_u, n_v)
        self.degree = int(degree)
        self.size = n_u * n_v

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Spline) and (self.count, self.degree) == (other.count, other.degree)

    def __hash__(self) -> int:
        return hash((self.count, self.degree))

    def __repr__(self) -> str:
        return f"Spline(count={self.count}, degree={self.degree})"

    @cached_property
    def knots(self) -> tuple[Floats, Floats]:
        """The knots of u and of v, each (n + degree + 1,)."""
        return _knots(self.count[0], self.degree), _knots(self.count[1], self.degree)

    @cached_property
    def greville(self) -> tuple[Floats, Floats]:
        """Where each control point pulls most, in u (n_u,) and in v (n_v,)."""
        u, v = (
            np.array([knots[i + 1 : i + self.degree + 1].mean() for i in range(n)])
            for knots, n in zip(self.knots, self.count, strict=True)
        )
        return u, v

    def local(self, axis: int, at: ArrayLike, derivative: int = 0) -> tuple[NDArray[np.int64], Floats]:
        """The basis functions of one direction (0 is u) that are not zero at the points `at` (P,).

        Returns the index of the first one, (P,), and their values or derivatives, (P, degree + 1).
        """
        knots, n = self.knots[axis], self.count[axis]
        x = _in_range(at)
        span = np.clip(np.searchsorted(knots, x, side="right") - 1, self.degree, n - 1)
        return span - self.degree, _basis(knots, span, x, self.degree, derivative)

    def basis(self, uv: ArrayLike, du: int = 0, dv: int = 0) -> csr_array:
        """The matrix (P, size) that takes flattened control points to points at `uv` (P, 2).

        `du`, `dv` ask for derivatives instead. Raises `LabrigError` for points outside the unit square.
        """
        uv = np.asarray(uv, dtype=float).reshape(-1, 2)
        first_u, along_u = self.local(0, uv[:, 0], du)
        first_v, along_v = self.local(1, uv[:, 1], dv)
        order = np.arange(self.degree + 1)
        column = (first_u[:, None, None] + order[:, None]) * self.count[1] + first_v[:, None, None] + order
        value = along_u[:, :, None] * along_v[:, None, :]
        entries = (self.degree + 1) ** 2
        start = np.arange(len(uv) + 1) * entries
        return csr_array((value.ravel(), column.ravel(), start), shape=(len(uv), self.size))

    def evaluate(self, control_mm: ArrayLike, uv: ArrayLike, du: int = 0, dv: int = 0) -> Floats:
        """Points (..., P, 3), mm, of surfaces with control points (..., n_u, n_v, 3); or their derivatives."""
        control = np.asarray(control_mm, dtype=float)
        if control.shape[-3:] != (*self.count, 3):
            raise LabrigError(
                f"spline: control points of shape {control.shape} given, (..., {self.count[0]}, "
                f"{self.count[1]}, 3) needed"
            )
        basis = self.basis(uv, du, dv)
        lead = control.shape[:-3]
        points = len(np.asarray(uv).reshape(-1, 2))
        flat = np.moveaxis(control.reshape(-1, self.size, 3), 1, 0).reshape(self.size, -1)
        moved = (basis @ flat).reshape(points, -1, 3)
        return np.ascontiguousarray(np.moveaxis(moved, 0, 1)).reshape(*lead, points, 3)

    def interpolate(self, points_mm: Callable[[Floats, Floats], ArrayLike]) -> Floats:
        """Control points (n_u, n_v, 3) of the surface that meets `points_mm(u, v) -> (..., 3)` at the Greville
        points; the function is called once, with arrays (n_u, n_v).
        """
        u, v = np.meshgrid(*self.greville, indexing="ij")
        wanted = np.asarray(points_mm(u, v), dtype=float)
        across = np.linalg.solve(_dense(self, 0), wanted.reshape(self.count[0], -1))
        across = across.reshape(*self.count, 3).transpose(1, 0, 2).reshape(self.count[1], -1)
        control = np.linalg.solve(_dense(self, 1), across).reshape(self.count[1], self.count[0], 3)
        return np.asarray(control.transpose(1, 0, 2), dtype=float)

    def fit(self, points_mm: ArrayLike, uv: ArrayLike) -> Floats:
        """Control points (n_u, n_v, 3) of the surface nearest to points (P, 3) at `uv` (P, 2): least squares.

        Where there are no points the control net is as smooth as it can be. Raises `LabrigError` for fewer
        than three points, or points that are not finite.
        """
        wanted = np.asarray(points_mm, dtype=float).reshape(-1, 3)
        basis = self.basis(uv)
        places = len(np.asarray(uv).reshape(-1, 2))
        if len(wanted) != places or len(wanted) < 3 or not np.isfinite(wanted).all():
            raise LabrigError(
                f"spline: a fit needs at least three finite points, each with its (u, v): {len(wanted)} points "
                f"and {places} places given"
            )
        rough = self._roughness
        normal = basis.T @ basis
        weight = _STIFFNESS * max(1.0, len(wanted) / self.size)
        solver = splu(csc_array(normal + weight * rough))
        return solver.solve(np.asarray(basis.T @ wanted)).reshape(*self.count, 3)

    @cached_property
    def _roughness(self) -> csr_array:
        """Sum of squared second differences of the control net, (size, size)."""
        u, v = (_second_differences(n) for n in self.count)
        rough = kron(u, eye_array(self.count[1])) + kron(eye_array(self.count[0]), v)
        return csr_array(rough)


def grid(n_u: int, n_v: int) -> tuple[Floats, NDArray[np.int64]]:
    """A regular grid of the unit square, `uv` (n_u * n_v, 2) with u fastest, and its triangles (T, 3).

    Triangles are wound so that normals point along d/dv x d/du, which is outwards on labrig's surfaces.
    """
    u, v = np.meshgrid(np.linspace(0.0, 1.0, n_u), np.linspace(0.0, 1.0, n_v), indexing="xy")
    corner = np.arange(n_u * n_v).reshape(n_v, n_u)
    a, b, c, d = (x.ravel() for x in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]))
    triangles = np.concatenate([np.stack([a, c, b], 1), np.stack([a, d, c], 1)]).astype(np.int64)
    return np.stack([u.ravel(), v.ravel()], axis=1), triangles


def _knots(n: int, degree: int) -> Floats:
    return np.concatenate([np.zeros(degree), np.linspace(0.0, 1.0, n - degree + 1), np.ones(degree)])


def _in_range(at: ArrayLike) -> Floats:
    x = np.asarray(at, dtype=float).ravel()
    if not ((x >= -_OUTSIDE) & (x <= 1.0 + _OUTSIDE)).all():
        raise LabrigError("spline: (u, v) must be finite and lie between 0 and 1")
    return np.clip(x, 0.0, 1.0)


def _basis(knots: Floats, span: NDArray[np.int64], x: Floats, degree: int, derivative: int) -> Floats:
    """Values or derivatives (P, degree + 1) of the functions degree `degree` on the knots' spans (P,)."""
    if derivative > degree:
        return np.zeros((len(x), degree + 1))
    if degree == 0:
        return np.ones((len(x), 1))
    lower = _basis(knots, span, x, degree - 1, max(derivative - 1, 0))
    out = np.zeros((len(x), degree + 1))
    for k in range(degree):
        left = knots[span - degree + 1 + k]
        right = knots[span + 1 + k]
        if derivative > 0:
            flow = degree * lower[:, k] / (right - left)
            out[:, k] -= flow
            out[:, k + 1] += flow
        else:
            share = lower[:, k] / (right - left)
            out[:, k] += (right - x) * share
            out[:, k + 1] += (x - left) * share
    return out


def _dense(spline: Spline, axis: int) -> Floats:
    """Values of the basis functions of one direction at its Greville points, (n, n)."""
    n = spline.count[axis]
    first, value = spline.local(axis, spline.greville[axis])
    matrix = np.zeros((n, n))
    np.put_along_axis(matrix, first[:, None] + np.arange(spline.degree + 1), value, axis=1)
    return matrix


def _second_differences(n: int) -> csr_array:
    """D^T D of the second differences of n values, (n, n); zero for fewer than three."""
    if n < 3:
        return csr_array((n, n))
    row = np.arange(n - 2)
    d = csr_array((n - 2, n))
    for k, weight in enumerate((1.0, -2.0, 1.0)):
        d = d + csr_array((np.full(n - 2, weight), (row, row + k)), shape=(n - 2, n))
    return csr_array(d.T @ d)
