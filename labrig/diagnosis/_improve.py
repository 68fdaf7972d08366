"""compare: a model as it stands against measurements. improve: effects added to it, fitted and judged."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig._errors import LabrigError
from labrig.diagnosis._candidates import Candidate, Fit, clear, fit, plausible, square_of
from labrig.diagnosis._columns import columns_of
from labrig.diagnosis._diagnose import drop_of, prepare, rows_from
from labrig.diagnosis._gate import Gate, rules_the_hold
from labrig.diagnosis._outliers import clean
from labrig.diagnosis._parameters import entry_of, refined
from labrig.diagnosis._present import fields_of, signatures_of
from labrig.diagnosis._result import Result
from labrig.diagnosis._score import score
from labrig.diagnosis._streams import Streams
from labrig.diagnosis._where import where
from labrig.effects import Context, Effect, get
from labrig.model import Model

if TYPE_CHECKING:
    from xarray import Dataset

_ROUNDS = 2


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
    }
    return Result(
        summary=summary,
        fields=fields_of(context, None),
        waterfall=[("model", float(error["model"])), ("floor", float(error["floor"]))],
        signatures=signatures_of(streams, context, {}, ()),
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
    chosen = _fit_named(streams, context, effects)
    base_square = square_of(streams, streams.residual - streams.nothing)
    floor_square = float(np.mean(floor.row[streams.counted] ** 2))
    units = context.rows.unit[int(streams.counted[0])]
    falls = [_fall_of(chosen, i) for i in range(len(effects))]
    least = Gate(floor_square, base_square, None).smallest(0.0)
    helps = [
        clear_ and (fall >= least or rules_the_hold(part))
        for part, (fall, clear_) in zip(chosen.parts, falls, strict=True)
    ]
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
        "drop": drop_of(base_square, model_square, min(floor_square, model_square)),
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
    }
    return Result(
        summary=summary,
        fields=fields_of(context, chosen),
        waterfall=[*steps, ("floor", float(np.sqrt(floor_square)))],
        signatures=signatures_of(
            streams, context, {p.effect.name: [p] for p in chosen.parts}, [e.name for e in effects]
        ),
        where=places,
        improved=improved,
    )


def _left_out(dropped: int) -> list[str]:
    return [f"{dropped} outlying values were left out"] if dropped else []


def _fit_named(streams: Streams, context: Context, effects: Sequence[Effect]) -> Fit:
    """The best forms of the named effects, found in turn and then moved off the grid together."""
    forms = [_forms(streams, context, effect) for effect in effects]
    chosen = fit([f[0] for f in forms])
    for _ in range(_ROUNDS):
        for i, own in enumerate(forms):
            options = [fit([*chosen.parts[:i], c, *chosen.parts[i + 1 :]]) for c in own]
            chosen = max(options, key=lambda f: f.score.gain)
    for i, effect in enumerate(effects):
        if effect.name != "marker_slip":
            chosen = refined(streams, context, chosen, i)
    return chosen


def _forms(streams: Streams, context: Context, effect: Effect) -> list[Candidate]:
    found = []
    for variant in effect.variants(context):
        columns = columns_of(streams, variant)
        if columns.width:
            scored = score(columns)
            found.append(
                (plausible(effect, variant, columns, scored), Candidate(effect, variant, columns, scored))
            )
    if not found:
        raise LabrigError(
            f"effect {effect.name!r} can't act on this run; see: labrig effects show {effect.name}"
        )
    found.sort(key=lambda f: (not f[0], -f[1].score.gain))
    return [candidate for _, candidate in found[:6]]


def _fall_of(chosen: Fit, i: int) -> tuple[float, bool]:
    """By how much the i-th effect lowers the held-out mean square beside the others, and whether clearly."""
    streams = chosen.columns.streams
    rest = [p for j, p in enumerate(chosen.parts) if j != i]
    before = fit(rest) if rest else None
    more = chosen.score.gains - (before.score.gains if before else 0.0)
    left = streams.residual - (before.heldout if before else streams.nothing)
    fall = square_of(streams, left) - square_of(streams, streams.residual - chosen.heldout)
    return fall, clear(more, streams.base_squares)


def _rms(square: float) -> float:
    """A mean square as a root mean square, of either sign."""
    return float(np.sign(square) * np.sqrt(abs(square)))
