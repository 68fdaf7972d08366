"""A surface behind a warp, at chosen (u, v), with its derivatives by the pressures: products and compiled loops."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.ik._gaussian import Process
from labrig.ik._reduced import Reduced

_CHUNK = 1024
"""Points whose bells fit into the cache."""


def _coefficients(model: Any) -> Callable[[Floats], tuple[Floats, Floats]]:
    """What gives the warp's coefficients (N + 4, 3) at pressures (C,), kPa, and their derivatives (N + 4, 3, C)."""
    if getattr(getattr(model, "head", None), "kind", "") == "field":
        return _Field(model)
    return lambda pressure: tuple(np.asarray(x, float) for x in model.warp_state(pressure))  # type: ignore[return-value]


class _Field:
    """Coefficients that are a Gaussian process of the pressures, turned into the rig's frame beforehand."""

    def __init__(self, model: Any) -> None:
        head = model.head
        turned = head.weights @ model.rotation.T
        self._constant = head.constant @ model.rotation.T
        self._constant[0] += model.translation_mm
        self._process = Process(head.kernel, head.points, turned.reshape(len(turned), -1))
        self._low, self._span = model.low_kpa, model.high_kpa - model.low_kpa

    def __call__(self, pressure_kpa: Floats) -> tuple[Floats, Floats]:
        value, slope = self._process((pressure_kpa - self._low) / self._span)
        shape = self._constant.shape
        return self._constant + value.reshape(shape), (slope / self._span[:, None]).T.reshape(*shape, -1)


class Warped:
    """A surface in a reduced basis behind a warp whose coefficients and centers depend on the pressures as well."""

    def __init__(self, model: Any, uv: Floats) -> None:
        from labrig.ik import _kernels

        if np.asarray(model.marker_uv).shape[-1] != 2:
            raise LabrigError("a warped model needs the (u, v) of its centers")
        self._warp = _kernels.warp
        self._surface = Reduced(model.forward, uv)
        self._centers = Reduced(model.forward, np.asarray(model.marker_uv, float))
        self._latent = self._surface.latent
        self._coefficients = _coefficients(model)
        self._c = float(model.c)

    def __call__(self, pressure_kpa: Floats) -> tuple[Floats, NDArray[Any]]:
        latent = self._latent(pressure_kpa)
        value, slope = self._surface.at(*latent)
        q, dq = (x.astype(float) for x in self._centers.at(*latent))
        coefficients, by_pressure = self._coefficients(pressure_kpa)
        return self._warped(value, slope, q, dq, coefficients, by_pressure)

    def points(self, pressure_kpa: Floats) -> NDArray[Any]:
        latent, by_pressure = self._latent(pressure_kpa)
        value, _ = self._surface.at(latent, by_pressure[:, :0])
        q32, _ = self._centers.at(latent, by_pressure[:, :0])
        coefficients, _ = self._coefficients(pressure_kpa)
        beta = np.asarray(coefficients[4:], np.float32)
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
        double, square_q = 2.0 * c32 * q32.T, c32 * (q32 * q32).sum(axis=1)
        affine = np.concatenate([alpha[None], A]).astype(np.float32)
        affine_slope = np.concatenate([dalpha[None], dA]).astype(np.float32)
        centred = value - middle.astype(np.float32)
        moved, moved_slope = np.empty_like(value), np.empty_like(slope)
        for begin in range(0, len(value), _CHUNK):
            part = slice(begin, begin + _CHUNK)
            x = centred[part]
            share = x @ double
            share -= (c32 * np.einsum("pi,pi->p", x, x))[:, None]
            share -= square_q
            np.exp(share, out=share)
            self._warp(
                x, slope[part], share @ pulls, (share @ table).reshape(len(x), 12, C), affine, affine_slope, c32,
                moved[part], moved_slope[part],
            )  # fmt: skip
        moved += middle.astype(np.float32)
        return moved, moved_slope
