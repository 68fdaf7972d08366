"""Base models: what predicts the observables before any effect is added."""

from copy import copy
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from labrig._errors import LabrigError
from labrig._own_code import FAULTS
from labrig.arrays import Floats
from labrig.effects import MOST_SESSIONS, Rows, ends
from labrig.model._deflection import GRID, Deflection
from labrig.model._file import (
    FmuBase,
    ModelFile,
    OdeBase,
    PythonBase,
    StaticBase,
    SurrogateBase,
    TableBase,
)
from labrig.model._memory import MemoryModel
from labrig.model._memory_kinds import FmuModel, OdeModel, RecordModel, StepModel, memory_of
from labrig.model._python import function_of, place_of
from labrig.model._robust import robust_fit
from labrig.model._simulator import SimulatorModel, solved_curves
from labrig.model._surrogate import SurrogateModel
from labrig.model._table import TableModel

_STEP = 1e-3
"""Step of the finite differences, fraction of a chamber's range; their error is of its square, at the limits too."""
_ASKED_AGAIN = 16
_SAME = 1e-3
"""Rows that a function is asked for again, and by what share of how far its answers differ they may be others."""
_NAMED = 6  # observables in a message
_CENTRAL = ((1.0, -1.0), (0.0, 0.5, -0.5))
_UP, _DOWN = ((1.0, 2.0), (-1.5, 2.0, -0.5)), ((-1.0, -2.0), (1.5, -2.0, 0.5))
"""Two places beside a row, in steps, and the weights of the row and of both in its slope."""


class BaseModel(Protocol):
    """A prediction of all observables of a run from its actuation."""

    kind: str

    def predict(self, actuation: Floats) -> Floats:
        """Predict (F, C) -> (F, K), in the units of the run."""
        ...

    def declared(self, actuation: Floats) -> Floats | None:
        """Regressors (F, D) of the parameters that the base calls its own, one set per observable, or None."""
        ...


_OF_SHAPES = ("matmul", "broadcast", "shape", "dimension", "out of bounds", "unpack")
"""What numpy says where arrays do not fit together."""


class PythonModel:
    """A function in a file of the user's."""

    kind = "python"

    def __init__(self, spec: PythonBase, folder: Path, rows: Rows) -> None:
        self._where = place_of(spec, folder)
        self._function = function_of(spec, folder)
        self._observables = rows.observables

    def predict(self, actuation: Floats) -> Floats:
        """Call the user's function; raises `LabrigError` when it fails or returns another shape."""
        try:
            out = np.asarray(self._function(actuation.copy()), dtype=float)
        except FAULTS as error:
            given = f"{len(actuation)} rows of {actuation.shape[1]} chambers"
            shapes = isinstance(error, IndexError | ValueError) and any(w in str(error) for w in _OF_SHAPES)
            hint = "; was it made for a rig with another number of chambers?" if shapes else ""
            what = f"{type(error).__name__}: {error}{hint}"
            raise LabrigError(f"{self._where} failed on {given}: {what}") from error
        if out.ndim == 1 and len(self._observables) == 1:
            out = out[:, None]
        expected = (len(actuation), len(self._observables))
        if out.shape != expected:
            raise LabrigError(
                f"{self._where} returned shape {out.shape} for actuation {actuation.shape}; "
                f"the run needs {expected}, a column for each of {_shortly(self._observables)}"
            )
        if not np.isfinite(out).all():
            at = actuation[np.flatnonzero(~np.isfinite(out).all(axis=1))[0]]
            raise LabrigError(
                f"{self._where} returned NaN or infinite values, at {', '.join(f'{v:.4g}' for v in at)}: it is asked "
                "for pressures between the limits, a little beside the set-points too"
            )
        return out

    def check_memory(self, actuation: Floats) -> None:
        """Raise `LabrigError` where the function answers otherwise when it is asked again, in another order."""
        some = actuation[np.unique(np.linspace(0, len(actuation) - 1, _ASKED_AGAIN).astype(int))]
        once, again = self.predict(some), self.predict(some[::-1])[::-1]
        if np.abs(once - again).max(initial=0.0) > _SAME * np.abs(once - once.mean(axis=0)).max(initial=0.0):
            raise LabrigError(
                f"{self._where} answers otherwise when it is asked again in another order: it must be a function of "
                "the pressures alone (a model with memory: docs/reference/model.md; a network: no dropout)"
            )

    def declared(self, actuation: Floats) -> Floats | None:
        """None: a plain Python base has no parameters of its own."""
        return None


def _shortly(names: tuple[str, ...]) -> str:
    """Names in their order; where they would be too long for a line the first and the last, and how many there are:
    what is no marker's, and easily forgotten, comes last.
    """
    if len(names) <= _NAMED:
        return ", ".join(names)
    return f"{', '.join(names[: _NAMED - 2])}, ..., {', '.join(names[-2:])} ({len(names)} in all)"


class StaticModel:
    """A polynomial of the pressures for each observable, fitted to the rows by robust least squares.

    With a map for each session slopes, and what is said of sessions that it was not fitted to, are those of one map for
    all of them.
    """

    kind = "static"

    def __init__(self, spec: StaticBase, rows: Rows) -> None:
        self.degree = spec.degree
        self._low, self._span = rows.low, rows.high - rows.low
        self._in_each = bool(spec.in_each_session)
        if self._in_each and len(rows.sessions) > MOST_SESSIONS:
            raise LabrigError(
                f"base: a map for each session (in_each_session) is for {MOST_SESSIONS} sessions at most, and this run "
                f"has {len(rows.sessions)}"
            )
        self.fit(rows, rows.values)

    def fit(self, rows: Rows, values: Floats) -> None:
        """Fit the map to `values` (F, K), captures counting alike; NaN are left out."""
        captures = np.bincount(rows.capture, minlength=rows.n_captures)
        weight = np.sqrt(1.0 / captures[rows.capture])
        X = self.declared(rows.actuation)

        def fitted(own: Any) -> Floats:
            columns = [robust_fit(X[own], values[own, k], weight[own]) for k in range(values.shape[1])]
            return np.stack(columns, axis=1)

        self._coefficients = fitted(slice(None))
        each = enumerate(rows.session_keys or rows.sessions) if self._in_each else ()
        there = {key: rows.session == s for s, key in each}
        self._own = {key: fitted(own) for key, own in there.items() if own.any()}

    def with_coefficients(self, coefficients: Floats) -> "StaticModel":
        """The same map with other coefficients (D, K), for all sessions."""
        out = copy(self)
        out._coefficients, out._own = coefficients, {}
        return out

    def predict(self, actuation: Floats) -> Floats:
        """Evaluate the fitted map."""
        return self.declared(actuation) @ self._coefficients

    def predict_rows(self, rows: Rows) -> Floats:
        """Predict rows (F, K), each by the map of its own session."""
        X, out = self.declared(rows.actuation), self.predict(rows.actuation)
        for s, key in enumerate(rows.session_keys or rows.sessions):
            if key in self._own:
                own = rows.session == s
                out[own] = X[own] @ self._own[key]
        return out

    def declared_rows(self, rows: Rows) -> Floats:
        """The regressors of rows, (F, D); with a map for each session, those of each session for themselves."""
        X = self.declared(rows.actuation)
        if not self._in_each:
            return X
        each = rows.session[:, None] == np.unique(rows.session)
        return (each[:, :, None] * X[:, None]).reshape(len(X), -1)

    def declared(self, actuation: Floats) -> Floats:
        """The monomials up to the degree, of each chamber's fraction of its range, (F, D)."""
        x = (actuation - self._low) / self._span
        columns = [np.ones(len(x))]
        for degree in range(1, self.degree + 1):
            for chosen in combinations_with_replacement(range(x.shape[1]), degree):
                columns.append(np.prod(x[:, chosen], axis=1))
        return np.stack(columns, axis=1)


def build_base(model: ModelFile, folder: Path, rows: Rows) -> BaseModel:
    """Make the base of a model ready for a run; `folder` is where the model file lies."""
    spec = model.base
    if isinstance(spec, PythonBase):
        memory = memory_of(spec, folder)
        if memory == "record":
            return RecordModel(spec, folder, rows)
        return StepModel(spec, folder, rows) if memory == "step" else PythonModel(spec, folder, rows)
    if isinstance(spec, OdeBase):
        return OdeModel(spec, folder, rows)
    if isinstance(spec, FmuBase):
        return FmuModel(spec, folder, rows)
    if isinstance(spec, TableBase):
        return TableModel(spec, folder, rows)
    if isinstance(spec, StaticBase):
        return StaticModel(spec, rows)
    if isinstance(spec, SurrogateBase):
        return SurrogateModel(folder / spec.file, rows)
    return SimulatorModel(spec, folder, rows)


def is_learned(model: ModelFile) -> bool:
    """Whether any curve of the set-points may be what the base lacks: it was learnt, or is a series cut off."""
    spec = model.base
    if isinstance(spec, StaticBase):
        return spec.degree > 1
    return isinstance(spec, SurrogateBase) or (
        isinstance(spec, PythonBase | TableBase)
        and (bool(spec.learned) or (spec.learned is None and spec.heldout_error is not None))
    )


def jacobian(base: BaseModel, actuation: Floats, low: Floats, high: Floats) -> Floats:
    """Change of the prediction per unit of actuation, (F, K, C), by differences that stay within the limits.

    Central ones would straddle a limit, where many bases clip: a row within a step of a limit has the slope on the
    limit's inner side. Rows further outside have central ones. Rows that share an actuation are computed once; a
    simulator gives its own derivative.
    """
    unique, inverse = np.unique(actuation, axis=0, return_inverse=True)
    inverse = inverse.reshape(-1)
    if isinstance(base, (SimulatorModel, SurrogateModel)):
        return base.slope(unique)[inverse]
    steps = _STEP * (high - low)
    inner = np.clip(unique, low, high)
    at = np.where(np.abs(unique - inner) < steps, inner, unique)
    up = (at >= low) & (at - steps < low)
    down = (at <= high) & (at + steps > high)
    choice = np.select([up, down], [1, 2], 0)
    beside, weight = (np.array([way[i] for way in (_CENTRAL, _UP, _DOWN)])[choice] for i in (0, 1))
    moved = [at]
    for c in range(len(steps)):
        for side in (0, 1):
            moved.append(at.copy())
            moved[-1][:, c] += steps[c] * beside[:, c, side]
    predicted = base.predict(np.concatenate(moved)).reshape(len(moved), len(at), -1)
    ways = [predicted[[0, 2 * c + 1, 2 * c + 2]] for c in range(len(steps))]
    slopes = [np.einsum("pnk,np->nk", ways[c], weight[:, c]) / steps[c] for c in range(len(steps))]
    return np.stack(slopes, axis=-1)[inverse]


def solo_deflection(base: BaseModel, low: Floats, high: Floats) -> Deflection:
    """Move each chamber alone over its range and see how far the observables go."""
    if isinstance(base, MemoryModel):
        return base.deflection(low, high)
    if isinstance(base, SimulatorModel):
        moving = low if base.known is None else np.maximum(low, base.known[0])
        alone = Deflection(*ends(moving, high), *solved_curves(base, moving, high))
        return alone.over(low, high) if (moving > low).any() else alone
    vented, (origin, span) = np.clip(0.0, low, high), ends(low, high)
    curves = np.zeros((GRID, len(low)))
    reach = []
    for c in range(len(low)):
        grid = np.linspace(origin[c], origin[c] + span[c], GRID)
        alone = np.tile(vented, (GRID + 1, 1))
        alone[:-1, c] = grid
        predicted = base.predict(alone)
        moved = np.sqrt(((predicted[:-1] - predicted[-1]) ** 2).mean(axis=1)) * np.sign(
            (grid - vented[c]) / span[c]
        )
        full = np.abs(moved).max()
        curves[:, c] = moved / full if full > 0 else np.linspace(0, 1, GRID)
        reach.append(np.abs(np.diff(predicted[:-1], axis=0)).sum(axis=0) / (high[c] - low[c]))
    return Deflection(origin, span, curves, np.stack(reach, axis=1))
