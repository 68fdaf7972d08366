"""Models that remember: what a path of set-points does to a surface, by the effects of a model file."""

from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from labrig._errors import LabrigError
from labrig.arrays import Floats

if TYPE_CHECKING:
    from labrig.effects import Rows
    from labrig.model import Model


_FAR_S = 1e8
"""A session so long after the path that no effect is too slow for it; nobody looks at it."""
_LEVELS = (0.25, 0.5, 0.75, 1.0)
_IN_A_LINE = 1e-3
"""Markers that are off a line by less than this, of (u, v), lie in it."""


@dataclass(frozen=True)
class Approach:
    """Set-points one after the other, from vented: setpoints_kpa (S, C) and how long each is held, s, (S,)."""

    name: str
    setpoints_kpa: Floats
    holds_s: tuple[float, ...]

    @property
    def duration_s(self) -> float:
        """How long it takes, s."""
        return float(sum(self.holds_s))


def marker_uv(shape: Any) -> Floats:
    """(u, v) (M, 2) of a shape model's markers; a warped model's are those of its forward model. None is (0, 2)."""
    return np.asarray(getattr(getattr(shape, "forward", shape), "marker_uv", np.zeros((0, 2))), float)


@dataclass
class _Base:
    """The shape model at its markers, as a base of a model."""

    shape: Any
    kind: str = "simulator"

    def predict(self, actuation: Floats) -> Floats:
        """Markers (F, 3 M), mm."""
        return np.asarray(self.shape.points(actuation, marker_uv(self.shape))).reshape(len(actuation), -1)

    def declared(self, actuation: Floats) -> Floats | None:
        """None: nothing is fitted."""
        return None


@dataclass
class Remembering:
    """A shape model with the effects of a model file.

    `shape` has `marker_names` and `marker_uv` (M, 2), itself or in its forward model, besides what every shape model
    has. What acts through the pressures becomes an equivalent change of them; what acts on markers is their
    displacement.
    """

    model: "Model"
    shape: Any
    _alone: Any = field(default=None, repr=False)

    def after(self, path: Approach) -> tuple[Floats, Floats]:
        """What a path leaves at its end.

        The pressures that a surface without memory would need for the same shape, (C,), kPa, and how far the markers
        are displaced beside that, (M, 3), mm.
        """
        from labrig.effects import contribution, get
        from labrig.model import as_fitted, find_variant

        rows = self._rows(path)
        whole = self._context(rows)
        change = np.zeros((len(rows.actuation), len(self.shape.chamber_names)))
        displaced = np.zeros_like(whole.base)
        for entry in self.model.file.effects:
            context = as_fitted(whole, entry)
            variant = find_variant(context, get(entry.name, self.model.folder), entry)
            terms, values = [], []
            for term in variant.terms:
                value = np.asarray(entry.parameters[term.parameter].value, dtype=float).reshape(-1)
                coefficients = _shaped(value, term, displaced.shape[1], entry.name)
                if term.kind == "pressure":
                    change += term.feature @ coefficients
                else:
                    terms.append(term)
                    values.append(coefficients)
            if terms:
                rest = type(variant)(variant.form, tuple(terms), variant.shape)
                displaced += contribution(context, rest, values)
        return rows.actuation[0] + change[0], displaced[0].reshape(-1, 3)

    def displaced(self, shift_mm: Floats) -> Any:
        """The surface whose markers are displaced by `shift_mm` (M, 3); raises `LabrigError` as `Displaced` does."""
        return Displaced(self.shape, shift_mm) if shift_mm.any() else self.shape

    def _context(self, rows: "Rows") -> Any:
        from labrig.effects import Context
        from labrig.model import solo_deflection

        base = _Base(self.shape)
        if self._alone is None:
            self._alone = solo_deflection(base, rows.low, rows.high)
        slopes = self.shape.jacobian(rows.actuation, marker_uv(self.shape))
        return Context(
            rows=rows,
            base=base.predict(rows.actuation),
            base_vented=base.predict(np.clip(0.0, rows.low, rows.high)[None])[0],
            jacobian=np.asarray(slopes).reshape(len(rows.actuation), -1, len(rows.chambers)),
            deflection=self._alone.at(rows.actuation),
            event_deflection=self._alone.at(rows.event_actuation),
            deflection_slope=self._alone.slope(rows.actuation),
            base_kind=base.kind,
            inside=self.shape.inside(rows.actuation) if hasattr(self.shape, "inside") else {},
            reach=self._alone.reach,
            alone=partial(solo_deflection, base),
            elsewhere=base.predict,
        )

    def _rows(self, path: Approach) -> "Rows":
        """Row 0: the end of the path. The others show the effects the whole range, in a session of their own."""
        from labrig.effects import Rows

        shape = self.shape
        low, high = np.asarray(shape.low_kpa, float), np.asarray(shape.high_kpa, float)
        levels = low + np.array(_LEVELS)[:, None] * (high - low)
        vented = np.clip(0.0, low, high)[None]
        event_actuation = np.concatenate([vented, path.setpoints_kpa, levels]).astype(np.float64)
        starts = np.concatenate([[0.0], 1.0 + np.cumsum([0.0, *path.holds_s[:-1]])])
        steps, extra = len(starts), len(levels)
        rows, markers = 1 + extra, tuple(shape.marker_names)
        K = 3 * len(markers)
        last = np.array([steps - 1, *range(steps, steps + extra)])
        event_time = np.array([*starts, *(_FAR_S * (1 + k) for k in range(extra))], np.float64)
        hold = np.array([path.holds_s[-1], *[3.0] * extra], np.float64)
        return Rows(
            chambers=tuple(shape.chamber_names),
            actuation_unit="kPa",
            low=low,
            high=high,
            actuation=event_actuation[last],
            measured=np.full((rows, len(low)), np.nan),
            values=np.full((rows, K), np.nan),
            capture=np.arange(rows),
            session=np.array([0, *[1] * extra]),
            event=last,
            hold_s=hold,
            time_s=event_time[last] + hold,
            event_actuation=event_actuation,
            event_time_s=event_time,
            event_session=np.array([*[0] * steps, *[1] * extra]),
            sessions=("path", "range"),
            observables=tuple(f"{marker}.{axis}" for marker in markers for axis in "xyz"),
            unit=("mm",) * K,
            marker=np.repeat(np.arange(len(markers)), 3),
            axis=np.tile(np.arange(3), len(markers)),
            markers=markers,
            rest_mm=np.asarray(shape.points(vented, marker_uv(shape)))[0],
            repeat=("",) * rows,
            covariates={},
            between_sessions="vented",
        )


def _shaped(value: Floats, term: Any, observables: int, effect: str) -> Floats:
    """A term's coefficients in the shape that its kind asks for; one value stands for all."""
    columns = 6 if term.kind == "frame" else term.feature.shape[-1]
    shape = (columns, observables) if term.kind == "pattern" else (columns,)
    size = int(np.prod(shape))
    if value.size not in (1, size):
        raise LabrigError(
            f"effect {effect!r}: {term.parameter!r} has {value.size} values, this surface needs {size}"
        )
    return np.broadcast_to(value, (size,)).reshape(shape)


class Displaced:
    """A shape model whose surface is displaced by what its markers are displaced by, (M, 3), mm; smooth between.

    Raises `LabrigError` for fewer than three markers, or such that lie in a line: nobody knows what is beside them.
    """

    def __init__(self, shape: Any, shift_mm: Floats) -> None:
        from scipy.interpolate import RBFInterpolator

        uv = marker_uv(shape)
        if np.linalg.matrix_rank(uv - uv[:1], tol=_IN_A_LINE) < 2:
            raise LabrigError(
                "an effect that displaces markers moves the surface between them: that needs three markers, "
                "not in a line"
            )
        self.shape = shape
        self.chamber_names, self.low_kpa, self.high_kpa = shape.chamber_names, shape.low_kpa, shape.high_kpa
        self._shift = RBFInterpolator(uv, shift_mm, smoothing=1e-3)

    def points(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """Points (F, P, 3), mm."""
        return np.asarray(self.shape.points(pressure_kpa, uv)) + self._shift(np.asarray(uv, float))

    def jacobian(self, pressure_kpa: ArrayLike, uv: ArrayLike) -> Floats:
        """Their derivatives (F, P, 3, C), mm/kPa."""
        return self.shape.jacobian(pressure_kpa, uv)
