"""A model in a reduced basis, evaluated at fixed (u, v): one small product, then what is local."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.ik._gaussian import CompiledGaussian, compiles


class Reduced:
    """A control net in a reduced basis: one small product for the net and its derivatives, then what is local.

    A point needs (degree + 1)^2 control points, whatever the number of modes. Where many points share a u, as on a
    grid, the net is brought to these u first, and a point needs degree + 1 of what that gives. Where there are fewer
    points than control points, the modes are brought to them once and for all.
    """

    def __init__(self, model: Any, uv: Floats) -> None:
        from labrig.ik import _kernels

        self._gather, self._combine = _kernels.gather, _kernels.combine
        self.latent, count = _latent(model)
        spline = model.spline
        modes = np.asarray(model.modes_mm, float)[:count].reshape(count, -1, 3)
        mean = np.asarray(model.mean_mm, float).reshape(-1, 3)
        self._points, self._direct = len(uv), len(uv) <= spline.size
        if self._direct:
            basis = spline.basis(uv)
            mean = basis @ mean
            modes = np.array([basis @ mode for mode in modes])
        self._modes = np.ascontiguousarray(modes.reshape(count, -1).T, np.float32)
        self._mean = mean.reshape(-1).astype(np.float32)
        if self._direct:
            return
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

    def __call__(self, pressure_kpa: Floats) -> tuple[Floats, NDArray[Any]]:
        return self.at(*self.latent(pressure_kpa))

    def points(self, pressure_kpa: Floats) -> NDArray[Any]:
        latent, by_pressure = self.latent(pressure_kpa)
        return self.at(latent, by_pressure[:, :0])[0]

    def at(self, latent: Floats, by_pressure: Floats) -> tuple[NDArray[Any], NDArray[Any]]:
        """Points and derivatives for given coordinates (K,) and their derivatives (K, C)."""
        if self._direct:
            value = self._modes @ np.asarray(latent, np.float32) + self._mean
            slope = self._modes @ np.asarray(by_pressure, np.float32, order="C")
            return value.reshape(-1, 3), slope.reshape(self._points, 3, -1)
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


def _latent(model: Any) -> tuple[Callable[[Floats], tuple[Floats, Floats]], int]:
    """How a reduced model gets its coordinates, and how many of its modes they are."""
    if compiles(model):
        compiled = CompiledGaussian(model)
        return compiled, compiled.modes
    return model.latent, len(model.modes_mm)


def _packed(rows: NDArray[Any], weight: Floats) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Rows and weights (P, S) as the compiled loops want them."""
    flat = len(rows)
    return (
        np.ascontiguousarray(rows.reshape(flat, -1), np.int32),
        np.ascontiguousarray(weight.reshape(flat, -1), np.float32),
    )
