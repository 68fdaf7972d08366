"""The next experiment: the pressure programme that tells the open explanations apart best per minute."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from labrig._errors import LabrigError
from labrig.contents import Expected, ProbeRow, ProgrammePoint, Proposed, Summary
from labrig.diagnosis import diagnose, prepare, rows_from
from labrig.effects import Effect, Rows
from labrig.experiment._plan import Limits, Point, Probe, repeat_labels
from labrig.experiment._probes import by_hand, canonical, on_few_levels
from labrig.experiment._rivals import Rival, open_rivals
from labrig.experiment._score import Judge, Problem, Sums
from labrig.experiment._search import CHANGES, Choice, points_of, search_programme
from labrig.experiment._unknown import in_words, search_unknown
from labrig.model import Model

if TYPE_CHECKING:
    from xarray import Dataset

MINUTES = 10.0
MOST_ROWS = 1500
NAMED = {"identified", "multiple", "confounded"}
"""Verdicts that name something: what is possible beside it is told apart. The others look where least is known."""
_TOO_LITTLE = 0.25
"""The share of its goal that some pair must reach, or nothing tells them apart."""


@dataclass(frozen=True)
class Experiment:
    """What to measure next.

    `summary` is the content of next.json; `points` the programme, as shares of each chamber's range, with a
    repeat label and a probe's name for each.
    """

    summary: Proposed
    points: tuple[Point, ...]
    repeats: tuple[str, ...]
    labels: tuple[str, ...]
    limits: Limits = field(repr=False)
    chambers: tuple[str, ...] = ()

    def programme(self) -> list[ProgrammePoint]:
        """The points as the `programme` procedure takes them: chambers that are vented are left out."""
        out: list[ProgrammePoint] = []
        for point, repeat, label in zip(self.points, self.repeats, self.labels, strict=True):
            actuation = self.limits.actuation(point.share)
            named = {c: float(u) for c, u in zip(self.chambers, actuation, strict=True) if u != 0.0}
            hold_s = round(point.hold_s, 2)
            if repeat:
                out.append({"pressure_kpa": named, "hold_s": hold_s, "repeat": repeat, "label": label})
            else:
                out.append({"pressure_kpa": named, "hold_s": hold_s, "label": label})
        return [*out, *self._with_a_person()]

    def _with_a_person(self) -> list[ProgrammePoint]:
        """Points that need somebody at the rig first: offered, left out of an unattended run."""
        asked = [hand for hand in self.summary["by_hand"] if hand["points"]]
        out: list[ProgrammePoint] = []
        for hand in asked:
            middle = self.limits.actuation([0.5 * (r + 1.0) for r in self.limits.rest])
            named = {c: float(u) for c, u in zip(self.chambers, middle, strict=True)}
            label = f"{hand['effect']}, by hand"
            out.append({"hold_s": 4.0, "note": hand["what"], "by_hand": True, "label": label})
            out.append({"pressure_kpa": named, "hold_s": 4.0, "by_hand": True, "label": label})
        return out


def propose_experiment(
    runs: "Sequence[Dataset] | Dataset",
    model: Model,
    *,
    summary: Summary | None = None,
    limits: Limits | None = None,
    minutes: float = MINUTES,
    tolerance: float | None = None,
    without: Sequence[str] = (),
) -> Experiment:
    """The programme that separates what a diagnosis leaves open, best per minute of laboratory time.

    Args:
        runs: what has been measured so far.
        model: the model that was questioned.
        summary: the diagnosis of these runs; it is made where it is not given.
        limits: what the rig allows; by default what the runs state.
        minutes: the longest that the programme may take.
        tolerance: the smallest effect that matters, for `underpowered`.
        without: names of effects to leave out of the library.

    Raises:
        LabrigError: the diagnosis leaves nothing open, no programme of this rig would tell, or the model's
            prediction does not depend on the pressures.
    """
    if not minutes > 0:
        raise LabrigError(f"an experiment of {minutes:g} min: give it some time")
    rows = _some(rows_from(runs))
    regression, context, _, _ = prepare(rows, model)
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
        raise LabrigError("the verdict is nothing_missing: it leaves nothing to settle")
    rivals = open_rivals(regression, context, effects, found) if verdict in NAMED else []
    if verdict != "confounded" and verdict in NAMED and not rivals:
        raise LabrigError(
            f"the verdict is {verdict} and no other effect comes near: there is nothing to settle; check it on a "
            "fresh programme (labrig run capture, with another seed)"
        )
    problem = Problem(regression, context, model.predictor(rows), rivals, limits)
    # what was measured decides where the scattered points fall: proposed again, they fall elsewhere, for a set-point
    # that is visited again and again says no more (see PER_CONDITION of the diagnosis)
    seeds = canonical(context, limits.rest, seed=len(np.unique(rows.capture)))
    slow = bool(context.inside)  # a simulator that solves for each set-point
    if slow:
        seeds = on_few_levels(seeds, limits.rest)
    if rivals:
        choice = search_programme(problem, seeds, 60 * minutes, changes=0 if slow else CHANGES)
        if choice is None:
            raise _nothing_tells(found, rivals, effects, minutes)
        return _named(problem, choice, found, effects, minutes)
    choice, gains = search_unknown(problem, seeds, 60 * minutes, found.get("carried_by"))
    return _unnamed(problem, choice, gains, found, effects)


def _some(rows: Rows) -> Rows:
    """Whole captures, evenly spread, of a campaign that is longer than it takes to tell what is open."""
    every = int(np.ceil(len(rows.capture) / MOST_ROWS))
    if every < 2:
        return rows
    _, place = np.unique(rows.capture, return_inverse=True)
    return rows.thin(place % every == 0)


def plan_next(runs: "Sequence[Dataset] | Dataset", model: Model, summary: Summary) -> None:
    """Put the short form of the proposed experiment into the `next_experiment` of an open diagnosis."""
    open_ = summary.get("next_experiment")
    if not open_:
        return
    try:
        found = propose_experiment(runs, model, summary=summary).summary
    except LabrigError as error:
        open_["why"] = str(error)
        return
    open_["programme"] = [
        {"probe": p["probe"], "separates": p["separates"], "times": p["times"], "minutes": p["minutes"]}
        for p in found["probes"]
    ]
    open_["minutes"], open_["captures"], open_["why"] = found["minutes"], found["captures"], found["why"]


def _nothing_tells(
    found: Summary, rivals: Sequence[Rival], effects: Mapping[str, Effect], minutes: float
) -> LabrigError:
    names = _names(found, rivals)
    hands = "; ".join(f"{h['effect']}: {h['what']}" for h in by_hand(names, effects))
    titles = " and ".join(r.title for r in rivals) or " and ".join(names)
    return LabrigError(
        f"no programme of {minutes:g} min within the rig's limits tells {titles} apart"
        + (f"; by hand: {hands}" if hands else "")
    )


def _named(
    problem: Problem, choice: Choice, found: Summary, effects: Mapping[str, Effect], minutes: float
) -> Experiment:
    """The experiment for named rivals, with what it is expected to say."""
    points, owner = points_of(choice)
    layout = problem.lay_out([points], by_point=True)
    judge = Judge(layout, problem.rivals)
    total = layout.programmes[0]
    apart = judge.apart(total)
    goals = np.array([judge.goal(m) for m, _ in judge.pairs])
    if (apart / goals).max(initial=0.0) < _TOO_LITTLE:
        raise _nothing_tells(found, problem.rivals, effects, minutes)
    titles = [r.title for r in problem.rivals]
    floor = float(np.sqrt(np.mean(problem.regression.floor.row[problem.counted] ** 2)))
    per_capture = len(points) * problem.regression.residual.shape[1]
    # the errors of one capture hang together: as many numbers count as there are patterns that stand clear
    cautious = 0.5 / np.log(10) * problem.regression.n_patterns / problem.regression.residual.shape[1]
    expected: list[Expected] = [
        {
            "true": titles[m],
            "other": titles[n],
            "apart": floor * float(np.sqrt(a / per_capture)),
            "floors": float(np.sqrt(a / per_capture)),
            "log10_bayes": float(cautious * a),
            "settles": bool(a >= g),
        }
        for (m, n), a, g in zip(judge.pairs, apart, goals, strict=True)
    ]
    probes: list[ProbeRow] = []
    for name in dict.fromkeys(p.name for p in choice.probes):
        alike = [i for i, p in enumerate(choice.probes) if p.name == name]
        own = [layout.points[0][k] for k in range(len(points)) if owner[k] in alike]
        alone = judge.apart(_sum(own))
        best = judge.pairs[int(np.argmax(judge.matters * alone))]
        seconds = sum(choice.times[i] * choice.probes[i].seconds(problem.limits) for i in alike)
        probes.append(
            {
                "probe": name,
                "separates": f"{titles[best[0]]} from {titles[best[1]]}",
                "shows": choice.probes[alike[0]].separates,
                "times": sum(choice.times[i] for i in alike),
                "minutes": seconds / 60,
                "floors": float(
                    np.sqrt(
                        np.average(alone, weights=judge.matters)
                        / (len(own) * problem.regression.residual.shape[1])
                    )
                ),
                "log10_bayes": float(cautious * np.average(alone, weights=judge.matters)),
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
    return _experiment(problem, choice, points, owner, found, names, effects, probes, expected, why, warnings)


def _names(found: Summary, rivals: Sequence[Rival]) -> list[str]:
    """All names that a diagnosis leaves open or takes for sure, each once."""
    return list(dict.fromkeys([*found["effects"], *found["rivals"], *(n for r in rivals for n in r.names)]))


def _may_not_settle(expected: Sequence[Expected], minutes: float) -> str:
    open_ = [f"{e['true']} from {e['other']}" for e in expected if not e["settles"]]
    return f"may not be enough to tell {', '.join(open_)} within {minutes:g} min: allow more, or repeat it"


def _unnamed(
    problem: Problem,
    choice: Choice,
    gains: Sequence[float],
    found: Summary,
    effects: Mapping[str, Effect],
) -> Experiment:
    """The experiment for an error that has no name yet, or that the data are too few to show."""
    points, owner = points_of(choice)
    carried = str(found.get("carried_by") or "")
    unseen = not carried
    probes: list[ProbeRow] = [
        {
            "probe": probe.name,
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
    return _experiment(problem, choice, points, owner, found, names, effects, probes, [], why, [])


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
        "minutes": whole.seconds(problem.limits) / 60,
        "captures": len(points),
        "why": why,
        "probes": sorted(probes, key=lambda p: -p.get("log10_bayes", p.get("nats", 0.0))),
        "expected": expected,
        "floor": float(np.sqrt(np.mean(problem.regression.floor.row[problem.counted] ** 2))),
        "by_hand": by_hand(names, effects),
        "warnings": warnings,
    }
    return Experiment(
        summary=summary,
        points=tuple(points),
        repeats=tuple(repeat_labels(points, problem.limits.rest)),
        labels=tuple(choice.probes[i].name for i in owner),
        limits=problem.limits,
        chambers=rows.chambers,
    )


def _sum(parts: Sequence[Sums]) -> Sums:
    out = parts[0]
    for part in parts[1:]:
        out = out + part
    return out
