"""Base models: what predicts the observables before any effect is added."""

import importlib.util
import sys
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import yaml
from scipy.interpolate import PchipInterpolator

from labrig._errors import LabrigError
from labrig.effects import Rows
from labrig.effects._rows import Floats
from labrig.model._file import ModelFile, PythonBase, SimulatorBase, StaticBase, SurrogateBase
from labrig.model._surrogate import SurrogateModel

_GRID = 33
_SOLVED = 7
"""Of these many points of each chamber's range a simulator is asked; between them the curve is smooth."""
_INSIDE = ("prestretch_", "stiffening_", "core_offset", "contact_", "gravity_")
_FLATTEST = 0.15
_STEP = 1e-3
"""Step of the finite differences, fraction of a chamber's range; central, so the error is of its square."""


class BaseModel(Protocol):
    """A prediction of all observables of a run from its actuation."""

    kind: str

    def predict(self, actuation: Floats) -> Floats:
        """Predict (F, C) -> (F, K), in the units of the run."""
        ...

    def declared(self, actuation: Floats) -> Floats | None:
        """Regressors (F, D) of the parameters that the base calls its own, one set per observable, or None."""
        ...


class PythonModel:
    """A function in a file of the user's."""

    kind = "python"

    def __init__(self, spec: PythonBase, folder: Path, rows: Rows) -> None:
        self._where = f"{folder / spec.file}:{spec.function}"
        self._function = _load_function(folder / spec.file, spec.function)
        self._n_observables = len(rows.observables)

    def predict(self, actuation: Floats) -> Floats:
        """Call the user's function; raises `LabrigError` when it fails or returns another shape."""
        try:
            out = np.asarray(self._function(actuation.copy()), dtype=float)
        except Exception as error:
            raise LabrigError(f"{self._where} failed: {type(error).__name__}: {error}") from error
        if out.ndim == 1 and self._n_observables == 1:
            out = out[:, None]
        expected = (len(actuation), self._n_observables)
        if out.shape != expected:
            raise LabrigError(
                f"{self._where} returned shape {out.shape} for actuation {actuation.shape}; "
                f"the run needs {expected} (rows, observables)"
            )
        if not np.isfinite(out).all():
            raise LabrigError(f"{self._where} returned NaN or infinite values")
        return out

    def declared(self, actuation: Floats) -> Floats | None:
        """None: a plain Python base has no parameters of its own."""
        return None


class StaticModel:
    """A polynomial of the pressures for each observable, fitted to the rows by robust least squares."""

    kind = "static"

    def __init__(self, spec: StaticBase, rows: Rows) -> None:
        self._degree = spec.degree
        self._low, self._span = rows.low, rows.high - rows.low
        self.fit(rows, rows.values)

    def fit(self, rows: Rows, values: Floats) -> None:
        """Fit the map to `values` (F, K), captures counting alike; NaN are left out."""
        X = self.declared(rows.actuation)
        captures = np.bincount(rows.capture, minlength=rows.n_captures)
        weight = np.sqrt(1.0 / captures[rows.capture])
        columns = [_robust_fit(X, values[:, k], weight) for k in range(values.shape[1])]
        self._coefficients = np.stack(columns, axis=1)

    def predict(self, actuation: Floats) -> Floats:
        """Evaluate the fitted map."""
        return self.declared(actuation) @ self._coefficients

    def declared(self, actuation: Floats) -> Floats:
        """The monomials up to the degree, of each chamber's fraction of its range, (F, D)."""
        x = (actuation - self._low) / self._span
        columns = [np.ones(len(x))]
        for degree in range(1, self._degree + 1):
            for chosen in combinations_with_replacement(range(x.shape[1]), degree):
                columns.append(np.prod(x[:, chosen], axis=1))
        return np.stack(columns, axis=1)


class SimulatorModel:
    """labrig's simulator, told the rig's geometry; observables are matched by marker and axis."""

    kind = "simulator"

    def __init__(self, spec: SimulatorBase, folder: Path, rows: Rows) -> None:
        from labrig.physics import load_surface

        path = folder / spec.rig
        try:
            rig = yaml.safe_load(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise LabrigError(
                f"{path}: can't read the rig file of the simulator ({error.strerror})"
            ) from error
        except yaml.YAMLError as error:
            raise LabrigError(f"{path}: is not YAML") from error
        self._surface = load_surface(rig, path.parent)
        names = list(self._surface.marker_names)
        unknown = [m for m in rows.markers if m not in names]
        if unknown or (rows.marker < 0).any() or (rows.axis < 0).any():
            what = f"marker {unknown[0]!r}" if unknown else "an observable that is no marker coordinate"
            raise LabrigError(f"{path}: the simulator knows nothing of {what}, which the run has")
        if tuple(self._surface.chamber_names) != tuple(rows.chambers):
            raise LabrigError(f"{path}: its chambers are not the run's ({', '.join(rows.chambers)})")
        self._marker = np.array([names.index(rows.markers[m]) for m in rows.marker])
        self._axis = rows.axis

    def predict(self, actuation: Floats) -> Floats:
        """Simulate the settled surface; chamber pressures in kPa."""
        return np.asarray(self._surface.predict(actuation))[:, self._marker, self._axis]

    def declared(self, actuation: Floats) -> Floats | None:
        """None: the simulator has nothing that is fitted to a run."""
        return None

    def slope(self, actuation: Floats) -> Floats:
        """Change of the prediction per kPa, (F, K, C), as the simulator itself works it out."""
        return np.asarray(self._surface.jacobian(actuation))[:, self._marker, self._axis]

    def inside(self, actuation: Floats) -> dict[str, Floats]:
        """Change of the prediction, (F, K), by each physical parameter that an effect may stand for."""
        from labrig.physics import ShellSurface

        if not isinstance(self._surface, ShellSurface):
            return {}
        names = [n for n in self._surface.parameters if n.startswith(_INSIDE)]
        by = np.asarray(self._surface.parameter_jacobian(actuation, names))[:, self._marker, self._axis]
        return {name: by[..., i] for i, name in enumerate(names)}


def build_base(model: ModelFile, folder: Path, rows: Rows) -> BaseModel:
    """Make the base of a model ready for a run; `folder` is where the model file lies."""
    spec = model.base
    if isinstance(spec, PythonBase):
        return PythonModel(spec, folder, rows)
    if isinstance(spec, StaticBase):
        return StaticModel(spec, rows)
    if isinstance(spec, SurrogateBase):
        return SurrogateModel(folder / spec.file, rows)
    return SimulatorModel(spec, folder, rows)


def jacobian(base: BaseModel, actuation: Floats, low: Floats, high: Floats) -> Floats:
    """Change of the prediction per unit of actuation, (F, K, C), by central differences.

    Rows that share an actuation are computed once; a simulator gives its own derivative.
    """
    unique, inverse = np.unique(actuation, axis=0, return_inverse=True)
    inverse = inverse.reshape(-1)
    if isinstance(base, (SimulatorModel, SurrogateModel)):
        return base.slope(unique)[inverse]
    steps = _STEP * (high - low)
    C = len(steps)
    moved = np.concatenate([unique + sign * np.diag(steps)[c] for c in range(C) for sign in (1.0, -1.0)])
    predicted = base.predict(moved).reshape(C, 2, len(unique), -1)
    J = (predicted[:, 0] - predicted[:, 1]) / (2 * steps)[:, None, None]
    return np.moveaxis(J, 0, -1)[inverse]


@dataclass(frozen=True)
class Deflection:
    """How far each chamber alone moves the observables, as a share of its motion at full range."""

    low: Floats
    span: Floats
    curves: Floats

    def at(self, actuation: Floats) -> Floats:
        """The share at each actuation, (n, C)."""
        return self._interpolate(actuation, self.curves)

    def slope(self, actuation: Floats) -> Floats:
        """Its derivative by the fraction of the range, (n, C), kept away from zero."""
        slopes = np.gradient(self.curves, 1 / (_GRID - 1), axis=0)
        return np.maximum(self._interpolate(actuation, slopes), _FLATTEST)

    def _interpolate(self, actuation: Floats, curves: Floats) -> Floats:
        x = (actuation - self.low) / self.span
        grid = np.linspace(0, 1, _GRID)
        return np.stack([np.interp(x[:, c], grid, curves[:, c]) for c in range(x.shape[1])], axis=1)


def solo_deflection(base: BaseModel, low: Floats, high: Floats) -> Deflection:
    """Move each chamber alone over its range and see how far the observables go."""
    vented = np.clip(0.0, low, high)
    curves = np.zeros((_GRID, len(low)))
    points = _SOLVED if isinstance(base, SimulatorModel) else _GRID
    for c in range(len(low)):
        grid = np.linspace(low[c], high[c], points)
        alone = np.tile(vented, (points + 1, 1))
        alone[:-1, c] = grid
        predicted = base.predict(alone)
        moved = np.sqrt(((predicted[:-1] - predicted[-1]) ** 2).mean(axis=1)) * np.sign(grid - vented[c])
        full = np.abs(moved).max()
        share = moved / full if full > 0 else np.linspace(0, 1, points)
        curves[:, c] = PchipInterpolator(grid, share)(np.linspace(low[c], high[c], _GRID))
    return Deflection(low, high - low, curves)


def _load_function(path: Path, name: str) -> Callable[[Floats], Any]:
    if not path.is_file():
        raise LabrigError(f"{path}: the model's Python file does not exist")
    spec = importlib.util.spec_from_file_location(f"labrig_user_base_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(path.parent.resolve()))
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise LabrigError(f"{path}: can't be imported: {type(error).__name__}: {error}") from error
    finally:
        sys.path.remove(str(path.parent.resolve()))
    function = getattr(module, name, None)
    if not callable(function):
        raise LabrigError(f"{path}: has no function {name!r}")
    return function


def _robust_fit(X: Floats, y: Floats, weight: Floats) -> Floats:
    """Least squares that gives less and less weight to what is far off (Huber's psi, five rounds)."""
    seen = np.isfinite(y)
    if not seen.any():
        return np.zeros(X.shape[1])
    X, y, w = X[seen], y[seen], weight[seen]
    beta = np.linalg.lstsq(X * w[:, None], y * w, rcond=1e-10)[0]
    for _ in range(5):
        off = np.abs(y - X @ beta)
        scale = 1.4826 * np.median(off)
        if scale <= 0:
            break
        r = w * np.sqrt(np.minimum(1.0, 3.0 * scale / np.maximum(off, 1e-300)))
        beta = np.linalg.lstsq(X * r[:, None], y * r, rcond=1e-10)[0]
    return np.asarray(beta, dtype=float)
