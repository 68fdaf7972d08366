"""A model's surface at chosen (u, v), with its derivatives by the pressures: compiled where the model allows it."""

from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from labrig.arrays import Floats
from labrig.ik._reduced import Reduced
from labrig.ik._warped import Warped


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
