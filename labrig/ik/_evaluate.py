"""A model's surface at chosen (u, v), with its derivatives by the pressures: compiled where the model allows it."""

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from labrig._errors import LabrigError

Floats = NDArray[np.float64]

_CHUNK = 1024
"""Points whose bells fit into the cache."""


@runtime_checkable
class ShapeModel(Protocol):
    """What inverse kinematics needs of a model: a surface by pressures, and its derivatives; limits in kPa, (C,)."""

    @property
    def chamber_names(self) -> tuple[str, ...]:
        """The chambers, in order."""
        ...

    @property
    def low_kpa(self) -> Floats:
        """The lowest pressures (C,)."""
        ...

    @property
    def high_kpa(self) -> Floats:
        """The highest pressures (C,)."""
        ...

    def points(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """Points (F, P, 3), mm, for pressures (F, C) at (u, v) of shape (P, 2)."""
        ...

    def jacobian(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """Their derivatives (F, P, 3, C), mm/kPa."""
        ...


class Evaluator(Protocol):
    """One model at fixed (u, v)."""

    def __call__(self, pressure_kpa: Floats) -> tuple[Floats, NDArray[Any]]:
        """Points (P, 3), mm, and derivatives (P, 3, C), mm/kPa, at pressures (C,)."""
        ...

    def points(self, pressure_kpa: Floats) -> NDArray[Any]:
        """Points (P, 3), mm, alone."""
        ...


def evaluator(model: ShapeModel, uv: ArrayLike) -> Evaluator:
    """The fastest way that there is to evaluate a model at `uv` (P, 2)."""
    uv = np.asarray(uv, float)
    forward = getattr(model, "forward", model)
    if all(hasattr(forward, name) for name in ("mean_mm", "modes_mm", "latent", "spline")):
        if forward is model:
            return Reduced(model, uv)
        if hasattr(model, "warp_state"):
            return Warped(model, uv)
    return Plain(model, uv)


def _latent(model: Any) -> tuple[Callable[[Floats], tuple[Floats, Floats]], int]:
    """How a reduced model gets its coordinates, and how many of its modes they are."""
    if getattr(getattr(model, "head", None), "kind", "") == "gaussian":
        from labrig.ik._gaussian import CompiledGaussian

        compiled = CompiledGaussian(model)
        return compiled, compiled.modes
    return model.latent, len(model.modes_mm)


class Plain:
    """Whatever the model itself gives."""

    def __init__(self, model: ShapeModel, uv: Floats) -> None:
        self._model, self._uv = model, uv

    def __call__(self, pressure_kpa: Floats) -> tuple[Floats, NDArray[Any]]:
        both = getattr(self._model, "points_and_jacobian", None)
        if both is not None:
            return both(pressure_kpa, self._uv)
        one = pressure_kpa[None]
        return self._model.points(one, self._uv)[0], self._model.jacobian(one, self._uv)[0]

    def points(self, pressure_kpa: Floats) -> NDArray[Any]:
        return self._model.points(pressure_kpa[None], self._uv)[0]


class Reduced:
    """A control net in a reduced basis: one small product for the net and its derivatives, then what is local.

    A point needs (degree + 1)^2 control points, whatever the number of modes. Where many points share a u, as on a
    grid, the net is brought to these u first, and a point needs degree + 1 of what that gives.
    """

    def __init__(self, model: Any, uv: Floats) -> None:
        from labrig.ik import _kernels

        self._gather, self._combine = _kernels.gather, _kernels.combine
        self.latent, count = _latent(model)
        spline = model.spline
        modes = np.asarray(model.modes_mm, float)[:count]
        self._modes = np.ascontiguousarray(modes.reshape(count, -1).T, np.float32)
        self._mean = np.asarray(model.mean_mm, float).reshape(-1).astype(np.float32)
        self._count = spline.count
        order = np.arange(spline.degree + 1)
        lines, self._line = np.unique(uv[:, 0], return_inverse=True)
        self._two_steps = len(lines) * spline.count[1] < len(uv)
        first_v, along_v = spline.local(1, uv[:, 1])
        if self._two_steps:
            first_u, along_u = spline.local(0, lines)
            self._across = _packed(first_u[:, None] + order, along_u)
            rows = self._line.reshape(-1, 1) * spline.count[1] + first_v[:, None] + order
            self._along = _packed(rows, along_v)
        else:
            first_u, along_u = spline.local(0, uv[:, 0])
            rows = (
                (first_u[:, None, None] + order[:, None]) * spline.count[1] + first_v[:, None, None] + order
            )
            self._along = _packed(rows, along_u[:, :, None] * along_v[:, None, :])
        self._points = len(uv)

    def __call__(self, pressure_kpa: Floats) -> tuple[Floats, NDArray[Any]]:
        return self.at(*self.latent(pressure_kpa))

    def points(self, pressure_kpa: Floats) -> NDArray[Any]:
        latent, by_pressure = self.latent(pressure_kpa)
        return self.at(latent, by_pressure[:, :0])[0]

    def at(self, latent: Floats, by_pressure: Floats) -> tuple[NDArray[Any], NDArray[Any]]:
        """Points and derivatives for given coordinates (K,) and their derivatives (K, C)."""
        both = np.concatenate([np.asarray(latent)[:, None], by_pressure], axis=1).astype(np.float32)
        net = self._modes @ both
        net[:, 0] += self._mean
        net = net.reshape(self._count[0], -1)
        if self._two_steps:
            lines = np.empty((len(self._across[0]), net.shape[1]), np.float32)
            self._combine(net, *self._across, lines)
            net = lines
        value = np.empty((self._points, 3), np.float32)
        slope = np.empty((self._points, 3, by_pressure.shape[1]), np.float32)
        self._gather(net.reshape(-1, 3 * both.shape[1]), *self._along, value, slope)
        return value, slope


def _packed(rows: NDArray[Any], weight: Floats) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Rows and weights (P, S) as the compiled loops want them."""
    flat = len(rows)
    return (
        np.ascontiguousarray(rows.reshape(flat, -1), np.int32),
        np.ascontiguousarray(weight.reshape(flat, -1), np.float32),
    )


class Warped:
    """The same, followed by a warp whose coefficients and centers depend on the pressures as well."""

    def __init__(self, model: Any, uv: Floats) -> None:
        from labrig.ik import _kernels

        if np.asarray(model.marker_uv).shape[-1] != 2:
            raise LabrigError("a warped model needs the (u, v) of its centers")
        self._warp_slopes = _kernels.warp_slopes
        self._surface = Reduced(model.forward, uv)
        self._centers = Reduced(model.forward, np.asarray(model.marker_uv, float))
        self._latent = self._surface.latent
        self._model = model
        self._quick = getattr(getattr(model, "head", None), "kind", "") == "field"
        self._c = float(model.c)

    def __call__(self, pressure_kpa: Floats) -> tuple[Floats, NDArray[Any]]:
        latent = self._latent(pressure_kpa)
        value, slope = self._surface.at(*latent)
        q, dq = (x.astype(float) for x in self._centers.at(*latent))
        coefficients, by_pressure = self._coefficients(pressure_kpa, latent, q, dq)
        return self._warped(value, slope, q, dq, coefficients, by_pressure)

    def _coefficients(
        self, pressure_kpa: Floats, latent: tuple[Floats, Floats], q: Floats, dq: Floats
    ) -> tuple[Floats, Floats]:
        """The warp's coefficients and their derivatives, without evaluating the forward model once more."""
        if not self._quick:
            return tuple(np.asarray(x, float) for x in self._model.warp_state(pressure_kpa))  # type: ignore[return-value]
        from labrig.surrogate._warp_heads import State

        forward = self._model.forward
        span = forward.high_kpa - forward.low_kpa
        x = (pressure_kpa - forward.low_kpa) / span
        state = State(x, latent[0], latent[1] * span, q, dq * span, self._c)
        coefficients, change = self._model.head.coefficients(state)
        return coefficients, change / span

    def points(self, pressure_kpa: Floats) -> NDArray[Any]:
        latent, by_pressure = self._latent(pressure_kpa)
        value, _ = self._surface.at(latent, by_pressure[:, :0])
        q, dq = (x.astype(float) for x in self._centers.at(latent, by_pressure))
        coefficients, _ = self._coefficients(pressure_kpa, (latent, by_pressure), q, dq)
        q32, beta = q.astype(np.float32), np.asarray(coefficients[4:], np.float32)
        middle = q32.mean(axis=0)
        x, y = value - middle, q32 - middle
        square = (x * x).sum(axis=1)[:, None] - 2.0 * x @ y.T + (y * y).sum(axis=1)
        affine = np.asarray(coefficients[:4], np.float32)
        return affine[0] + value @ affine[1:] + np.exp(-np.float32(self._c) * square) @ beta

    def _warped(
        self,
        value: NDArray[Any],
        slope: NDArray[Any],
        q: Floats,
        dq: Floats,
        coefficients: Floats,
        by_pressure: Floats,
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Everything about the middle of the centers, where squares of coordinates lose least in 32 bits."""
        N, C, c = len(q), slope.shape[2], self._c
        middle = q.mean(axis=0)
        q = q - middle
        A, beta = coefficients[1:4], coefficients[4:]
        alpha = coefficients[0] + middle @ A - middle
        dA, dbeta = by_pressure[1:4], by_pressure[4:]
        dalpha = by_pressure[0] + np.einsum("i,idk->dk", middle, dA)
        along = np.einsum("id,idk->ik", q, dq)
        fixed = dbeta - 2.0 * c * beta[:, :, None] * along[:, None, :]
        turned = 2.0 * c * beta[:, :, None, None] * dq[:, None, :, :]
        table = np.concatenate([fixed.reshape(N, -1), turned.reshape(N, -1)], axis=1).astype(np.float32)
        # gradient of the warp: A' - 2 c (sum_i s_i beta_i x' - sum_i s_i beta_i q_i')
        pulls = np.concatenate([(beta[:, :, None] * q[:, None, :]).reshape(N, 9), beta], axis=1).astype(
            np.float32
        )
        q32, c32 = q.astype(np.float32), np.float32(c)
        square_q = (q32 * q32).sum(axis=1)
        affine_slope = np.concatenate([dalpha[None], dA]).astype(np.float32)
        A32, alpha32 = A.astype(np.float32), alpha.astype(np.float32)
        centred = value - middle.astype(np.float32)
        moved, moved_slope = np.empty_like(value), np.empty_like(slope)
        for begin in range(0, len(value), _CHUNK):
            part = slice(begin, begin + _CHUNK)
            x = centred[part]
            share = x @ q32.T
            share *= 2.0
            share -= (x * x).sum(axis=1)[:, None]
            share -= square_q
            share *= c32
            np.exp(share, out=share)
            pull = share @ pulls
            weighted = pull[:, 9:]
            gradient = A32.T - 2.0 * c32 * (
                weighted[:, :, None] * x[:, None, :] - pull[:, :9].reshape(-1, 3, 3)
            )
            moved[part] = alpha32 + x @ A32 + weighted
            by_chamber = (share @ table).reshape(len(x), 12, C)
            self._warp_slopes(x, slope[part], gradient, by_chamber, affine_slope, moved_slope[part])
        return moved + middle.astype(np.float32), moved_slope
