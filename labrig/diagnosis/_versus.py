"""Two models on the same measurements: which is nearer, by how much, how sure that is, and where."""

from collections.abc import Sequence
from datetime import UTC
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig import contents
from labrig._errors import LabrigError
from labrig._linalg import rms
from labrig.arrays import Floats
from labrig.contents import PlaceGap, Versus
from labrig.diagnosis._about import about
from labrig.diagnosis._by_unit import seen_by_unit
from labrig.diagnosis._noise_scale import with_noise_of_few
from labrig.diagnosis._paired import LEVEL, BlockSums, Difference, by_block, difference
from labrig.diagnosis._present import fields_of
from labrig.diagnosis._problem import Prepared, prepared, rows_from
from labrig.diagnosis._result import VersusResult
from labrig.diagnosis._where import places
from labrig.effects import capture_means
from labrig.model import Model

if TYPE_CHECKING:
    from xarray import Dataset

FLOOR = "floor"
"""The name of the noise beside those of the models."""
_EXPLAINED = 0.5
"""A value that one model misses by less than this share of what the other misses it by is no mistake."""


def versus(runs: "Sequence[Dataset] | Dataset", first: Model, second: Model) -> VersusResult:
    """Errors of two models as they stand over the same cells, and their difference with a 95 % interval.

    In the fields `base` is the first model's prediction and `model` the second's. A difference is the first model's
    error minus the second's: above zero the second is nearer. Raises `LabrigError` when the runs and a model do not
    fit together, or when both models are one file.
    """
    models, names = (first, second), names_of_models(first, second)
    rows = rows_from(runs)
    ready = [with_noise_of_few(prepared(rows, model), model.library()) for model in models]
    both = [one.unfitted for one in _same_captures(ready)]
    regression = both[0].regression
    residual = _same_cells(both)
    lost = int((np.isfinite(both[0].context.residual) & ~np.isfinite(residual[0])).sum())
    counted, group = regression.counted, regression.row_group
    sums = [_sums(left[:, counted], both[0], group, regression.use_means) for left in residual]
    whole = difference(sums[0], sums[1])
    floors = [rms(one.floor.row[counted]) for one in both]
    floor = both[int(np.argmin(floors))].floor
    errors = [one.rms() for one in sums]
    summary: Versus = {
        "units": regression.units,
        "models": [
            {"name": name, "file": None if model.path is None else model.path.as_posix(), "error": error}
            for name, model, error in zip(names, models, errors, strict=True)
        ],
        "error": {names[0]: errors[0], names[1]: errors[1], FLOOR: min(floors)},
        "error_by_unit": _errors_by_unit(both, residual, names),
        "difference": _plain(whole),
        "better": None if whole.nearer is None else names[whole.nearer],
        "where": _where(both[0], residual, group, names),
        "floor": floor.told(regression.units),
        "warnings": [
            *rows.warnings,
            *(line for one, model in zip(both, models, strict=True) for line in model.unsaid(one.context)),
            *_notes(both, models, names, lost, _begun_s(runs)),
        ],
        "runs": about(runs, first)["runs"],
    }
    fields, other = (fields_of(one.context, left, None) for one, left in zip(both, residual, strict=True))
    fields["model"], fields["model_everywhere"] = other["base"], other["base_everywhere"]
    if "error_after" in fields:
        fields["error_after"] = other["error_before"]
    steps = [(names[0], errors[0]), (names[1], errors[1]), (FLOOR, min(floors))]
    return VersusResult(summary, fields, steps, [], summary["where"])


def _errors_by_unit(
    both: Sequence[Prepared], residual: Sequence[Floats], names: Sequence[str]
) -> dict[str, dict[str, float]]:
    """Both errors and the floor in each unit, where there are several."""
    of, out = both[0].regression, {}
    for unit, own in seen_by_unit(of).items():
        errors = [_sums(left[:, own], both[0], of.row_group, of.use_means).rms() for left in residual]
        floor = min(rms(one.floor.row[own]) for one in both)
        out[unit] = {names[0]: errors[0], names[1]: errors[1], FLOOR: floor}
    return out


def names_of_models(first: Model, second: Model) -> tuple[str, str]:
    """What two models are called: by their files, in full where these are called the same.

    Raises `LabrigError` where both are one file.
    """
    paths = [first.path, second.path]
    if paths[0] is not None and paths[1] is not None and paths[0].resolve() == paths[1].resolve():
        raise LabrigError(f"{paths[0]}: both models are this file; name another for the second")
    short = [_stem(path, other) for path, other in zip(paths, ("first", "second"), strict=True)]
    if short[0] == short[1] or FLOOR in short:
        short = [
            path.as_posix() if path else f"{name} model" for path, name in zip(paths, short, strict=True)
        ]
    return short[0], short[1]


def _stem(path: Path | None, otherwise: str) -> str:
    return otherwise if path is None else path.stem


def _same_captures(both: Sequence[Prepared]) -> list[Prepared]:
    """Without the captures that one of both models calls misplaced."""
    first, second = (one.context.rows.capture for one in both)
    common = [np.isin(first, second), np.isin(second, first)]
    return [one.thin(np.flatnonzero(own)) for one, own in zip(both, common, strict=True)]


def _same_cells(both: Sequence[Prepared]) -> list[Floats]:
    """Residuals (F, K) of both models over the cells that count for both.

    What either calls a mistake of the measurement is left out of both, unless the other model explains it.
    """
    raw = [one.context.residual for one in both]
    out = np.zeros(raw[0].shape, dtype=bool)
    for one, own, other in ((both[0], raw[0], raw[1]), (both[1], raw[1], raw[0])):
        mistaken = np.isfinite(own) & ~np.isfinite(one.residual)
        out |= mistaken & ~(np.abs(other) < _EXPLAINED * np.abs(own))
    return [np.where(out, np.nan, left) for left in raw]


def _sums(left: Floats, of: Prepared, group: NDArray[np.int64], use_means: bool) -> BlockSums:
    """Squares of captures' means, and of what differs from them within the holds, by block."""
    capture = of.context.rows.capture
    captures, index = np.unique(capture, return_inverse=True)
    means, _ = capture_means(left, capture)
    inside = np.flatnonzero((np.bincount(index)[index] > 1) & (of.floor.within.max() > 0))
    first = np.searchsorted(index, np.arange(len(captures)))
    parts = [(means**2, group[first])] if use_means else []
    if len(inside):
        parts.append(((left[inside] - means[index[inside]]) ** 2, group[inside]))
    return by_block(parts, int(group.max()) + 1)


def _where(
    of: Prepared, residual: Sequence[Floats], group: NDArray[np.int64], names: tuple[str, str]
) -> list[PlaceGap]:
    """Both errors in each place, and the difference, with an interval that allows for the places of one group."""
    counted = of.regression.counted
    cells = [left[:, counted] ** 2 for left in residual]
    blocks = int(group.max()) + 1
    there = [place for place in places(of.context, counted) if place.group != "capture"]
    there = [place for place in there if np.isfinite(place.of(cells[0])).any()]
    many = {name: sum(place.group == name for place in there) for name in {place.group for place in there}}
    out: list[PlaceGap] = []
    for place in there:
        sums = [by_block([(place.of(square), group[place.rows])], blocks) for square in cells]
        pooled = [
            BlockSums(s.square.sum(axis=2, keepdims=True), s.count.sum(axis=2, keepdims=True)) for s in sums
        ]
        found = difference(pooled[0], pooled[1], level=1 - (1 - LEVEL) / many[place.group])
        out.append(
            {
                "group": place.group,
                "name": place.name,
                "error": [one.rms() for one in pooled],
                "value": found.value,
                "low": found.low,
                "high": found.high,
                "better": None if found.nearer is None else names[found.nearer],
            }
        )
    return sorted(out, key=lambda entry: -abs(entry["value"]))


def _plain(found: Difference) -> contents.Difference:
    return {
        "value": found.value,
        "low": found.low,
        "high": found.high,
        "sd": found.sd,
        "blocks": found.blocks,
        "level": LEVEL,
    }


def _begun_s(runs: "Sequence[Dataset] | Dataset") -> float:
    """When the first of the runs began, in seconds since 1970; NaN where one of them does not say."""
    many: list[Any] = list(runs) if isinstance(runs, list | tuple) else [runs]
    return float(np.min([float(run.attrs.get("start_s", np.nan)) for run in many]))


def _fitted_before(model: Model, begun_s: float) -> bool:
    """Whether the model says that its effects were fitted to runs that had ended by then."""
    until = model.file.fitted_until
    if until is None:
        return False
    return (until if until.tzinfo else until.replace(tzinfo=UTC)).timestamp() < begun_s


def _notes(
    both: Sequence[Prepared], models: Sequence[Model], names: Sequence[str], lost: int, begun_s: float
) -> list[str]:
    """What makes a comparison less fair, and what was left out."""
    notes = []
    for one, model, name in zip(both, models, names, strict=True):
        if one.declared is not None or one.calibrated is not None:
            notes.append(f"the base of “{name}” is fitted to this run: on a new run its error is larger")
        elif model.file.effects and not _fitted_before(model, begun_s):
            notes.append(
                f"if the effects of “{name}” were fitted to this run, its error on a new run is larger"
            )
    if lost:
        what = "outlying value was" if lost == 1 else "outlying values were"
        notes.append(f"{lost} {what} left out of both errors")
    return notes
