"""A shell as the base simulator of a rig: marker positions, meshes and Jacobians for pressures."""

import json
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.physics._cache import ArrayCache, content_folder
from labrig.physics._shell import Shell, Solution, load_shell
from labrig.physics._surface import as_pressures
from labrig.physics._warm_start import LEAST_SHAPES, StartPredictor, nearest_state
from labrig.surface import grid

Node = tuple[int, ...]

MESH = (61, 81)
_STEP = 1.9
"""Distance of the nodes at which shapes are solved, kPa; between them they are linear. Not a round number: the
borders between nodes should not lie where set-points do."""
_KEPT = 256
_LONG_S, _FORMAT = 0.02, 2
"""What takes longer than so many seconds is kept on disk: a few times what reading it takes."""


class ShellSurface:
    """A rig's shell behind the same interface as `Surface`: pressures in, markers and a mesh out; no memory, no noise.

    Shapes are solved at the nodes of a lattice of pressures 1.9 kPa apart, once each, and linear around them: that is
    within some hundredths of a millimetre of a solve, thousandths on average, and derivatives by differences are those
    of the node. Negative pressures are vented ones: air cannot pull a sheet through its core.
    """

    def __init__(self, shell: Shell, marker_names: Sequence[str] = ()) -> None:
        self.shell = shell
        self.chamber_names = shell.chamber_names
        known = list(shell.marker_names)
        self.marker_names = tuple(marker_names) or shell.marker_names
        for marker in self.marker_names:
            if marker not in known:
                raise LabrigError(
                    f"rig: markers: shell '{shell.name}' has no marker '{marker}' (it has {known[0]}..{known[-1]})"
                )
        self.marker_uv: Floats = shell.marker_uv[[known.index(marker) for marker in self.marker_names]]
        self._basis = shell.spline.basis(self.marker_uv)
        self._nodes: dict[Node, tuple[Floats, ...]] = {}
        self._by: dict[tuple[Node, tuple[str, ...]], Floats] = {}
        self._solved: dict[Node, Solution] = {}
        self._places: list[Floats] = []
        self._states: list[Floats] = []
        self._predictor: StartPredictor | None = None

    @property
    def parameters(self) -> Mapping[str, float]:
        """The values of the shell's physical parameters."""
        return MappingProxyType({name: parameter.value for name, parameter in self.shell.parameters.items()})

    @cached_property
    def rest_mm(self) -> Floats:
        """Marker positions with every chamber vented, mm, (M, 3)."""
        return self.predict(np.zeros((1, len(self.chamber_names))))[0]

    @cached_property
    def normal(self) -> Floats:
        """Outward unit normals at the markers at rest, (M, 3)."""
        control = self.shell.control_rest_mm
        by_u, by_v = (self.shell.spline.evaluate(control, self.marker_uv, *d) for d in ((1, 0), (0, 1)))
        normal = np.cross(by_v, by_u)
        return normal / np.linalg.norm(normal, axis=1, keepdims=True)

    def predict(self, pressure_kpa: ArrayLike) -> Floats:
        """Marker positions, mm, (F, M, 3), for pressures (F, C), kPa; NaN in, NaN out.

        Raises `LabrigError` where there is no equilibrium.
        """
        pressure = self._checked(pressure_kpa)
        out = np.full((len(pressure), len(self.marker_names), 3), np.nan)
        for node, rows in self._with_nodes(pressure):
            at, jacobian = self._nodes[node]
            out[rows] = at + np.einsum("fc,mdc->fmd", pressure[rows] - self._pressure(node), jacobian)
        return out

    def jacobian(self, pressure_kpa: ArrayLike) -> Floats:
        """d position / d pressure, mm/kPa, (F, M, 3, C), at pressures (F, C); implicit."""
        pressure = self._checked(pressure_kpa)
        out = np.full((len(pressure), len(self.marker_names), 3, len(self.chamber_names)), np.nan)
        for node, rows in self._with_nodes(pressure):
            out[rows] = self._nodes[node][1]
        return out

    def parameter_jacobian(self, pressure_kpa: ArrayLike, names: Sequence[str]) -> Floats:
        """d position / d parameter, mm per unit of each, (F, M, 3, P), at pressures (F, C); implicit."""
        pressure = self._checked(pressure_kpa)
        out = np.full((len(pressure), len(self.marker_names), 3, len(names)), np.nan)
        for node, rows in self._by_node(pressure):
            out[rows] = self._by_parameters(node, tuple(names))
        return out

    def mesh(self, pressure_kpa: ArrayLike) -> tuple[Floats, NDArray[np.int64]]:
        """The whole surface at one set of pressures (C,), solved there: vertices mm (V, 3), triangles (T, 3), wound
        outwards.
        """
        solution = self.solve(self._checked(pressure_kpa)[0])
        uv, triangles = grid(*MESH)
        return self.shell.spline.evaluate(solution.control_mm, uv), triangles

    def solve(self, pressure_kpa: Floats) -> Solution:
        """The equilibrium at pressures (C,), from the best start there is; negative pressures are vented."""
        pressure = np.maximum(pressure_kpa, 0.0)
        place = pressure / self.shell.max_kpa
        start = (
            self._predictor(place) if self._predictor else nearest_state(place, self._places, self._states)
        )
        try:
            solution = self.shell.solve(pressure, start)
        except LabrigError:
            if start is None:
                raise
            solution = self.shell.solve(pressure)
        if len(self._places) < _KEPT:
            self._places.append(place)
            self._states.append(solution.state)
            count = len(self._places)
            if count >= LEAST_SHAPES and (
                count & (count - 1) == 0 or count % 32 == 0 or count == LEAST_SHAPES
            ):
                self._predictor = StartPredictor.fit(
                    np.array(self._places), np.array(self._states, dtype=np.float32)
                )
        return solution

    def _by_node(self, pressure: Floats) -> list[tuple[Node, NDArray[np.int64]]]:
        """The nodes nearest to pressures (F, C), each with the rows that it serves; rows with NaN have none."""
        np.maximum(pressure, 0.0, out=pressure)
        whole = np.flatnonzero(np.isfinite(pressure).all(axis=1))
        if not len(whole):
            return []
        index = np.rint(pressure[whole] / _STEP).astype(int)
        nodes, inverse = np.unique(index, axis=0, return_inverse=True)
        order = np.argsort(inverse.reshape(-1), kind="stable")
        rows = np.split(whole[order], np.flatnonzero(np.diff(inverse.reshape(-1)[order])) + 1)
        return (
            [(tuple(int(i) for i in node), some) for node, some in zip(nodes, rows, strict=True)]
            if len(nodes)
            else []
        )

    def _pressure(self, node: Node) -> Floats:
        return _STEP * np.array(node, dtype=float)

    def _with_nodes(self, pressure: Floats) -> list[tuple[Node, NDArray[np.int64]]]:
        """`_by_node`, once all the nodes are solved."""
        found = self._by_node(pressure)
        for node, _ in found:
            if node not in self._nodes:
                self._nodes[node] = self.kept(node, lambda node=node: self.markers_of(self._solution(node)))
        return found

    def _by_parameters(self, node: Node, names: tuple[str, ...]) -> Floats:
        """Slopes by parameters at a node, (M, 3, P)."""
        key = (node, names)
        if key not in self._by:
            (self._by[key],) = self.kept(
                [node, names],
                lambda: (self._at_markers(self.shell.parameter_jacobian(self._solution(node), names)),),
            )
        return self._by[key]

    def kept(self, key: Any, make: Callable[[], tuple[Floats, ...]]) -> tuple[Floats, ...]:
        """What the cache on disk holds for a JSON-like key, or what is made now, and kept if that took long."""
        found = self._cache.read(key)
        if found is not None:
            return found
        begin = time.perf_counter()
        made = make()
        if time.perf_counter() - begin > _LONG_S:
            self._cache.write(key, *made)
        return made

    @cached_property
    def _cache(self) -> ArrayCache:
        content = (_FORMAT, self.shell.content(), self.marker_names)
        return ArrayCache(content_folder("shell", self.shell.name, *content))

    def markers_of(self, solution: Solution) -> tuple[Floats, Floats]:
        """Marker positions (M, 3), mm, and their slopes by pressure (M, 3, C), mm/kPa, of a solution."""
        at = self._basis @ solution.control_mm.reshape(-1, 3)
        return at, self._at_markers(self.shell.jacobian(solution))

    def _solution(self, node: Node) -> Solution:
        if node not in self._solved:
            if len(self._solved) >= _KEPT:
                self._solved.pop(next(iter(self._solved)))
            self._solved[node] = self.solve(self._pressure(node))
        return self._solved[node]

    def _at_markers(self, by: Floats) -> Floats:
        """Derivatives of control points (n_u, n_v, 3, n) as those of the markers, (M, 3, n)."""
        return (self._basis @ by.reshape(self.shell.spline.size, -1)).reshape(len(self.marker_names), 3, -1)

    def _checked(self, pressure_kpa: ArrayLike) -> Floats:
        return as_pressures(pressure_kpa, len(self.chamber_names), f"shell {self.shell.name}")


@lru_cache(maxsize=4)
def surface_of(content: str, markers: tuple[str, ...]) -> ShellSurface:
    return ShellSurface(load_shell(json.loads(content)), markers)
