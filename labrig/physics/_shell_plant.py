"""The body of a simulated rig that has a shell: the shell on a finer mesh, with parameters of its own.

It moves as hidden effects expect: every chamber has a deflection that grows with its pressure, and the surface is a
function of all deflections. The deflection is a coordinate and no more: `d + d^3 / limit^2 = gain p`, fitted to how
far each chamber alone lifts its middle; the shape at deflections is the shell's at the pressures of that law.
"""

import logging
import shutil
import tempfile
import threading
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.physics._cache import content_folder
from labrig.physics._emulator import Emulator
from labrig.physics._shell import Shell
from labrig.physics._shell_rig import rig_shell
from labrig.physics._shell_surface import MESH, ShellSurface
from labrig.physics._simulate import simulate
from labrig.physics._simulations import Simulations, open_simulations
from labrig.surface import grid

_LOG = logging.getLogger("labrig.physics")
_COUNT, _SHAPES, _SPREAD = (34, 34), 240, 0.15
_QUICK = 20
"""Control points per direction of the quick stand-in: where it matters it is corrected by solved shapes."""
_BEYOND = 1.12
"""How far over its highest pressure a chamber may be pushed by what is hidden in the rig."""
_FORMAT = 1
_NOT_DRAWN = ("gravity", "contact", "adhesion")
_VARY = {"all": "", "materials": ("modulus", "thickness", "seam")}
"""Parameters that are drawn, by how they begin. Nothing among the materials has a name as an effect."""


def plant_shell(rig: dict[str, Any], folder: Path | None = None) -> Shell:
    """The shell that a simulated rig really is, from `simulated.plant` of its content.

    `plant: {count: [34, 34], seed: 0, spread: 0.15, vary: all, parameters: {...}}`: the mesh, and by how much which
    parameters are off from the model's (relative, drawn with the seed), but for those that are given. A rig that names
    no shell has the mannequin with other materials. Raises `LabrigError`.
    """
    model = rig_shell(rig, folder)
    setting = plant_setting(rig)
    random = np.random.default_rng([int(setting["seed"]), 77])
    values: dict[str, float] = {}
    for name, parameter in model.parameters.items():
        off = float(np.clip(random.normal(), -1.8, 1.8)) * float(setting["spread"])
        if name.startswith(_NOT_DRAWN) or not name.startswith(_VARY[setting["vary"]]):
            continue
        if name.startswith("prestretch"):
            drawn = 1.0 + (parameter.value - 1.0) * (1.0 + 2.0 * off)
        elif name == "core_offset_mm":
            drawn = parameter.value + 10.0 * off
        elif name.startswith("share"):
            drawn = parameter.value * (1.0 - abs(off))
        else:
            drawn = parameter.value * (1.0 + off)
        values[name] = float(np.clip(drawn, parameter.low, parameter.high))
    values.update({name: float(value) for name, value in setting["parameters"].items()})
    n_u, n_v = setting["count"]
    return model.changed(count=(int(n_u), int(n_v)), **values)


def plant_setting(rig: dict[str, Any]) -> dict[str, Any]:
    """`simulated.plant` of a rig's content with every default; raises `LabrigError` for what does not belong there."""
    simulated = rig.get("simulated") or {}
    given = simulated.get("plant") or {}
    default = {
        "count": _COUNT, "seed": simulated.get("seed", 0), "spread": _SPREAD, "vary": "all", "shapes": _SHAPES,
        "parameters": {},
    }  # fmt: skip
    if "shell" not in simulated:
        default |= {"seed": 0, "vary": "materials"}
    if not isinstance(given, Mapping) or (unknown := sorted(set(given) - set(default))):
        what = "not a mapping" if not isinstance(given, Mapping) else f"there is no '{unknown[0]}'"
        raise LabrigError(f"rig: simulated.plant: {what} (it has {', '.join(default)})")
    setting = {**default, **given}
    try:
        n_u, n_v = (int(n) for n in setting["count"])
        fits = n_u > 5 and n_v > 5 and 0.0 <= float(setting["spread"]) <= 0.3 and int(setting["shapes"]) >= 16
        fits = fits and setting["vary"] in _VARY
        fits = fits and all(isinstance(value, (int, float)) for value in setting["parameters"].values())
    except (TypeError, ValueError, AttributeError):
        fits = False
    if not fits:
        raise LabrigError(
            "rig: simulated.plant: count: [34, 34], spread: 0 to 0.3, vary: all or materials, shapes: at least 16 "
            "and parameters: {name: number} are needed"
        )
    return setting


class ShellBody:
    """What is inflated behind a simulated rig: quick shapes for streams, solved ones where it matters."""

    tangential = 0.0

    def __init__(self, shell: Shell, marker_names: tuple[str, ...] = (), shapes: int = _SHAPES) -> None:
        self._exact = ShellSurface(shell, marker_names)
        self.shell = shell
        self.chamber_names = shell.chamber_names
        self.marker_names = self._exact.marker_names
        self._shapes = shapes
        self._lock = threading.Lock()
        self._held: dict[bytes, tuple[Floats, ...]] = {}
        self._lacks: dict[bytes, tuple[Floats, ...]] = {}

    @property
    def rest_mm(self) -> Floats:
        """Marker positions with every chamber vented, mm, (M, 3); solved."""
        return self._rest_mm

    @cached_property
    def _rest_mm(self) -> Floats:
        return self._at_hold(np.zeros(len(self.chamber_names)))[1][0]

    @property
    def normal(self) -> Floats:
        """Outward unit normals at the markers at rest, (M, 3)."""
        return self._exact.normal

    @property
    def compliance_mm_per_kpa(self) -> Floats:
        """Deflection per pressure at rest, (C,)."""
        return self._law[0]

    @property
    def limit_mm(self) -> Floats:
        """Deflection at which the cubic stiffness of a chamber equals its linear one, (C,)."""
        return self._law[1]

    @property
    def weight(self) -> Floats:
        """Normal displacement of each marker per mm of deflection of each chamber alone, on the way, (M, C)."""
        return self._weight

    @cached_property
    def _weight(self) -> Floats:
        half = np.diag(0.5 * self.shell.max_kpa)
        moved = self.shape_mm(self.deflection_mm(half)) - self.shape_mm(np.zeros((1, len(half))))
        return np.einsum("cmd,md->mc", moved, self.normal) / np.diag(self.deflection_mm(half))

    def deflection_mm(self, pressure_kpa: ArrayLike) -> Floats:
        """Deflection of each chamber, mm, same shape as the pressures (..., C)."""
        gain, limit = self._law
        load = gain * np.asarray(pressure_kpa, dtype=float)
        scale = 2.0 * limit / np.sqrt(3.0)
        return scale * np.sinh(np.arcsinh(1.5 * np.sqrt(3.0) * load / limit) / 3.0)

    def pressure_kpa(self, deflection_mm: Floats) -> Floats:
        """The pressures (..., C) that give deflections, within what a shell can be asked for."""
        gain, limit = self._law
        pressure = (deflection_mm + deflection_mm**3 / limit**2) / gain
        return np.clip(pressure, 0.0, _BEYOND * self.shell.max_kpa)

    def shape_mm(self, deflection_mm: Floats) -> Floats:
        """Marker positions for deflections (F, C): (F, M, 3), mm; by the quick stand-in."""
        places = self._place(self.pressure_kpa(np.atleast_2d(deflection_mm)))
        return self._emulator(places).reshape(len(places), -1, 3)

    def correction_mm(self, pressure_kpa: Floats, deflection_mm: Floats) -> Floats:
        """What the stand-in lacks, (F, M, 3) mm, at deflections (F, C) near those that pressures (C,) hold: from the
        shape and its slopes solved there, once.
        """
        held, offset, slope = self._lacking(pressure_kpa)
        moved = self.pressure_kpa(deflection_mm) - held
        return offset + np.einsum("fc,mdc->fmd", moved, slope)

    def _lacking(self, pressure_kpa: Floats) -> tuple[Floats, ...]:
        """What the stand-in lacks at pressures (C,), (M, 3) mm, and of its slopes, (M, 3, C) mm/kPa; kept."""
        held, (at, slope) = self._at_hold(pressure_kpa)
        key = held.tobytes()
        if key not in self._lacks:
            step = 0.02 * self.shell.max_kpa
            nearby = np.concatenate([held[None], held + np.diag(step), held - np.diag(step)])
            quick = self._emulator(self._place(nearby)).reshape(len(nearby), -1, 3)
            up, down = np.split(quick[1:], 2)
            slope_quick = (up - down) / (2.0 * step)[:, None, None]
            self._lacks[key] = held, at - quick[0], slope - np.moveaxis(slope_quick, 0, -1)
        return self._lacks[key]

    def prepare(self, pressure_kpa: Floats) -> None:
        """Solve what `correction_mm` needs at pressures (C,) ahead of time; may be called from another thread."""
        self._at_hold(pressure_kpa)

    def _at_hold(self, pressure_kpa: Floats) -> tuple[Floats, tuple[Floats, ...]]:
        """Pressures within what can be solved, and the markers and their slopes there."""
        held = np.clip(pressure_kpa, 0.0, _BEYOND * self.shell.max_kpa)
        key = held.tobytes()
        with self._lock:
            if key not in self._held:
                self._held[key] = self._exact.kept(
                    held.tolist(), lambda: self._exact.markers_of(self._exact.solve(held))
                )
        return held, self._held[key]

    def solved_mm(self, pressure_kpa: Floats) -> Floats:
        """Marker positions (M, 3), mm, solved at pressures (C,)."""
        with self._lock:
            solution = self._exact.solve(pressure_kpa)
        return self.shell.spline.evaluate(solution.control_mm, self._exact.marker_uv)

    def mesh_at(self, deflection_mm: Floats) -> Floats:
        """Mesh vertices, mm, (V, 3), for chamber deflections (C,); solved."""
        pressure = self.pressure_kpa(np.asarray(deflection_mm, dtype=float))
        with self._lock:
            solution = self._exact.solve(pressure)
        return self.shell.spline.evaluate(solution.control_mm, grid(*MESH)[0])

    @property
    def triangles(self) -> NDArray[np.int64]:
        """Triangles of the mesh, (T, 3) vertex indices, wound so that normals point outwards."""
        return self._triangles

    @cached_property
    def _triangles(self) -> NDArray[np.int64]:
        return grid(*MESH)[1]

    @cached_property
    def _sims(self) -> Simulations:
        count = (min(n, _QUICK) for n in self.shell.spline.count)
        quick = self.shell.changed(count=tuple(count))  # type: ignore[arg-type]
        content = quick.content()
        for chamber, most in zip(content["chambers"], quick.max_kpa, strict=True):
            chamber["max"] = float(_BEYOND * most)
        return _cached(content, self._shapes)

    @cached_property
    def _law(self) -> tuple[Floats, ...]:
        """Gain, mm/kPa, and limit, mm, of each chamber, (C,): fitted to how far it alone lifts its middle."""
        return self._exact.kept("law", self._fitted_law)

    def _fitted_law(self) -> tuple[Floats, Floats]:
        from labrig.physics._samples import LEVELS, inflation_curve

        gains, limits = [], []
        for chamber in range(len(self.chamber_names)):
            rise = inflation_curve((self._sims.shell, chamber))[1:]
            pressure = LEVELS[1:] * _BEYOND * self.shell.max_kpa[chamber]
            # gain p = d + d^3 / limit^2 is linear in 1 / gain and 1 / (gain limit^2)
            columns = np.stack([rise, rise**3], axis=1) / pressure[:, None]
            stiff, cubic = np.linalg.lstsq(columns, np.ones(len(rise)), rcond=None)[0]
            start = rise[0] / pressure[0]
            stiff = stiff if stiff > 0 else 1.0 / start
            cubic = max(cubic, stiff / (5.0 * rise[-1]) ** 2)
            gains.append(1.0 / stiff)
            limits.append(np.sqrt(stiff / cubic))
        return np.array(gains), np.array(limits)

    @cached_property
    def _emulator(self) -> Emulator:
        sims = self._sims
        good = sims.converged
        basis = sims.spline.basis(self._exact.marker_uv)
        control, jacobian = sims.control_mm[good], sims.jacobian
        assert jacobian is not None
        values = np.stack([basis @ c.reshape(-1, 3) for c in control]).reshape(len(control), -1)
        slopes = np.stack([basis @ j.reshape(sims.spline.size, -1) for j in jacobian[good].astype(float)])
        slopes = slopes.reshape(*values.shape, -1)
        pressure = sims.pressure_kpa[good]
        step = 1e-3 * self.shell.max_kpa
        by_place = (self._place(pressure + step) - self._place(pressure - step)) / (2 * step)
        return Emulator.fit(self._place(pressure), values, slopes / by_place[:, None, :])

    def _place(self, pressure_kpa: Floats) -> Floats:
        """Deflections over those at the highest pressures: where the surface changes evenly."""
        return self.deflection_mm(pressure_kpa) / self.deflection_mm(self.shell.max_kpa)


def load_body(rig: dict[str, Any], folder: Path | None = None) -> ShellBody:
    """The body behind a simulated rig whose simulator is a shell; raises `LabrigError`."""
    markers = tuple(str(marker) for marker in rig.get("markers") or [])
    return ShellBody(plant_shell(rig, folder), markers, int(plant_setting(rig)["shapes"]))


def _cached(content: dict[str, Any], shapes: int) -> Simulations:
    """Simulations of a shell from the cache, or made now and kept there."""
    folder = content_folder("plant", content["name"], _FORMAT, shapes, content)
    if folder.is_dir():
        try:
            return open_simulations(folder)
        except LabrigError:
            shutil.rmtree(folder, ignore_errors=True)
    from labrig.physics._shell import load_shell

    _LOG.warning("labrig: solving %d shapes of shell %s for the simulated rig, once", shapes, content["name"])
    with _making(folder.parent) as making:
        made = simulate(load_shell(content), Path(making) / "set", shapes, jacobians=True, workers=1)
        try:
            (Path(making) / "set").replace(folder)
        except OSError:  # another process was quicker, or nothing can be kept
            _LOG.debug("labrig: %s is there already, or cannot be written", folder)
    return made


def _making(beside: Path) -> tempfile.TemporaryDirectory:
    """A folder to make something in: beside where it will lie, or anywhere if nothing can be written there."""
    try:
        beside.mkdir(parents=True, exist_ok=True)
        return tempfile.TemporaryDirectory(dir=beside, prefix=".making-")
    except OSError:
        return tempfile.TemporaryDirectory()
