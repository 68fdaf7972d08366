"""Simulators as shape models, and what a model file on the command line stands for."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from labrig.arrays import Floats

if TYPE_CHECKING:
    from labrig.physics import Shell, Solution, Surface


_KEPT = 64
_INSIDE = ("prestretch_", "stiffening_", "core_offset", "contact_", "gravity_")
"""Parameters of a shell that effects of a model file stand for."""


class ShellModel:
    """A shell simulator as a shape model: every evaluation is an equilibrium, begun at the last one's.

    Limits (C,), kPa, are from vented to what the shell is for where none are given.
    """

    def __init__(self, shell: "Shell", low_kpa: Floats | None = None, high_kpa: Floats | None = None) -> None:
        self.shell = shell
        self.chamber_names = shell.chamber_names
        self.marker_names, self.marker_uv = shell.marker_names, shell.marker_uv
        self.low_kpa = np.zeros(len(shell.max_kpa)) if low_kpa is None else low_kpa
        self.high_kpa = shell.max_kpa if high_kpa is None else high_kpa
        self._last: Solution | None = None
        self._kept: dict[bytes, Solution] = {}

    def points_and_jacobian(self, pressure_kpa: Floats, uv: Floats) -> tuple[Floats, Floats]:
        """Points (P, 3) and derivatives (P, 3, C) of one equilibrium."""
        solution = self._solve(pressure_kpa)
        basis = self.shell.spline.basis(uv)
        moved = basis @ self.shell.jacobian(solution).reshape(self.shell.spline.size, -1)
        points = basis @ solution.control_mm.reshape(-1, 3)
        return points, moved.reshape(len(points), 3, -1)

    def points(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """Points (F, P, 3), mm."""
        solved = [self._solve(p).control_mm for p in np.atleast_2d(np.asarray(pressure_kpa, float))]
        return self.shell.spline.evaluate(np.array(solved), uv)

    def jacobian(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """Their derivatives (F, P, 3, C), mm/kPa."""
        rows = np.atleast_2d(np.asarray(pressure_kpa, float))
        return np.array([self.points_and_jacobian(p, np.asarray(uv, float))[1] for p in rows])

    def inside(self, pressure_kpa: Floats) -> dict[str, Floats]:
        """Change of the markers, (F, 3 M), mm, by each physical parameter that an effect may stand for."""
        names = [name for name in self.shell.parameters if name.startswith(_INSIDE)]
        basis = self.shell.spline.basis(self.marker_uv)
        rows = []
        for pressure in pressure_kpa:
            moved = self.shell.parameter_jacobian(self._solve(pressure), names)
            rows.append((basis @ moved.reshape(self.shell.spline.size, -1)).reshape(-1, len(names)))
        by = np.array(rows)
        return {name: by[..., number] for number, name in enumerate(names)}

    def _solve(self, pressure_kpa: Floats) -> "Solution":
        from labrig._errors import LabrigError

        pressure = np.asarray(pressure_kpa, float)
        key = pressure.tobytes()
        if key not in self._kept:
            while len(self._kept) >= _KEPT:
                self._kept.pop(next(iter(self._kept)))
            try:
                self._last = self.shell.solve(pressure, self._last)
            except LabrigError:
                self._last = self.shell.solve(pressure)  # the last equilibrium was too far away
            self._kept[key] = self._last
        return self._kept[key]


class SurfaceModel:
    """A quick surface of a simulated rig as a shape model; limits (C,) or of all chambers, kPa."""

    def __init__(self, surface: "Surface", high_kpa: ArrayLike = 60.0, low_kpa: ArrayLike = 0.0) -> None:
        self.surface = surface
        self.chamber_names = surface.chamber_names
        self.marker_names, self.marker_uv = surface.marker_names, surface.marker_uv
        chambers = len(surface.chamber_names)
        self.low_kpa = np.broadcast_to(np.asarray(low_kpa, float), chambers).copy()
        self.high_kpa = np.broadcast_to(np.asarray(high_kpa, float), chambers).copy()
        self._kept: tuple[Floats, Surface] | None = None

    def points(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """Points (F, P, 3), mm."""
        return self._at(uv).predict(pressure_kpa)

    def jacobian(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """Their derivatives (F, P, 3, C), mm/kPa."""
        return self._at(uv).jacobian(pressure_kpa)

    def _at(self, uv: ArrayLike) -> "Surface":
        """The surface with its markers at `uv`: its predictions are those of the points there."""
        places = np.asarray(uv, float)
        if self._kept is None or not np.array_equal(self._kept[0], places):
            self._kept = (places, self.surface.at(places))
        return self._kept[1]
