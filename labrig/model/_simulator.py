"""The simulator of a rig as a base, with those of its physical parameters that each run says anew."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.effects import Rows, ends
from labrig.model._deflection import GRID
from labrig.model._file import SimulatorBase
from labrig.model._kpa import in_kpa
from labrig.model._robust import robust_fit

if TYPE_CHECKING:
    from labrig.physics import ShellSurface

_SOLVED = np.array([0.0, 0.15, 0.5, 1.0])
"""Where on a chamber's way up a simulator is asked for its shape and slope: a sheet that lifts off moves most at first.
Between these the curve is a cubic."""
_INSIDE = ("prestretch_", "stiffening_", "core_offset", "contact_", "gravity_")
_VENTED_KPA = -1.0
"""Down to this a chamber is taken for vented: what the zero of a sensor may be off by, where a run has no other."""
_UNIT = 0.1
"""Calibrated parameters are counted in such a part of their value, or of their bounds' distance where that is zero."""


class SimulatorModel:
    """labrig's simulator, told the rig's geometry; observables are matched by marker and axis, chambers by name.

    What its `calibrated` parameters change is taken as linear. `known` are the lowest and the highest pressures of its
    shell, (C,) each, in the run's unit; None for a reduced surface, which has no range.
    """

    kind = "simulator"

    def __init__(self, spec: SimulatorBase, folder: Path, rows: Rows) -> None:
        from labrig.physics import load_surface, of_rig_file, read_rig_file

        path = folder / spec.rig
        with of_rig_file(path):
            self._surface = load_surface(read_rig_file(path), path.parent, spec.parameters)
        names = list(self._surface.marker_names)
        unknown = [m for m in rows.markers if m not in names]
        if unknown or (rows.marker < 0).any() or (rows.axis < 0).any():
            what = f"marker {unknown[0]!r}" if unknown else "an observable that is no marker coordinate"
            raise LabrigError(f"{path}: the simulator knows nothing of {what}, which the run has")
        have = tuple(self._surface.chamber_names)
        if sorted(have) != sorted(rows.chambers):
            raise LabrigError(
                f"{path}: its chambers ({', '.join(have)}) are not the run's ({', '.join(rows.chambers)})"
            )
        self._chambers, self._order = rows.chambers, [rows.chambers.index(name) for name in have]
        self._path, self._unit, self._kpa = path, rows.actuation_unit, in_kpa(rows, path)
        self.known: tuple[Floats, Floats] | None = None
        if self._surface.parameters:
            own = [have.index(name) for name in rows.chambers]
            highest = self._shell_surface().shell.max_kpa[own] / self._kpa
            self.known = np.zeros_like(highest), highest
        self._marker = np.array([names.index(rows.markers[m]) for m in rows.marker])
        self._axis = rows.axis
        self._calibrated = tuple(dict.fromkeys(spec.calibrated))
        for name in self._calibrated:
            if name not in self._surface.parameters:
                known = ", ".join(self._surface.parameters) or "none"
                raise LabrigError(
                    f"base: calibrated: the simulator of {path} has no parameter {name!r} (it has {known})"
                )
        self._off = np.zeros(len(self._calibrated))

    def fit(self, rows: Rows, values: Floats) -> None:
        """Fit the calibrated parameters to `values` (F, K), captures counting alike; NaN are left out."""
        fields = self.calibrated(rows.actuation)
        if fields is None:
            return
        weight = np.sqrt(1.0 / np.bincount(rows.capture)[rows.capture])
        left = values - self.simulate(rows.actuation)
        each = np.repeat(weight, values.shape[1])
        self._off = robust_fit(fields.reshape(left.size, -1), left.ravel(), each)

    @property
    def values(self) -> dict[str, float]:
        """The calibrated parameters as they were fitted, by name, in their own units."""
        known, units = self._surface.parameters, self._units()
        return {
            name: float(known[name] + off * unit)
            for name, off, unit in zip(self._calibrated, self._off, units, strict=True)
        }

    def predict(self, actuation: Floats) -> Floats:
        """The settled surface with the calibrated parameters as they were fitted."""
        predicted = self.simulate(actuation)
        if not self._off.any():
            return predicted
        fields = self.calibrated(actuation)
        assert fields is not None
        return predicted + fields @ self._off

    def simulate(self, actuation: Floats) -> Floats:
        """The settled surface as the simulator has it; raises `LabrigError` for a vacuum under a shell, and NaN."""
        return np.asarray(self._surface.predict(self._in_kpa(actuation)))[:, self._marker, self._axis]

    def _in_kpa(self, actuation: Floats) -> Floats:
        """Pressures in kPa, (F, C), in the order of the simulator's chambers."""
        kpa = self._kpa * actuation
        if self.known is not None and not (kpa >= _VENTED_KPA).all():
            row, chamber = np.argwhere(~(kpa >= _VENTED_KPA))[0]
            raise LabrigError(
                f"{self._path}: its shell knows no vacuum, and chamber {self._chambers[chamber]} is at "
                f"{actuation[row, chamber]:.4g} {self._unit}"
            )
        return kpa[:, self._order]

    def declared(self, actuation: Floats) -> Floats | None:
        """None: nothing is fitted to each observable of a run on its own."""
        return None

    def calibrated(self, actuation: Floats) -> Floats | None:
        """Change of the prediction, (F, K, D), by each calibrated parameter, in tenths of its value; or None."""
        if not self._calibrated:
            return None
        unique, inverse = np.unique(actuation, axis=0, return_inverse=True)
        return (self._by(unique, self._calibrated) * self._units())[inverse.reshape(-1)]

    def slope(self, actuation: Floats) -> Floats:
        """Change of the prediction per unit of the run's actuation, (F, K, C), as the simulator itself works it out."""
        by_kpa = np.asarray(self._surface.jacobian(self._in_kpa(actuation)))[:, self._marker, self._axis]
        result = np.empty_like(by_kpa)
        result[..., self._order] = by_kpa
        return self._kpa * result

    def inside(self, actuation: Floats) -> dict[str, Floats]:
        """Change of the prediction, (F, K), by each physical parameter that an effect may stand for."""
        names = [n for n in self._surface.parameters if n.startswith(_INSIDE)]
        if not names:
            return {}
        by = self._by(actuation, tuple(names))
        return {name: by[..., i] for i, name in enumerate(names)}

    def _shell_surface(self) -> "ShellSurface":
        from labrig.physics import ShellSurface  # waits for a compiler

        assert isinstance(self._surface, ShellSurface)  # nothing else has parameters
        return self._surface

    def _by(self, actuation: Floats, names: tuple[str, ...]) -> Floats:
        by = self._shell_surface().parameter_jacobian(self._in_kpa(actuation), names)
        return np.asarray(by)[:, self._marker, self._axis]

    def _units(self) -> Floats:
        if not self._calibrated:
            return np.zeros(0)
        own = [self._shell_surface().shell.parameters[name] for name in self._calibrated]
        return np.array([_UNIT * (abs(p.value) or p.high - p.low) for p in own])


def solved_curves(base: SimulatorModel, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """How far each chamber alone moves the observables over its range, from few shapes, which take long.

    As a share of the most, (GRID, C), and the mean size of the slopes on the way, (K, C).
    """
    vented, (origin, span) = np.clip(0.0, low, high), ends(low, high)
    empty = (vented - origin) / span
    curves = np.zeros((GRID, len(low)))
    reach = []
    for c in range(len(low)):
        few = np.unique([0.0, *(empty[c] + _SOLVED * (1 - empty[c]))])
        alone = np.tile(vented, (len(few) + 1, 1))
        alone[:-1, c] = origin[c] + few * span[c]
        predicted, slope = base.simulate(alone), base.slope(alone[:-1])[..., c] * span[c]
        change = predicted[:-1] - predicted[-1]
        size = np.sqrt((change**2).mean(axis=1))
        still = size <= 1e-9 * max(size.max(), 1e-300)
        along = (change * slope).mean(axis=1) / np.where(still, 1.0, size)
        sign = np.sign(few - empty[c])
        steep = np.where(still, np.sqrt((slope**2).mean(axis=1)), along * sign)
        moved = CubicHermiteSpline(few, size * sign, steep)(np.linspace(0, 1, GRID))
        full = np.abs(moved).max()
        curves[:, c] = moved / full if full > 0 else np.linspace(0, 1, GRID)
        reach.append(np.abs(np.diff(predicted[:-1], axis=0)).sum(axis=0) / (high[c] - low[c]))
    return curves, np.stack(reach, axis=1)
