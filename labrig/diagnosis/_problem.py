"""What a diagnosis works on: rows, what the model predicts of them, what is left, and how finely that was measured."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from labrig._errors import LabrigError
from labrig._linalg import rms
from labrig._near import meant
from labrig._text import percent
from labrig.arrays import Floats, Ints
from labrig.contents import MANY_LEFT_OUT, HeldOff
from labrig.diagnosis._dead import without_dead
from labrig.diagnosis._floor import Floor, noise_floor
from labrig.diagnosis._frozen import without_frozen
from labrig.diagnosis._held_off import held_off, held_off_lines
from labrig.diagnosis._interchanged import INTERCHANGED, without_interchanged
from labrig.diagnosis._missed import MISSED, without_missed
from labrig.diagnosis._outliers import clean
from labrig.diagnosis._regression import Regression, regression_of
from labrig.diagnosis._swapped import without_swapped
from labrig.diagnosis._turned import as_the_model_turns
from labrig.effects import Context, Rows, join_rows, rows_of
from labrig.model import Model, transients

if TYPE_CHECKING:
    from xarray import Dataset

MOST_ROWS = 6000
"""Rows of a record that are diagnosed at most; of more every n-th."""
ASTRAY = {INTERCHANGED: without_interchanged, MISSED: without_missed}
"""What single captures are left out for, and how."""
_NAMED = 3  # markers or sensors in a message


@dataclass(frozen=True)
class Prepared:
    """A campaign beside a model: `residual` (F, K) without outliers (`dropped` of them), the noise `floor`.

    What the base calls its own: `declared` (F, D), regressors of every observable, `calibrated` (F, K, D), fields.
    `began` (F, B) are regressors of what a record still shows of the time before it, where nobody said what that was.
    `astray`: what single captures were left out for, in words; `misnamed`: which markers have others' names nearly
    always. `as_it_stands`: nothing is fitted to it.
    """

    context: Context
    residual: Floats
    floor: Floor
    dropped: int
    declared: Floats | None
    calibrated: Floats | None
    began: Floats | None = None
    astray: str = ""
    misnamed: str = ""
    as_it_stands: bool = False

    @property
    def unfitted(self) -> "Prepared":
        """What was prepared for a model as it stands: of one or two captures, too, the error of each counts."""
        return self if self.regression.use_means else replace(self, as_it_stands=True)

    def thin(self, keep: Ints) -> "Prepared":
        """What was prepared, for some rows only; history and floor stay those of all rows."""
        declared, calibrated, began = (
            None if whole is None else whole[keep] for whole in (self.declared, self.calibrated, self.began)
        )
        return replace(
            self,
            context=self.context.thin(keep),
            residual=self.residual[keep],
            declared=declared,
            calibrated=calibrated,
            began=began,
        )

    @property
    def nuisance(self) -> Floats | None:
        """What the base calls its own, and what was before a record, (F, D + B): nothing that an effect explains."""
        both = [part for part in (self.declared, self.began) if part is not None]
        return np.concatenate(both, axis=1) if both else None

    @cached_property
    def held_off(self) -> list[HeldOff]:
        """What was left out through whole holds."""
        return held_off(self.context.rows, self.context.residual, self.residual) if self.dropped else []

    @cached_property
    def left_out_share(self) -> float:
        """The share of all measured values that was left out as mistaken."""
        return self.dropped / max(int(np.isfinite(self.context.rows.values).sum()), 1)

    @property
    def left_out(self) -> list[str]:
        """Lines on outlying values that were left out, and where most of them were; none without any."""
        if not self.dropped:
            return []
        rows = self.context.rows
        gone = (np.isfinite(rows.values) & ~np.isfinite(self.residual)).sum(axis=0)
        count: Counter[str] = Counter()
        for name, marker, values in zip(rows.observables, rows.marker, gone.tolist(), strict=True):
            count[rows.markers[marker] if marker >= 0 else name] += values
        most = [f"{values} of {name}" for name, values in count.most_common(_NAMED) if values]
        more = ["..."] if sum(values > 0 for values in count.values()) > _NAMED else []
        what = "outlying value was" if self.dropped == 1 else "outlying values were"
        return [
            f"{self.dropped} {what} left out ({', '.join([*most, *more])}){self._often()}",
            *held_off_lines(self.held_off),
        ]

    def _often(self) -> str:
        """What to make of many values that were left out; empty of few."""
        if self.left_out_share < MANY_LEFT_OUT:
            return ""
        gone = np.any(np.isfinite(self.context.rows.values) & ~np.isfinite(self.residual), axis=1)
        return (
            f", {percent(self.left_out_share)} of all, in {gone.sum()} of {len(gone)} rows: what makes them, such as "
            "interference, is in no verdict; find it"
        )

    @property
    def not_quoted(self) -> list[str]:
        """A line on units that are in no figure, since errors are quoted in one; none where there is one only."""
        units, own = self.context.rows.unit, self.regression.units
        seen = np.flatnonzero(np.isfinite(self.residual).any(axis=0))
        others = dict.fromkeys(units[k] for k in seen if units[k] != own)
        if not others:
            return []
        return [
            f"errors are those of what is in {own}; what is in {' and '.join(others)} counts by its noise, for the "
            "verdict and in the sizes of effects"
        ]

    @property
    def within_only(self) -> list[str]:
        """A line where errors are of what changes along holds alone, since a fit would follow any mean of so few."""
        if self.regression.use_means:
            return []
        return [
            "with fewer than three captures errors are those of what changes along the holds alone: labrig compare "
            "says by how much each capture is off"
        ]

    @property
    def quoted_floor(self) -> float:
        """The noise of a row of the observables that errors are quoted for, root mean square."""
        return rms(self.floor.row[self.regression.counted])

    @property
    def repeats(self) -> dict[str, float | None]:
        """What each kind of repeat differs by, in the unit in which errors are quoted."""
        return self.floor.repeats[self.regression.units]

    @cached_property
    def regression(self) -> Regression:
        """The regression problem of the formulas."""
        own = self.declared, self.calibrated
        return regression_of(self.context, self.floor, self.residual, *own, as_it_stands=self.as_it_stands)


def rows_from(runs: "Sequence[Dataset] | Dataset") -> Rows:
    """The rows of one campaign or of several of the same rig."""
    many = list(runs) if isinstance(runs, list | tuple) else [runs]
    return join_rows([rows_of(run) for run in many])  # type: ignore[arg-type]


def last_of(runs: "Sequence[Dataset]") -> Rows:
    """The rows of the last of several campaigns of a rig, with what came before as its history."""
    rows, own = rows_from(runs), rows_from(runs[-1:])
    return rows.thin(rows.capture >= rows.n_captures - own.n_captures)


def prepared(rows: Rows, model: Model) -> Prepared:
    """Predict, clean, and estimate the floor; of very long records every n-th row.

    Raises `LabrigError` where the rows and the model do not fit together, or where something is ruled out that is no
    effect.
    """
    for name in sorted({name for names in rows.ruled_out for name in names}):
        if name not in (known := model.library()):
            raise LabrigError(f"{name!r} is ruled out in a run, and is no effect{meant(name, known)}")
    predictor = model.predictor(rows)
    own = predictor.declared(rows)
    context = as_the_model_turns(without_dead(predictor.context(rows), own is not None))
    context, misnamed = without_swapped(without_frozen(context))
    keep, astray = np.arange(len(rows.capture)), ""
    for what, without in ASTRAY.items():
        context, sound = without(context)
        if not sound.all():
            context, keep, astray = context.thin(np.flatnonzero(sound)), keep[sound], what
    began = transients(context) if context.sample_s and rows.between_sessions == "unknown" else None
    at_full_rate = context.residual
    if len(keep) > MOST_ROWS:
        some = np.unique(np.linspace(0, len(keep) - 1, MOST_ROWS).astype(int))
        context, keep = context.thin(some), keep[some]
        began = None if began is None else began[some]
    declared, calibrated = (
        None if whole is None else whole[keep] for whole in (own, predictor.calibrated(rows))
    )
    residual, dropped = clean(context)
    lost = 0 if declared is None else int(np.linalg.matrix_rank(declared))
    floor = noise_floor(context, residual, lost, at_full_rate)
    return Prepared(context, residual, floor, dropped, declared, calibrated, began, astray, misnamed)
