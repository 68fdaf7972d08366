"""The next experiment: the pressure programme that tells the open explanations apart best per minute."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from labrig._errors import LabrigError, NothingToDoError
from labrig._text import listed
from labrig.contents import Summary
from labrig.diagnosis import SURE, Explained, Prepared, diagnose, prepared, rows_from
from labrig.effects import Rows
from labrig.experiment._again import Again, again, is_only_way, to_put_back, to_rule_out
from labrig.experiment._experiment import Experiment
from labrig.experiment._plan import Limits, Probe
from labrig.experiment._probes import by_hand, canonical, on_few_levels
from labrig.experiment._problem import Problem
from labrig.experiment._rivals import Rival, open_rivals, open_sets
from labrig.experiment._search import CHANGES, search_programme
from labrig.experiment._told import Asked, by_hand_alone, for_names, for_no_name, names_of
from labrig.experiment._unknown import search_unknown
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
    if ready.context.moves and not ready.context.jacobian.any():
        raise LabrigError(
            "the model predicts the same at all pressures: it can't say which programme would tell effects apart; "
            "give it a base that follows them, such as base: {kind: static, degree: 1}"
        )
    if summary is None:
        summary = diagnose(runs, model, tolerance=tolerance, without=without).summary
    if summary["verdict"] == "nothing_missing":
        raise NothingToDoError("the verdict is nothing_missing: it leaves nothing to settle")
    effects = {n: e for n, e in model.library().items() if n not in without}
    asked = Asked(ready, summary, effects, Limits.of(rows) if limits is None else limits, minutes)
    if (back := _put_back(asked, rows)) is not None:
        return back
    asked = replace(asked, suspects=_suspects(asked))
    if only := next((each for each in asked.suspects if is_only_way(each, summary)), None):
        return by_hand_alone(asked, only, f"set-points alone never make {only.effect} sure")
    explained, rivals = _rivals(asked)
    problem = Problem(ready, model.predictor(rows), asked.limits, explained, rivals)
    seeds = _seeds(asked, captures=len(np.unique(rows.capture)))
    if not rivals:
        choice, gains = search_unknown(problem, seeds, 60 * minutes, summary.get("carried_by"))
        return for_no_name(asked, problem, choice, gains)
    choice = search_programme(problem, seeds, 60 * minutes, changes=0 if _is_slow(asked) else changes)
    if choice is not None and problem.log_bayes(choice.together).max(initial=0.0) >= np.log(_TELLS):
        return for_names(asked, problem, choice)
    if asked.suspects:
        why = f"no programme within the limits tells {_apart(rivals)} apart"
        return by_hand_alone(asked, asked.suspects[0], why)
    raise _nothing_tells(asked, rivals)


def _put_back(asked: Asked, rows: Rows) -> Experiment | None:
    """The experiment that undoes what ruled an effect out, where that would make it sure."""
    name = to_put_back(asked.found, asked.effects, rows)
    if not name:
        return None
    once_more = again(asked.ready, asked.effects[name], asked.limits, asked.minutes)
    if not once_more.tells:
        return None
    why = f"{name} was gone once it was ruled out, and something else may have changed in that moment"
    return by_hand_alone(asked, replace(once_more, back=True, what=f"undo what ruled {name} out"), why)


def _suspects(asked: Asked) -> tuple[Again, ...]:
    """What a person can take away, and measure again."""
    names = to_rule_out(asked.found, asked.effects)
    offered = (again(asked.ready, asked.effects[name], asked.limits, asked.minutes) for name in names)
    return tuple(each for each in offered if each.tells)


def _rivals(asked: Asked) -> tuple[Explained | None, tuple[Rival, ...]]:
    """What is open, if it has names, explained; raises `LabrigError` where a name is sure and nothing comes near."""
    verdict, effects = str(asked.found["verdict"]), asked.effects
    if verdict not in NAMED:
        return None, ()
    sets = open_sets(effects, asked.found)
    explained = Explained(asked.ready, {n: effects[n] for names, _ in sets for n in names}) if sets else None
    rivals = tuple(open_rivals(explained, sets)) if explained else ()
    if rivals or verdict == "confounded":
        return explained, rivals
    if len(sets) > 1:
        beside = " or ".join(sorted({n for names, _ in sets for n in names} - {*asked.found["effects"]}))
        raise LabrigError(
            f"the verdict is {verdict} and {beside} may be there beside it: more at once than can be told apart; "
            "add what is sure to the model (labrig improve), and diagnose again"
        )
    raise NothingToDoError(
        f"the verdict is {verdict} and no other effect comes near: there is nothing to settle; check it at "
        "other set-points (of a rig that labrig runs: labrig run capture, with another seed)"
    )


def _seeds(asked: Asked, captures: int) -> list[Probe]:
    """The probes that a programme is chosen from.

    What was measured decides where the scattered points fall: proposed again, they fall elsewhere, for a set-point that
    is visited again and again says no more (see PER_CONDITION of the diagnosis).
    """
    context, rest = asked.ready.context, asked.limits.rest
    seeds = canonical(context, rest, seed=captures)
    return on_few_levels(seeds, rest) if _is_slow(asked) else seeds


def _is_slow(asked: Asked) -> bool:
    """Whether effects act inside a simulator, which solves for each set-point."""
    return bool(asked.ready.context.inside)


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
    open_["unsettled"] = [f"{e['true']} from {e['other']}" for e in found["expected"] if not e["settles"]]


def _apart(rivals: Sequence[Rival]) -> str:
    return " and ".join(r.title for r in rivals)


def _nothing_tells(asked: Asked, rivals: Sequence[Rival]) -> LabrigError:
    names = names_of(asked.found, rivals)
    hands = "; ".join(f"{h['effect']}: {h['what']}" for h in by_hand(names, asked.effects))
    titles = _apart(rivals) or " and ".join(names)
    return LabrigError(
        f"no programme of {asked.minutes:g} min within the rig's limits tells {titles} apart"
        + (f"; by hand: {hands}" if hands else "")
        + _as_clear_as_can_be(asked.found)
    )


def _as_clear_as_can_be(summary: Summary) -> str:
    """What to do with a name that evidence is sure of, and that such names are seldom enough right to be."""
    clear = [
        str(each["effect"])
        for each in summary.get("effects_considered") or ()
        if each["call"] == "possible" and each.get("by_evidence", 0.0) >= SURE
    ]
    if not clear:
        return ""
    return (
        f"; what was measured is as clear on {listed(clear)} as it gets: add it (labrig improve), and see whether it "
        "predicts a run with other set-points better (labrig compare)"
    )
