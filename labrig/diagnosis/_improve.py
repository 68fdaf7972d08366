"""compare: a model as it stands against measurements. improve: effects added to it, fitted and judged."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig._errors import LabrigError
from labrig.diagnosis._about import about
from labrig.diagnosis._candidates import fit, square_of
from labrig.diagnosis._constants import SMALLEST_FLOORS
from labrig.diagnosis._formula import fall_of, fit_named
from labrig.diagnosis._outliers import clean
from labrig.diagnosis._parameters import entry_of
from labrig.diagnosis._present import fields_of, signatures_of
from labrig.diagnosis._problem import prepare, rows_from
from labrig.diagnosis._ranking import drop_of
from labrig.diagnosis._result import Result
from labrig.diagnosis._where import where
from labrig.effects import get
from labrig.model import Model

if TYPE_CHECKING:
    from xarray import Dataset


def compare(runs: "Sequence[Dataset] | Dataset", model: Model) -> Result:
    """Errors of a model as it stands, without any fit of effects: how large, and where.

    Raises `LabrigError` when the runs and the model do not fit together.
    """
    streams, context, floor, dropped = prepare(rows_from(runs), model)
    residual, _ = clean(context)
    places = where(context, residual, floor, streams.counted)
    error = {
        "model": np.sqrt(square_of(streams, streams.residual)),
        "floor": np.sqrt(np.mean(floor.row[streams.counted] ** 2)),
    }
    summary: dict[str, Any] = {
        "units": context.rows.unit[int(streams.counted[0])],
        "error": error,
        "where": places,
        "floor": {"how": floor.how, "repeats": floor.repeats},
        "warnings": [*context.rows.warnings, *_left_out(dropped)],
        **about(runs, model),
    }
    return Result(
        summary=summary,
        fields=fields_of(context, residual, None),
        waterfall=[("model", float(error["model"])), ("floor", float(error["floor"]))],
        signatures=[],
        where=places,
    )


def improve(
    runs: "Sequence[Dataset] | Dataset", model: Model, names: Sequence[str], *, force: bool = False
) -> Result:
    """Fit the named effects together and add them to the model.

    Raises `LabrigError` when an effect does not exist, can't act on these runs, is in the model already,
    or, unless `force`, does not lower the held-out error by more than its standard error.
    """
    effects = [get(name, model.folder) for name in dict.fromkeys(names)]
    for effect in effects:
        if any(entry.name == effect.name for entry in model.file.effects):
            raise LabrigError(f"the model has {effect.name!r} already; remove its entry to fit it again")
    streams, context, floor, dropped = prepare(rows_from(runs), model)
    chosen = fit_named(streams, context, effects)
    base_square = square_of(streams, streams.residual - streams.nothing)
    floor_square = float(np.mean(floor.row[streams.counted] ** 2))
    units = context.rows.unit[int(streams.counted[0])]
    falls = [fall_of(chosen, i) for i in range(len(effects))]
    least = (SMALLEST_FLOORS**2) * floor_square
    helps = [fall > se and fall >= least for fall, se in falls]
    for effect, helpful, (fall, _) in zip(effects, helps, falls, strict=True):
        if not helpful and not force:
            raise LabrigError(
                f"{effect.name!r} does not lower the held-out error enough to matter (by {_rms(fall):.2g} {units}, "
                f"needed {_rms(least):.2g} {units}); the model is left as it is; --force adds it all the same"
            )
    model_square = square_of(streams, streams.residual - chosen.heldout)
    entries = [entry_of(streams, context, chosen, i, refine=False) for i in range(len(effects))]
    improved = model
    for entry in entries:
        improved = improved.with_effect(entry)
    residual, _ = clean(context)
    places = where(context, residual, floor, streams.counted)
    steps = [("base", float(np.sqrt(base_square)))]
    for i in range(len(effects)):
        part = fit(chosen.parts[: i + 1])
        square = square_of(streams, streams.residual - part.heldout)
        steps.append((f"+ {effects[i].name}", float(np.sqrt(square))))
    summary: dict[str, Any] = {
        "units": units,
        "effects": [e.name for e in effects],
        "error": {
            "base": np.sqrt(base_square),
            "model": np.sqrt(model_square),
            "floor": np.sqrt(floor_square),
        },
        "drop": drop_of(np.sqrt(base_square), np.sqrt(model_square), np.sqrt(floor_square)),
        "added": [entry.model_dump(exclude_none=True) for entry in entries],
        "where": places,
        "warnings": [
            *context.rows.warnings,
            *(
                f"{effect.name!r} does not lower the held-out error enough to matter; it was added because of --force"
                for effect, helpful in zip(effects, helps, strict=True)
                if not helpful
            ),
            *_left_out(dropped),
        ],
        **about(runs, model),
    }
    return Result(
        summary=summary,
        fields=fields_of(context, residual, chosen),
        waterfall=[*steps, ("floor", float(np.sqrt(floor_square)))],
        signatures=signatures_of(context, residual, floor.row, dict.fromkeys(chosen.names, chosen)),
        where=places,
        improved=improved,
    )


def _left_out(dropped: int) -> list[str]:
    return [f"{dropped} outlying values were left out"] if dropped else []


def _rms(square: float) -> float:
    """A mean square as a root mean square, of either sign."""
    return float(np.sign(square) * np.sqrt(abs(square)))
