"""A large skin over twelve chambers, with twenty-four markers."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig


class Skin(Rig):
    """A plate with a soft patch over each chamber; the walls stiffen, and rest on a floor below zero.

    The pressure over a patch is a d / (1 - (d / d_max)^2), after the finite extensibility of rubber (Gent, Rubber
    Chemistry and Technology, 1996, in its simplest form). The markers ride on the upper face: they lean with the
    slope of the plate (Kirchhoff) and are drawn inwards by the stretch of the middle plane (Timoshenko and
    Woinowsky-Krieger, Theory of Plates and Shells, 1959).
    """

    kind: ClassVar[str] = "skin"

    def __init__(self, random: np.random.Generator) -> None:
        self.chambers = tuple(f"c{number:02d}" for number in range(1, 13))
        self.high_kpa = random.uniform(25, 60) * random.uniform(0.85, 1.15, 12)
        self.noise = 0.1
        pitch_mm = random.uniform(60, 85)
        column, line = np.meshgrid(np.arange(4) - 1.5, np.arange(3) - 1.0)
        seat_mm = pitch_mm * np.column_stack([column.ravel(), line.ravel()])
        seat_mm += random.normal(0, 0.1 * pitch_mm, seat_mm.shape)
        column, line = np.meshgrid(np.arange(6) - 2.5, np.arange(4) - 1.5)
        place_mm = pitch_mm * 0.68 * np.column_stack([column.ravel(), line.ravel()])
        place_mm += random.normal(0, 0.08 * pitch_mm, place_mm.shape)
        width_mm = pitch_mm * random.uniform(0.4, 0.85, 12)
        away = place_mm[None] - seat_mm[:, None]
        bump = np.exp(-(away**2).sum(axis=2) / (2 * width_mm[:, None] ** 2))
        self._height_mm = random.uniform(12, 26, 12)[:, None] * bump
        self._slope = -away / width_mm[:, None, None] ** 2 * self._height_mm[:, :, None]
        self._face_mm = random.uniform(3, 8)
        self._draw = random.uniform(0.25, 0.5)
        self._limit = random.uniform(0.35, 1.6, 12)
        self.rest_mm = np.column_stack([place_mm, np.zeros(24)]).astype(np.float64)
        self.marker_names = tuple(f"m{number:02d}" for number in range(1, 25))
        self.observables = tuple(
            Observable(f"{name}_{'xyz'[axis]}", "mm", marker, axis)
            for marker, name in enumerate(self.marker_names)
            for axis in range(3)
        )

    def deflection(self, kpa: Floats) -> Floats:
        """How far each wall gives way: nothing below zero, ever less above."""
        load = np.maximum(np.asarray(kpa, dtype=float) / self.high_kpa, 0.0)

        def share(load: Floats | float) -> Floats:
            return 2 * load / (self._limit + np.sqrt(self._limit**2 + 4 * np.square(load)))

        return share(load) / share(1.0)

    def shape(self, deflection: Floats) -> Floats:
        """How far each marker is from its rest, x, y, z, in mm."""
        height_mm = deflection @ self._height_mm
        slope = np.einsum("tc,cma->tma", deflection, self._slope, optimize=True)
        aside_mm = -(self._face_mm + self._draw * height_mm)[:, :, None] * slope
        return np.concatenate([aside_mm, height_mm[:, :, None]], axis=2).reshape(len(deflection), -1)
