"""The pipeline: floor, gate, candidates, out-of-sample scores, ceiling, verdict."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig.diagnosis._candidates import Candidate, Fit, fit, square_of
from labrig.diagnosis._ceiling import Ceiling, ceiling
from labrig.diagnosis._floor import Floor, noise_floor
from labrig.diagnosis._gate import Gate
from labrig.diagnosis._outliers import clean
from labrig.diagnosis._own_form import without_ties
from labrig.diagnosis._parameters import entry_of
from labrig.diagnosis._present import fields_of, signatures_of
from labrig.diagnosis._result import Result
from labrig.diagnosis._search import search
from labrig.diagnosis._streams import Streams, build_streams
from labrig.diagnosis._verdict import Verdict, decide
from labrig.diagnosis._where import where
from labrig.effects import Context, Effect, Rows, join_rows, rows_of
from labrig.effects._rows import Floats
from labrig.model import Model

if TYPE_CHECKING:
    from xarray import Dataset

MOST_ROWS = 6000


def rows_from(runs: "Sequence[Dataset] | Dataset") -> Rows:
    """The rows of one campaign or of several of the same rig."""
    many = list(runs) if isinstance(runs, list | tuple) else [runs]
    return join_rows([rows_of(run) for run in many])  # type: ignore[arg-type]


def prepare(rows: Rows, model: Model) -> tuple[Streams, Context, Floor, int]:
    """Predict, clean, estimate the floor and lay out the regression; also how many entries were dropped."""
    predictor = model.predictor(rows)
    context = predictor.context(rows)
    declared, calibrated = predictor.declared(rows), predictor.calibrated(rows)
    if len(rows.capture) > MOST_ROWS:
        keep = np.unique(np.linspace(0, len(rows.capture) - 1, MOST_ROWS).astype(int))
        context = context.thin(keep)
        declared = None if declared is None else declared[keep]
        calibrated = None if calibrated is None else calibrated[keep]
    residual, dropped = clean(context)
    lost = 0 if declared is None else int(np.linalg.matrix_rank(declared))
    floor = noise_floor(context, residual, lost)
    return build_streams(context, floor, residual, declared, calibrated), context, floor, dropped


def diagnose(
    runs: "Sequence[Dataset] | Dataset",
    model: Model,
    *,
    tolerance: float | None = None,
    without: Collection[str] = (),
) -> Result:
    """Compare a model with measurements and say what is missing from it.

    Args:
        runs: campaigns as `labrig.open_run` gives them, of one rig.
        model: the model to question.
        tolerance: the smallest effect that matters, in the units of the observables.
        without: names of effects to leave out of the library.

    Raises:
        LabrigError: the runs and the model do not fit together.
    """
    rows = rows_from(runs)
    streams, context, floor, dropped = prepare(rows, model)
    effects = {n: e for n, e in model.library().items() if n not in without}
    base_left = streams.residual - streams.nothing
    floor_square = float(np.mean(floor.row[streams.counted] ** 2))
    gate = Gate(floor_square, square_of(streams, base_left), tolerance)
    searched = without_ties(search(streams, effects, gate))
    found, chosen = searched.found, searched.chosen
    before = ceiling(streams, context, base_left)
    after = ceiling(streams, context, searched.left) if chosen else before
    verdict = decide(streams, searched, before, after, gate)
    return _result(
        streams, context, floor, dropped, found, chosen, before, after, verdict, gate, model, effects
    )


def _result(
    streams: Streams,
    context: Context,
    floor: Floor,
    dropped: int,
    found: Mapping[str, list[Candidate]],
    chosen: Fit | None,
    before: Mapping[str, Ceiling],
    after: Mapping[str, Ceiling],
    verdict: Verdict,
    gate: Gate,
    model: Model,
    effects: Mapping[str, Effect],
) -> Result:
    rows = context.rows
    base = np.sqrt(gate.base_square)
    floor_error = np.sqrt(gate.floor_square)
    shown = chosen if verdict.verdict in {"identified", "multiple", "confounded"} else None
    model_square = square_of(streams, streams.residual - shown.heldout) if shown else gate.base_square
    lowest = gate.base_square
    best_before = max(before.values(), key=lambda c: c.gain, default=None)
    if best_before is not None:
        left = streams.residual - streams.nothing - best_before.heldout
        lowest = min(lowest, square_of(streams, left))
    if chosen is not None and after:
        best_after = max(after.values(), key=lambda c: c.gain)
        left = streams.residual - chosen.heldout
        lowest = min(lowest, square_of(streams, left), square_of(streams, left - best_after.heldout))
    reachable = max(lowest, gate.floor_square)
    ranking = _ranking(streams, found, gate, reachable)
    entries = [entry_of(streams, context, shown, i) for i in range(len(shown.parts))] if shown else []
    improved = model
    for entry in entries:
        improved = improved.with_effect(entry)
    units = rows.unit[int(streams.counted[0])]
    fields = fields_of(context, shown)
    places = where(context, _rows_left(context, streams), floor, streams.counted)
    summary: dict[str, Any] = {
        "verdict": verdict.verdict,
        "effects": list(verdict.effects),
        "probability": verdict.probability,
        "rivals": list(verdict.rivals),
        "units": units,
        "error": {
            "base": base,
            "model": np.sqrt(model_square),
            "floor": floor_error,
            "ceiling": np.sqrt(lowest),
        },
        "drop": drop_of(gate.base_square, model_square, reachable),
        "where": places,
        "ranking": ranking,
        "next_experiment": _next_experiment(verdict, effects),
        "carried_by": verdict.carried_by or None,
        "floor": {"how": floor.how, "repeats": floor.repeats},
        "warnings": _warnings(rows, floor, verdict, dropped),
    }
    return Result(
        summary=summary,
        fields=fields,
        waterfall=_waterfall(streams, chosen if shown else None, base, np.sqrt(lowest), floor_error),
        signatures=signatures_of(streams, context, found, verdict.effects or verdict.rivals),
        where=places,
        improved=improved if entries else None,
    )


def drop_of(base_square: float, model_square: float, reachable: float) -> float:
    """Share of the explainable error (root mean squares, as diagnosis.json defines it) that is gone."""
    base, now, least = np.sqrt(base_square), np.sqrt(model_square), np.sqrt(reachable)
    return float((base - now) / (base - least)) if base > least * (1 + 1e-9) else 0.0


def _ranking(
    streams: Streams, found: Mapping[str, list[Candidate]], gate: Gate, reachable: float
) -> list[dict[str, Any]]:
    """Every effect on its own, best first, with the share of block resamples in which it is the best."""
    names = list(found)
    if not names:
        return []
    gains = np.array([found[n][0].score.gains for n in names])
    rng = np.random.default_rng(0)
    draws = rng.integers(0, gains.shape[1], size=(1000, gains.shape[1]))
    winners = np.argmax(gains[:, draws].sum(axis=2), axis=0)
    out = []
    for i, name in enumerate(names):
        alone = fit([found[name][0]])
        square = square_of(streams, streams.residual - alone.heldout)
        each = np.array(
            [drop_of(gate.base_square, square + s, reachable) for s in _jackknife(streams, alone, square)]
        )
        out.append(
            {
                "effect": name,
                "form": found[name][0].variant.form,
                "heldout_error": np.sqrt(max(square, 0.0)),
                "drop": drop_of(gate.base_square, square, reachable),
                "se": float(each.std(ddof=1) / np.sqrt(len(each))) if len(each) > 1 else None,
                "probability": float((winners == i).mean()),
                "parameters": {
                    k: v.model_dump(exclude_none=True)
                    for k, v in entry_of(streams, streams.context, alone, 0, refine=False).parameters.items()
                },
            }
        )
    return sorted(out, key=lambda e: e["heldout_error"])


def _jackknife(streams: Streams, alone: Fit, square: float) -> Floats:
    """By how much the held-out mean square of each block differs from the whole's."""
    left = streams.residual - alone.heldout
    out = []
    for own in streams.blocks:
        part = replace(
            streams, weight=np.where(np.isin(np.arange(len(left)), own)[:, None], streams.weight, 0.0)
        )
        out.append(square_of(part, left) - square)
    return np.nan_to_num(np.array(out))


def _rows_left(context: Context, streams: Streams) -> Floats:
    """Measured minus base for each row, outliers as NaN, (F, K)."""
    residual, _ = clean(context)
    return residual


def _waterfall(
    streams: Streams, chosen: Fit | None, base: float, ceiling_error: float, floor_error: float
) -> list[tuple[str, float]]:
    steps = [("base", float(base))]
    if chosen:
        for i in range(len(chosen.parts)):
            part = fit(chosen.parts[: i + 1])
            steps.append(
                (f"+ {part.names[-1]}", float(np.sqrt(square_of(streams, streams.residual - part.heldout))))
            )
    return [*steps, ("ceiling", float(ceiling_error)), ("floor", float(floor_error))]


def _next_experiment(verdict: Verdict, effects: Mapping[str, Effect]) -> dict[str, Any] | None:
    """What to measure next, in words, where the verdict is open."""
    if verdict.verdict not in {"confounded", "unknown", "underpowered"}:
        return None
    names = [n for n in (*verdict.effects, *verdict.rivals) if n in effects]
    return {"separates": names, "probes": [effects[n].experiment for n in names]}


def _warnings(rows: Rows, floor: Floor, verdict: Verdict, dropped: int) -> list[str]:
    out = [*rows.warnings, *verdict.warnings]
    if floor.repeats.get("same history") is None:
        out.append("no repeats with the same history: the noise floor is an estimate, repeat some set-points")
    if len(rows.sessions) > 1 and rows.between_sessions == "unknown":
        out.append("what the pressures did between sessions is unknown: taken as released")
    if dropped:
        out.append(f"{dropped} outlying values were left out")
    return out
