"""The next experiment: the pressure programme that tells the open explanations apart best per minute."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from labrig._errors import LabrigError, NothingToDoError
from labrig._text import chance
from labrig.contents import Expected, ProbeRow, Proposed, Summary
from labrig.diagnosis import SURE, Explained, Outlook, Prepared, diagnose, prepared, rows_from, shipped
from labrig.effects import Effect
from labrig.experiment._again import Again, again, is_only_way, to_put_back, to_rule_out
from labrig.experiment._experiment import Experiment
from labrig.experiment._plan import Limits, Point, Probe, repeat_labels
from labrig.experiment._probes import by_hand, canonical, on_few_levels
from labrig.experiment._problem import Problem
from labrig.experiment._rivals import Rival, open_rivals, open_sets
from labrig.experiment._search import CHANGES, Choice, Chosen, points_of, search_programme
from labrig.experiment._unknown import in_words, search_unknown
from labrig.model import Model

if TYPE_CHECKING:
    from xarray import Dataset

MINUTES = 10.0
MOST_ROWS = 1500
NAMED = {"identified", "multiple", "confounded"}
"""Verdicts that name something: what is possible beside it is told apart. The others look where least is known."""
_TELLS = 2.0
"""By how much the odds of some pair must be expected to change, or nothing tells them apart."""


def propose_experiment(
    runs: "Sequence[Dataset] | Dataset",
    model: Model,
    *,
    summary: Summary | None = None,
    limits: Limits | None = None,
    minutes: float = MINUTES,
    tolerance: float | None = None,
    without: Sequence[str] = (),
    changes: int = CHANGES,
) -> Experiment:
    """The programme that separates what a diagnosis leaves open, best per minute of laboratory time.

    Args:
        runs: what has been measured so far.
        model: the model that was questioned.
        summary: the diagnosis of these runs; it is made where it is not given.
        limits: what the rig allows; by default what the runs state.
        minutes: the longest that the programme may take.
        tolerance: the smallest effect that matters, for `underpowered`; of a diagnosis that is made here.
        without: names of effects to leave out of the library.
        changes: how often the probes that were chosen are changed a little, and chosen from again.

    Raises:
        LabrigError: the diagnosis leaves nothing open, no programme of this rig would tell, the time is too short for
            any, or the model's prediction does not depend on the pressures.
    """
    if not minutes > 0:
        raise LabrigError(f"an experiment of {minutes:g} min: give it some time")
    if tolerance is not None and summary is not None:
        raise LabrigError("tolerance is for a diagnosis that is made here, and one is given: it has its own")
    rows = rows_from(runs)
    ready = _some(prepared(rows, model))
    context = ready.context
    if context.moves and not context.jacobian.any():
        raise LabrigError(
            "the model predicts the same at all pressures: it can't say which programme would tell effects apart; "
            "give it a base that follows them, such as base: {kind: static, degree: 1}"
        )
    found = (
        diagnose(runs, model, tolerance=tolerance, without=without).summary if summary is None else summary
    )
    effects = {n: e for n, e in model.library().items() if n not in without}
    limits = Limits.of(rows) if limits is None else limits
    verdict = str(found["verdict"])
    if verdict == "nothing_missing":
        raise NothingToDoError("the verdict is nothing_missing: it leaves nothing to settle")
    if name := to_put_back(found, effects, rows):
        before = replace(
            again(ready, effects[name], limits, minutes), back=True, what=f"undo what ruled {name} out"
        )
        if before.tells:
            why = f"{name} was gone once it was ruled out, and something else may have changed in that moment"
            return _only(before, why, ready, found, effects, limits)
    offered = (again(ready, effects[name], limits, minutes) for name in to_rule_out(found, effects))
    suspects = tuple(each for each in offered if each.tells)
    if only := next((each for each in suspects if is_only_way(each, found)), None):
        return _only(only, f"set-points alone never make {only.effect} sure", ready, found, effects, limits)
    sets = open_sets(effects, found) if verdict in NAMED else []
    explained = Explained(ready, {n: effects[n] for names, _ in sets for n in names}) if sets else None
    rivals = tuple(open_rivals(explained, sets)) if explained else ()
    if verdict != "confounded" and verdict in NAMED and not rivals:
        if len(sets) > 1:
            beside = " or ".join(sorted({n for names, _ in sets for n in names} - {*found["effects"]}))
            raise LabrigError(
                f"the verdict is {verdict} and {beside} may be there beside it: more at once than can be told apart; "
                "add what is sure to the model (labrig improve), and diagnose again"
            )
        raise NothingToDoError(
            f"the verdict is {verdict} and no other effect comes near: there is nothing to settle; check it at "
            "other set-points (of a rig that labrig runs: labrig run capture, with another seed)"
        )
    problem = Problem(ready, model.predictor(rows), limits, explained, rivals)
    # what was measured decides where the scattered points fall: proposed again, they fall elsewhere, for a set-point
    # that is visited again and again says no more (see PER_CONDITION of the diagnosis)
    seeds = canonical(context, limits.rest, seed=len(np.unique(rows.capture)))
    slow = bool(context.inside)  # a simulator that solves for each set-point
    if slow:
        seeds = on_few_levels(seeds, limits.rest)
    if rivals:
        choice = search_programme(problem, seeds, 60 * minutes, changes=0 if slow else changes)
        tells = choice is not None and problem.log_bayes(choice.together).max(initial=0.0) >= np.log(_TELLS)
        if not tells and suspects:
            why = f"no programme within the limits tells {_apart(rivals)} apart"
            return _only(suspects[0], why, ready, found, effects, limits)
        if choice is None or not tells:
            raise _nothing_tells(found, rivals, effects, minutes)
        return _named(problem, choice, found, effects, minutes, suspects)
    choice, gains = search_unknown(problem, seeds, 60 * minutes, found.get("carried_by"))
    return _unnamed(problem, choice, gains, found, effects, suspects)


def _only(
    each: Again, why: str, ready: Prepared, found: Summary, effects: Mapping[str, Effect], limits: Limits
) -> Experiment:
    """The experiment where other set-points tell nothing: the same once more, without a suspect."""
    rows = ready.context.rows
    unit = int(ready.regression.counted[0])
    probe: ProbeRow = {
        "probe": each.label,
        "separates": f"{each.effect} from all that does the same",
        "shows": each.why,
        "times": 1,
        "minutes": each.minutes,
    }
    summary: Proposed = {
        "verdict": str(found["verdict"]),
        "separates": [n for n in _names(found, ()) if n in effects],
        "units": rows.unit[unit],
        "actuation_units": rows.actuation_unit,
        "units_of": dict(zip(rows.chambers, rows.own_units, strict=False)),
        "minutes": each.minutes,
        "captures": len(each.points),
        "why": f"{why}; {each.why}",
        "probes": [probe],
        "expected": [],
        "floor": float(np.sqrt(np.mean(ready.floor.row[ready.regression.counted] ** 2))),
        "by_hand": each.said,
        "warnings": [],
    }
    if each.back:
        summary["put_back"] = each.effect
    else:
        summary["ruled_out"] = each.effect
    return Experiment(
        summary=summary,
        points=each.points,
        repeats=tuple(repeat_labels(each.points, limits.rest)),
        labels=(each.label,) * len(each.points),
        limits=limits,
        chambers=rows.chambers,
    )


def _some(ready: Prepared) -> Prepared:
    """Whole captures, evenly spread, of a campaign that is longer than it takes to tell what is open."""
    capture = ready.context.rows.capture
    every = int(np.ceil(len(capture) / MOST_ROWS))
    if every < 2:
        return ready
    _, place = np.unique(capture, return_inverse=True)
    keep = np.flatnonzero(place % every == 0)
    return ready.thin(keep)


def plan_next(runs: "Sequence[Dataset] | Dataset", model: Model, summary: Summary) -> None:
    """Put the short form of the proposed experiment into the `next_experiment` of an open diagnosis.

    Its probes are the canonical ones as they stand: to change them, too, takes several times as long as the diagnosis.
    """
    open_ = summary.get("next_experiment")
    if not open_:
        return
    try:
        found = propose_experiment(runs, model, summary=summary, changes=0).summary
    except LabrigError as error:
        open_["why"] = str(error)
        return
    open_["programme"] = [
        {"probe": p["probe"], "separates": p["separates"], "times": p["times"], "minutes": p["minutes"]}
        for p in found["probes"]
    ]
    open_["minutes"], open_["captures"], open_["why"] = found["minutes"], found["captures"], found["why"]


def _apart(rivals: Sequence[Rival]) -> str:
    return " and ".join(r.title for r in rivals)


def _nothing_tells(
    found: Summary, rivals: Sequence[Rival], effects: Mapping[str, Effect], minutes: float
) -> LabrigError:
    names = _names(found, rivals)
    hands = "; ".join(f"{h['effect']}: {h['what']}" for h in by_hand(names, effects))
    titles = _apart(rivals) or " and ".join(names)
    return LabrigError(
        f"no programme of {minutes:g} min within the rig's limits tells {titles} apart"
        + (f"; by hand: {hands}" if hands else "")
    )


def _named(
    problem: Problem,
    choice: Chosen,
    found: Summary,
    effects: Mapping[str, Effect],
    minutes: float,
    suspects: tuple[Again, ...],
) -> Experiment:
    """The experiment for named rivals, with what it is expected to say."""
    points, owner = points_of(choice)
    behind = problem.log_bayes(choice.together)
    titles = [r.title for r in problem.rivals]
    expected: list[Expected] = [
        {
            "true": titles[m],
            "other": titles[n],
            "apart": problem.unit_size * (floors := _floors(each, choice.together)),
            "floors": floors,
            "log10_bayes": float(each / np.log(10)),
            "settles": bool(each >= goal),
        }
        for (m, n), each, goal in zip(problem.pairs, behind, problem.goals, strict=True)
    ]
    probes: list[ProbeRow] = []
    for title in dict.fromkeys(p.title for p in choice.probes):
        alike = [i for i, p in enumerate(choice.probes) if p.title == title]
        outlook = reduce(Outlook.beside, [choice.outlooks[i] for i in alike])
        alone = problem.log_bayes(outlook)
        best = problem.pairs[int(np.argmax(problem.matters * alone))]
        typical = float(np.average(alone, weights=problem.matters))
        probes.append(
            {
                "probe": title,
                "separates": f"{titles[best[0]]} from {titles[best[1]]}",
                "shows": choice.probes[alike[0]].separates,
                "times": len(alike),
                "minutes": sum(choice.probes[i].seconds(problem.limits) for i in alike) / 60,
                "floors": _floors(typical, outlook),
                "log10_bayes": typical / float(np.log(10)),
            }
        )
    names = _names(found, problem.rivals)
    weakest = min(expected, key=lambda e: e["floors"])
    why = (
        f"fitted again to this programme too, {weakest['other']} would still miss what {weakest['true']} predicts by "
        f"{weakest['floors']:.2g} noise floors; all other pairs are further apart"
        if len(expected) > 1
        else f"{weakest['other']} would miss what {weakest['true']} predicts by {weakest['floors']:.2g} noise floors"
    )
    warnings = [] if all(e["settles"] for e in expected) else [_may_not_settle(expected, minutes)]
    warnings += _never_sure(names, effects)
    made = _experiment(problem, choice, points, owner, found, names, effects, probes, expected, why, warnings)
    return _with(made, suspects)


def _with(made: Experiment, suspects: tuple[Again, ...]) -> Experiment:
    """The same with what a person can rule out besides."""
    ruled_out = [line for each in suspects for line in each.said]
    return replace(
        made, again=suspects, summary={**made.summary, "by_hand": [*ruled_out, *made.summary["by_hand"]]}
    )


def _floors(log_bayes: float, outlook: Outlook) -> float:
    """By how many noise floors, root mean square, numbers are off that give a Bayes factor."""
    return float(np.sqrt(2 * max(log_bayes, 0.0) / (outlook.worth * outlook.numbers)))


def _names(found: Summary, rivals: Sequence[Rival]) -> list[str]:
    """All names that a diagnosis leaves open or takes for sure, each once."""
    return list(dict.fromkeys([*found["effects"], *found["rivals"], *(n for r in rivals for n in r.names)]))


def _may_not_settle(expected: Sequence[Expected], minutes: float) -> str:
    open_ = [f"{e['true']} from {e['other']}" for e in expected if not e["settles"]]
    return f"may not be enough to tell {', '.join(open_)} within {minutes:g} min: allow more, or repeat it"


def _never_sure(names: Sequence[str], effects: Mapping[str, Effect]) -> list[str]:
    """A line for each name that a diagnosis does not call sure, whatever is measured: what confirms it is to look."""
    most = {name: shipped().at_most(name) for name in names if name in effects}
    return [
        f"{name} is never called sure from set-points alone ({chance(p)} at most): they show what else it is not; "
        f"to confirm it: {effects[name].ruled_out_by or effects[name].experiment}"
        for name, p in most.items()
        if p < SURE
    ]


def _unnamed(
    problem: Problem,
    choice: Choice,
    gains: Sequence[float],
    found: Summary,
    effects: Mapping[str, Effect],
    suspects: tuple[Again, ...],
) -> Experiment:
    """The experiment for an error that has no name yet, or that the data are too few to show."""
    points, owner = points_of(choice)
    carried = str(found.get("carried_by") or "")
    unseen = not carried
    probes: list[ProbeRow] = [
        {
            "probe": probe.title,
            "separates": "what was not looked at yet" if unseen else in_words(carried),
            "shows": probe.separates,
            "times": times,
            "minutes": times * probe.seconds(problem.limits) / 60,
            "nats": gain,
        }
        for probe, times, gain in zip(choice.probes, choice.times, gains, strict=True)
    ]
    if not unseen:
        why = (
            f"what is unexplained is carried by {in_words(carried)}: these probes go where a smooth function of it is "
            "least known"
        )
    else:
        why = "these probes go where least is known, and repeat themselves: more numbers, and the noise floor with them"
    names = [n for n in _names(found, ()) if n in effects]
    made = _experiment(problem, choice, points, owner, found, names, effects, probes, [], why, [])
    return _with(made, suspects)


def _experiment(
    problem: Problem,
    choice: Choice,
    points: Sequence[Point],
    owner: Sequence[int],
    found: Summary,
    names: Sequence[str],
    effects: Mapping[str, Effect],
    probes: list[ProbeRow],
    expected: list[Expected],
    why: str,
    warnings: list[str],
) -> Experiment:
    rows = problem.context.rows
    whole = Probe("", "", tuple(points))
    summary: Proposed = {
        "verdict": str(found["verdict"]),
        "separates": list(names),
        "units": rows.unit[int(problem.counted[0])],
        "actuation_units": rows.actuation_unit,
        "units_of": dict(zip(rows.chambers, rows.own_units, strict=False)),
        "minutes": whole.seconds(problem.limits) / 60,
        "captures": len(points),
        "why": why,
        "probes": sorted(probes, key=lambda p: -p.get("log10_bayes", p.get("nats", 0.0))),
        "expected": expected,
        "floor": problem.floor,
        "by_hand": by_hand(names, effects),
        "warnings": warnings,
    }
    return Experiment(
        summary=summary,
        points=tuple(points),
        repeats=tuple(repeat_labels(points, problem.limits.rest)),
        labels=tuple(choice.probes[i].title for i in owner),
        limits=problem.limits,
        chambers=rows.chambers,
    )
