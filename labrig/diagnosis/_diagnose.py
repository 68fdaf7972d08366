"""The way of a residual: observations, design, evidence, verdict, formula, result."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from labrig._errors import LabrigError
from labrig._near import meant
from labrig.arrays import Floats
from labrig.contents import MANY_LEFT_OUT, Errors, Next, Summary, TrackRecord
from labrig.diagnosis import _constants as k
from labrig.diagnosis._about import about
from labrig.diagnosis._answers import answers_of
from labrig.diagnosis._by_unit import by_unit
from labrig.diagnosis._candidates import Candidate, Fit, error_of, fit, quoted
from labrig.diagnosis._ceiling import ceiling
from labrig.diagnosis._curves import MAP
from labrig.diagnosis._design import Design, design_of, stilled
from labrig.diagnosis._explanation import CURVE, REST
from labrig.diagnosis._falls import beside_named, falls_of, much_left, takes_most
from labrig.diagnosis._formula import fit_named, forms_of
from labrig.diagnosis._gone import acting_share, gone
from labrig.diagnosis._motions import MOTION
from labrig.diagnosis._noise_scale import noise_of_few, of_few
from labrig.diagnosis._notes import NOTHING, learnt_below, may_be_learnt, nearly_explained, notes_on
from labrig.diagnosis._observations import Observations, observe
from labrig.diagnosis._one_speed import alike
from labrig.diagnosis._out_of_bounds import in_place_of, said_of
from labrig.diagnosis._parameters import entries_of
from labrig.diagnosis._posterior import Search
from labrig.diagnosis._present import fields_of, signatures_of
from labrig.diagnosis._problem import ASTRAY, Prepared, prepared, rows_from
from labrig.diagnosis._ranking import alone, drop_of, ranking_of
from labrig.diagnosis._rests_on import rests_on
from labrig.diagnosis._result import Result, told
from labrig.diagnosis._same import said_of_same, same_as
from labrig.diagnosis._shaken import shaken
from labrig.diagnosis._too_plain import too_plain
from labrig.diagnosis._track_record import track_record
from labrig.diagnosis._units_off import mistaken
from labrig.diagnosis._verdict import (
    Considered,
    Verdict,
    decide,
    in_its_place,
    in_one_part,
    less_sure,
    not_told_apart,
    taken_back,
    underpowered,
    where_it_acts,
    with_unseen,
)
from labrig.diagnosis._where import where
from labrig.effects import Effect, without_failing
from labrig.model import Model

if TYPE_CHECKING:
    from xarray import Dataset


CUT_OFF = "curves that the fitted map lacks"
"""What carries what a polynomial that was fitted, or a map that was learnt, may lack."""
BY_SET_POINT = "a curve of the set-points"
"""What carries what goes by the set-point alone, though only an effect that remembers would hold it."""
_OF_CHAMBER = "look at its hose, valve, sensor and wall first"
_OF_SESSION = "make a run of it alone, diagnose that, and look at what was another then"


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
        LabrigError: the runs and the model do not fit together, in their units too; or there is no such effect to
            leave out.
    """
    library = model.library()
    for name in without:
        if name not in library:
            raise LabrigError(f"there is no effect {name!r} to leave out{meant(name, library)}")
    rows = rows_from(runs)
    ready = prepared(rows, model)

    def attempt(failing: Collection[str]) -> Result:
        effects = {n: e for n, e in library.items() if n not in without and n not in failing}
        with_noise, observations, design = laid_out(ready, effects)
        verdict = verdict_on(with_noise, observations, design, effects, tolerance)
        del design  # the most of what is held in memory; the formulas need none of it
        return result_of(with_noise, observations, verdict, model, effects)

    result, failed = without_failing(attempt, {entry.name for entry in model.file.effects})
    result.summary["warnings"] += [*too_plain(rows, model, result.summary), *failed]
    named = about(runs, model)
    result.summary["runs"], result.summary["model"] = named["runs"], named["model"]
    return result


def considered(
    runs: "Sequence[Dataset] | Dataset", model: Model, without: Collection[str] = ()
) -> tuple[Considered, ...]:
    """What is said of every effect, surest first; without formulas, errors and pictures."""
    ready, library = prepared(rows_from(runs), model), model.library()

    def attempt(failing: Collection[str]) -> tuple[Considered, ...]:
        effects = {n: e for n, e in library.items() if n not in without and n not in failing}
        return verdict_on(*laid_out(ready, effects), effects).considered

    return without_failing(attempt, {entry.name for entry in model.file.effects})[0]


def laid_out(ready: Prepared, effects: dict[str, Effect]) -> tuple[Prepared, Observations, Design | None]:
    """What was prepared, its observations, and their design; none of too few observations.

    Where few observables have a unit, and where the frame shakes, the noise is what no space follows: it is estimated
    again, and the observations with it.

    Raises `LabrigError` where units, displacements and positions, axes, markers, chambers or set-points are mistaken
    for each other, and there are enough observations to say so.
    """
    observations = observe(ready.context, ready.residual, ready.floor, ready.declared)
    enough = len(observations.values) >= k.FEWEST_OBSERVATIONS
    if enough and (line := ready.misnamed or next(mistaken(ready.context), None)):
        raise LabrigError(f"nothing can be diagnosed: {line}")
    if not enough:
        return ready, observations, None
    design = design_of(observations, effects, ready.nuisance, ready.calibrated)
    if observations.n_captures < k.FEWEST_OBSERVATIONS:
        return ready, observations, design
    if of_few(observations):
        ready = replace(ready, floor=noise_of_few(design))
        observations = observe(ready.context, ready.residual, ready.floor, ready.declared)
        design = design_of(observations, effects, ready.nuisance, ready.calibrated)
    moves = shaken(design)
    if moves.size:
        observations = observations.shaking(moves)
        ready, design = replace(ready, floor=observations.floor), stilled(design, observations)
    return ready, observations, design


def verdict_on(
    ready: Prepared,
    observations: Observations,
    design: Design | None,
    effects: dict[str, Effect],
    tolerance: float | None = None,
) -> Verdict:
    """Which effects are missing, by the evidence of the observations and their design, as they were `laid_out`.

    Raises `LabrigError` where what is measured and what the model says are too far apart in size to be compared.
    """
    floor = observations.unit_size(ready.regression.counted)
    least = (tolerance or 0.0) / floor
    few = underpowered(observations, tuple(effects), least, ready.regression.units, floor)
    if few is not None and design is None:
        return few
    assert design is not None  # there are enough observations
    remembering = {name for name, effect in effects.items() if effect.remembers}
    try:
        search = Search(design).run()
        away = gone(search)  # first: it looks at more forms, which count in the answers
        answers = answers_of(search, least, remembering)
    except np.linalg.LinAlgError:
        if observations.to_explain < 1:  # what is exact leaves nothing to ask
            return few or Verdict("nothing_missing", (), 1.0, (), tuple(Considered(n, 0.0) for n in effects))
        raise LabrigError(
            f"what is measured and what the model says are too far apart in size to be compared (the error is "
            f"{observations.to_explain:.2g} times the noise): check the units of both"
        ) from None
    verdict = decide(answers, tuple(effects), words_of(design), away)
    verdict = with_unseen(verdict, {b.owner for b in (*design.blocks, *design.free)})
    verdict = where_it_acts(verdict, acting_share(search))
    reasons = {n: effects[n].turned_round(ready.context) for n in (*verdict.effects, *verdict.rivals)}
    if turned_round := {name: words for name, words in reasons.items() if words}:
        verdict = taken_back(verdict, turned_round)
    if verdict.verdict == "nothing_missing" and ready.astray:
        return replace(verdict, verdict="unknown", carried_by=ready.astray)
    if verdict.verdict == "nothing_missing":
        return few or verdict
    if part := in_one_part(search):
        look = _OF_CHAMBER if part in ready.context.rows.chambers else _OF_SESSION
        line = f"most of what is missing is in {part} alone: {look}"
        return replace(verdict, warnings=(*verdict.warnings, line))
    return verdict


def words_of(design: Design) -> dict[str, str]:
    """What carries each space without a name, in words, by owner."""
    blocks = [b for b in (*design.blocks, *design.free) if not b.space.alone_in]
    words = {b.owner: b.space.key for b in blocks if b.owner.startswith("?")}
    return words | {
        REST: NOTHING,
        "?" + MOTION: "how the base itself moves",
        "?" + MAP: CUT_OFF,
        CURVE: BY_SET_POINT,
    }


def result_of(
    ready: Prepared, observations: Observations, verdict: Verdict, model: Model, effects: dict[str, Effect]
) -> Result:
    """The verdict with everything that its report shows: formulas, errors, where, the improved model."""
    regression, context = ready.regression, ready.context
    found = alone(regression, context, verdict, effects)
    if verdict.verdict == "unknown":
        verdict = in_its_place(verdict, verdict.taken_back, in_place_of(found, (), verdict.taken_back))
    chosen = _chosen(ready, verdict, effects, found)
    falls = falls_of(chosen, verdict.found)
    idle = {fall.effect for fall in falls if not fall.helps}
    instead = takes_most(found, idle) if idle and idle >= set(verdict.found) else []
    doubted = not_told_apart(
        less_sure(verdict, idle) if idle else verdict, {*instead, *idle} if instead else ()
    )
    doubted = not_told_apart(doubted, alike(context, effects))
    others, sure = in_place_of(found, doubted.effects, together=doubted.together), doubted.effects
    doubted = in_its_place(doubted, sure, others)
    same = same_as(found, doubted.effects)
    doubted = not_told_apart(doubted, same)
    if doubted != verdict:
        verdict = doubted
        chosen = _chosen(ready, verdict, effects, found, idle, instead)
    errors = _errors(ready, chosen, found)
    reachable = max(errors["floor"], errors["ceiling"])
    ranking = ranking_of(regression, found, verdict, errors["base"], reachable)
    places = where(context, ready.residual, ready.floor, regression.counted)
    entries = entries_of(context, chosen) if chosen else []
    unit_size = observations.unit_size(regression.counted)
    unnamed, unnamed_units = _unnamed(observations, verdict, unit_size)
    drop = drop_of(errors["base"], errors["model"], reachable)
    summary: Summary = {
        "verdict": verdict.verdict,
        "effects": list(verdict.effects),
        "probability": verdict.probability,
        "track_record": _counted(verdict) if ready.left_out_share < MANY_LEFT_OUT else None,
        "rivals": list(verdict.rivals),
        "together": list(verdict.together) if verdict.rivals else [],
        "effects_considered": [told(c, unit_size) for c in verdict.considered],
        "units": regression.units,
        "error": errors,
        "error_by_unit": by_unit(
            regression, ready.floor, base=regression.base_left, model=_left(ready, chosen)
        ),
        "where": places,
        "drop": drop,
        "ranking": ranking,
        "next_experiment": _next_experiment(verdict, effects),
        "carried_by": verdict.carried_by or None,
        "unnamed": unnamed,
        "unnamed_units": unnamed_units,
        "floor": ready.floor.told(regression.units),
        "left_out": ready.held_off,
        "left_out_share": ready.left_out_share,
        "warnings": [
            *notes_on(ready, observations, verdict, chosen, falls, unit_size, effects),
            *said_of_same(same),
            *said_of(sure, others),
            *may_be_learnt(model, verdict, effects),
            *learnt_below(verdict, errors["base"], errors["floor"], errors["ceiling"], regression.units),
            *nearly_explained(
                verdict, ranking, errors["base"], errors["model"], errors["floor"], drop, regression.units
            ),
            *rests_on(ready, chosen, verdict),
            *beside_named(chosen, _partners(verdict, found), regression.units),
            *much_left(verdict.effects, errors["base"], errors["model"], errors["floor"], regression.units),
        ],
    }
    return Result(
        summary=summary,
        fields=fields_of(context, ready.residual, chosen),
        waterfall=_waterfall(chosen, errors),
        signatures=signatures_of(context, ready.residual, ready.floor.row, _shown(chosen, verdict, found)),
        where=places,
        improved=reduce(Model.with_effect, entries, model) if entries else None,
    )


def _unnamed(
    observations: Observations, verdict: Verdict, unit_size: float
) -> tuple[dict[str, float], dict[str, str]]:
    """How large what has no name is, by what carries it, in the units of the errors; and the units of what is in one
    sensor alone, whose size is in these.
    """
    rows = observations.context.rows
    numbers = {f"{name} alone": k for k, name in enumerate(rows.observables)}
    own_units = {what: rows.unit[k] for what, k in numbers.items() if what in verdict.beside}
    sizes = {
        what: floors * (observations.unit_size(np.array([numbers[what]])) if what in numbers else unit_size)
        for what, floors in verdict.beside.items()
    }
    return sizes, own_units


def _counted(verdict: Verdict) -> TrackRecord | None:
    """How often such a verdict was right; None where it is that nothing is missing, and less probable than those."""
    doubtful = verdict.verdict == "nothing_missing" and verdict.probability < k.SURE
    return None if doubtful else track_record(verdict.verdict)


def _chosen(
    ready: Prepared,
    verdict: Verdict,
    effects: dict[str, Effect],
    found: Mapping[str, list[Candidate]],
    idle: Collection[str] = (),
    instead: Sequence[str] = (),
) -> Fit | None:
    """The formulas of what is `Verdict.added`, but for those that are `idle`, or of what is there `instead`; forms that
    are `found` are not looked for again.

    A family can be wider than its formulas: an effect of which none can act on these runs is left out.
    """
    if verdict.verdict not in {"identified", "multiple", "confounded"}:
        return None
    names = [n for n in verdict.added if n not in idle] or instead
    known = {n: found.get(n) or forms_of(ready.regression, ready.context, effects[n]) for n in names}
    able = [effects[n] for n in names if known[n]]
    if not able:
        return None
    return fit_named(ready.regression, ready.context, able, forms=lambda effect: known[effect.name])


def _partners(verdict: Verdict, found: Mapping[str, Sequence[Candidate]]) -> list[Candidate]:
    """The forms of what is possible beside what is sure, and by evidence more probably there than not."""
    if verdict.verdict not in {"identified", "multiple"}:
        return []
    there = [c.effect for c in verdict.considered if c.call == "possible" and c.by_evidence >= 0.5]
    return [found[name][0] for name in there if name in found]


def _shown(chosen: Fit | None, verdict: Verdict, found: Mapping[str, Sequence[Candidate]]) -> dict[str, Fit]:
    """The fit in which each effect is shown: what is sure, and each possible one beside it without the others."""
    if chosen is None:
        return {}
    shown = dict.fromkeys(chosen.names, chosen)
    sure = [p for p in chosen.parts if p.effect.name in verdict.effects]
    shown |= {n: fit([*sure, found[n][0]]) for n in verdict.rivals if n in found and n not in shown}
    return shown


def _left(ready: Prepared, chosen: Fit | None) -> Floats:
    """What is left of held-out captures with what was added, (S, K)."""
    return chosen.left if chosen else ready.regression.base_left


def _errors(ready: Prepared, chosen: Fit | None, found: Mapping[str, Sequence[Candidate]]) -> Errors:
    """The errors over held-out captures; the ceiling is that of the learner, or of any model that was tried where that
    is lower, each effect by itself too.
    """
    regression, left = ready.regression, _left(ready, chosen)
    base, model = error_of(regression, regression.base_left), error_of(regression, left)
    tried = [quoted(forms[0].alone) for forms in found.values()]
    learners = ceiling(regression, ready.context, left).values()
    if learner := max(learners, key=lambda c: c.gain, default=None):
        tried.append(error_of(regression, left - learner.heldout))
    return {"base": base, "model": model, "floor": ready.quoted_floor, "ceiling": min(base, model, *tried)}


def _waterfall(chosen: Fit | None, errors: Errors) -> list[tuple[str, float]]:
    """The errors from the base down to the floor, with one effect after the other added."""
    steps = [("base", errors["base"])]
    parts = chosen.parts if chosen else ()
    for i in range(len(parts)):
        added = fit(parts[: i + 1])
        steps.append((f"+ {added.names[-1]}", quoted(added)))
    return [*steps, ("ceiling", errors["ceiling"]), ("floor", errors["floor"])]


def _next_experiment(verdict: Verdict, effects: dict[str, Effect]) -> Next | None:
    """What to measure next, in words, where the verdict is open."""
    if verdict.verdict not in {"confounded", "unknown", "underpowered"} or verdict.carried_by in ASTRAY:
        return None
    names = [n for n in (*verdict.effects, *verdict.rivals) if n in effects]
    return {"separates": names, "probes": [effects[n].experiment for n in names]}
