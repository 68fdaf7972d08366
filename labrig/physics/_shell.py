"""Shells: what a pressure does to an inflated surface, solved as an equilibrium of energies."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.physics._quadrature import Quadrature, gauss_places, make_quadrature
from labrig.physics._shell_file import ShellFile, read_shell
from labrig.physics._shell_parameters import ShellParameter, read_parameters, with_parameters
from labrig.physics._shell_solve import TOLERANCE, minimise, reference_force, respond
from labrig.physics._shell_system import History, System, soft_range
from labrig.physics._threads import one_thread
from labrig.surface import Spline

_LEAST_WEIGHT = 1e-3
"""The largest part of its air that bears on a quadrature point, of a chamber that the mesh can still see."""


@dataclass(frozen=True)
class Solution:
    """An equilibrium of a shell.

    `pressure_kpa` (C,); `layers_mm` (L, n_u, n_v, 3) control points from the core outwards; `state` (D,) what a
    later solve can start from; `residual` unbalanced over applied force; `iterations`; `energies_mj` on the way.
    """

    pressure_kpa: Floats
    layers_mm: Floats
    state: Floats
    residual: float
    iterations: int
    energies_mj: tuple[float, ...]

    @property
    def control_mm(self) -> Floats:
        """Control points of the outermost layer, (n_u, n_v, 3), mm."""
        return self.layers_mm[-1]


class Shell:
    """An inflated surface: one or two sheets over a solid core, with chambers of air.

    Made by `load_shell`. `solve` is deterministic: the same call gives the same bits on the same machine.
    """

    def __init__(self, file: ShellFile, history: History | None = None) -> None:
        self.file = file
        self.name = file.name
        self.chamber_names = tuple(chamber.name for chamber in file.chambers)
        self.max_kpa: Floats = np.array([chamber.max for chamber in file.chambers])
        self.spline = Spline(file.control_points, file.degree)
        self.marker_names = tuple(file.marker_places)
        self.marker_uv: Floats = np.array(list(file.marker_places.values())).reshape(-1, 2)
        self.parameters: Mapping[str, ShellParameter] = MappingProxyType(read_parameters(file))
        self._given_history = history
        self._check_chambers()

    def _check_chambers(self) -> None:
        """Raise `LabrigError` for a chamber between the mesh's quadrature points: its air would do nothing."""
        across = [gauss_places(self.spline, axis) for axis in (0, 1)]
        for chamber in self.file.chambers:
            for name, x, limits in (("u", across[0], chamber.u), ("v", across[1], chamber.v)):
                if soft_range(x, limits, chamber.edge).max() < _LEAST_WEIGHT:
                    raise LabrigError(
                        f"shell {self.name}: chamber {chamber.name}: {name} from {limits[0]:g} to {limits[1]:g} is "
                        f"narrower than a mesh of {self.file.control_points} control points can see: make it wider, or "
                        "take more of them"
                    )

    def __repr__(self) -> str:
        return f"Shell({self.name!r}, {self.spline.count[0]} x {self.spline.count[1]} control points)"

    def __reduce__(self) -> tuple:
        return Shell, (self.file, self._given_history)

    @cached_property
    def quadrature(self) -> Quadrature:
        """Where the energy is summed; history fields lie on its points."""
        rings = 2 if self.file.border == "clamped" else 1
        return make_quadrature(self.spline, self.file.core.points_mm, rings, self.name)

    @cached_property
    def _system(self) -> System:
        points, layers = len(self.quadrature.uv), len(self.file.layers)
        history = self._given_history or History.new(points, layers)
        values = {name: parameter.value for name, parameter in self.parameters.items()}
        return System(self.quadrature, self.file, values, history.checked(points, layers, self.name))

    @property
    def control_rest_mm(self) -> Floats:
        """Control points of the resting surface, before any load, (n_u, n_v, 3), mm."""
        return self.quadrature.control_mm.reshape(*self.spline.count, 3)

    @property
    def coordinates(self) -> int:
        """Length D of the state of a solution."""
        return self._system.size

    @property
    def patch_area_mm2(self) -> Floats:
        """Area at each quadrature point on which each chamber's air bears, (Q, C), mm^2."""
        return self._system.patch * self.quadrature.area_mm2[:, None]

    @property
    def history(self) -> History:
        """What the shell remembers."""
        return self._system.history

    def content(self) -> dict[str, Any]:
        """The content of a shell file that makes this shell again (without its history)."""
        return self.file.content()

    def changed(self, count: tuple[int, int] | None = None, **parameters: float) -> "Shell":
        """The same shell on another number of control points, or with other values of its parameters.

        The history is forgotten. Raises `LabrigError` for a parameter that it does not have, or a bad value.
        """
        content = with_parameters(self.file.content(), self.file, parameters)
        if count is not None:
            content["control_points"] = list(count)
        return Shell(read_shell(content))

    def remembering(self, eigenstrain: ArrayLike | None = None, damage: ArrayLike | None = None) -> "Shell":
        """The same shell with a history: see `History`; what is None is as new."""
        new = History.new(len(self.quadrature.uv), len(self.file.layers))
        history = History(
            new.eigenstrain if eigenstrain is None else np.asarray(eigenstrain, dtype=float),
            new.damage if damage is None else np.asarray(damage, dtype=float),
        )
        shell = Shell(self.file, history)
        shell.__dict__["quadrature"] = self.quadrature
        return shell

    def solve(self, pressure_kpa: ArrayLike, start: "Solution | Floats | None" = None) -> Solution:
        """The equilibrium at chamber pressures (C,), kPa, sought from `start` (another solution, or a state).

        Raises `LabrigError` for pressures that are negative or not finite, and if no equilibrium is found.
        """
        pressure = self._checked(pressure_kpa)
        system = self._system
        first = self._start(start)
        field = system.field(pressure)
        with one_thread():
            scale = reference_force(system, pressure, self.max_kpa)
            found = minimise(system, field, first, TOLERANCE * scale, scale)
        residual = found.force / scale
        if not residual <= TOLERANCE:
            raise LabrigError(
                f"shell {self.name}: no equilibrium at {self._named(pressure)}: after {found.steps} steps the "
                f"unbalanced force is {residual:.1e} of the air's, {TOLERANCE:.0e} is allowed"
            )
        return Solution(
            pressure, self._layers_mm(found.x), found.x, residual, found.steps,
            tuple(energy * 1e-3 for energy in found.energies),
        )  # fmt: skip

    def jacobian(self, solution: Solution) -> Floats:
        """How the outermost layer's control points move with pressure, (n_u, n_v, 3, C), mm/kPa; implicit."""
        return self._moved(solution, self._system.push(solution.state))

    def parameter_jacobian(self, solution: Solution, names: Sequence[str]) -> Floats:
        """How they move with parameters, (n_u, n_v, 3, P), mm per unit of each; implicit.

        Raises `LabrigError` for a parameter that the shell does not have.
        """
        field = self._system.field(solution.pressure_kpa)
        loads = []
        for name in names:
            if name not in self.parameters:
                known = ", ".join(self.parameters)
                raise LabrigError(f"shell {self.name}: there is no parameter '{name}' (it has {known})")
            parameter = self.parameters[name]
            step = 1e-5 * max(abs(parameter.value), 0.1 * (parameter.high - parameter.low), 1e-9)
            down, up = (self._system.with_values(**{name: parameter.value + s}) for s in (-step, step))
            fields = (
                (s.field(solution.pressure_kpa) for s in (down, up))
                if name.startswith("share_")
                else (field,) * 2
            )
            low, high = (s.energy(solution.state, f)[1] for s, f in zip((down, up), fields, strict=True))
            loads.append((low - high) / (2.0 * step))
        return self._moved(solution, np.stack(loads, axis=1))

    def _moved(self, solution: Solution, loads: Floats) -> Floats:
        system = self._system
        with one_thread():
            moved = respond(system, solution.state, system.field(solution.pressure_kpa), loads)
        out = np.zeros((self.spline.size, 3, loads.shape[1]))
        out[self.quadrature.moving] = moved.reshape(-1, system.n_layers, 3, loads.shape[1])[:, -1]
        return out.reshape(*self.spline.count, 3, -1)

    def _layers_mm(self, x: Floats) -> Floats:
        layers = np.repeat(self.quadrature.control_mm[None], self._system.n_layers, axis=0)
        layers[:, self.quadrature.moving] += x.reshape(-1, self._system.n_layers, 3).swapaxes(0, 1)
        return layers.reshape(-1, *self.spline.count, 3)

    def _checked(self, pressure_kpa: ArrayLike) -> Floats:
        pressure = np.array(pressure_kpa, dtype=float)
        if pressure.shape != (len(self.chamber_names),):
            raise LabrigError(
                f"shell {self.name}: pressures of shape {pressure.shape} given, ({len(self.chamber_names)},) needed"
            )
        if not (np.isfinite(pressure).all() and (pressure >= 0.0).all()):
            raise LabrigError(
                f"shell {self.name}: pressures must be finite and >= 0: {self._named(pressure)}"
            )
        return pressure

    def _named(self, pressure: Floats) -> str:
        return (
            ", ".join(f"{name} {p:.4g}" for name, p in zip(self.chamber_names, pressure, strict=True))
            + " kPa"
        )

    def _start(self, start: "Solution | Floats | None") -> Floats:
        state = start.state if isinstance(start, Solution) else start
        if state is None:
            return np.zeros(self._system.size)
        state = np.asarray(state, dtype=float)
        if state.shape != (self._system.size,) or not np.isfinite(state).all():
            raise LabrigError(
                f"shell {self.name}: the start of a solve has {state.size} finite coordinates where the shell has "
                f"{self._system.size}: is it of another mesh?"
            )
        return state


def load_shell(source: str | Path | dict[str, Any]) -> Shell:
    """A shell from the name of a shipped one (`mannequin`, `membrane4`), a YAML file, or the content of one.

    Raises `LabrigError` naming the file, the field and what is wrong with it.
    """
    return Shell(read_shell(source))


__all__ = ["Shell", "Solution", "load_shell"]
