"""What an experiment is told with: its probes, what they are expected to say, and what a person can do besides."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from labrig._text import chance
from labrig.contents import Expected, ProbeRow, Proposed, Summary
from labrig.diagnosis import SURE, Outlook, Prepared, shipped
from labrig.effects import Effect
from labrig.experiment._again import Again
from labrig.experiment._experiment import Experiment
from labrig.experiment._plan import Limits, Probe, repeat_labels
from labrig.experiment._probes import by_hand
from labrig.experiment._problem import Problem
from labrig.experiment._rivals import Rival
from labrig.experiment._search import Choice, Chosen, points_of
from labrig.experiment._unknown import in_words

_LONGER = 10
"""A pair that a programme of so many times the minutes would not settle either is one that set-points do not settle;
what captures say of it adds up."""


@dataclass(frozen=True)
class Asked:
    """What an experiment is to settle: a diagnosis (`found`) of what was measured, the `effects` that it knows, what
    the rig and the time allow, and the `suspects` that a person can take away.
    """

    ready: Prepared
    found: Summary
    effects: Mapping[str, Effect]
    limits: Limits
    minutes: float
    suspects: tuple[Again, ...] = ()


def by_hand_alone(asked: Asked, each: Again, why: str) -> Experiment:
    """The experiment where other set-points tell nothing: the same once more, without a suspect."""
    ready, limits = asked.ready, asked.limits
    counted, rows = ready.regression.counted, ready.context.rows
    probe: ProbeRow = {
        "probe": each.label,
        "separates": f"{each.effect} from all that does the same",
        "shows": each.why,
        "times": 1,
        "minutes": each.minutes,
    }
    summary: Proposed = {
        "verdict": str(asked.found["verdict"]),
        "separates": _known(asked),
        "units": rows.unit[int(counted[0])],
        "actuation_units": rows.actuation_unit,
        "units_of": dict(zip(rows.chambers, rows.own_units, strict=False)),
        "minutes": each.minutes,
        "captures": len(each.points),
        "why": f"{why}; {each.why}",
        "probes": [probe],
        "expected": [],
        "floor": float(np.sqrt(np.mean(ready.floor.row[counted] ** 2))),
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


def for_names(asked: Asked, problem: Problem, choice: Chosen) -> Experiment:
    """The experiment that tells named rivals apart, with what it is expected to say."""
    expected = _expected(problem, choice)
    weakest = min(expected, key=lambda e: e["floors"])
    why = (
        f"fitted again to this programme too, {weakest['other']} would still miss what {weakest['true']} predicts by "
        f"{weakest['floors']:.2g} noise floors; all other pairs are further apart"
        if len(expected) > 1
        else f"{weakest['other']} would miss what {weakest['true']} predicts by {weakest['floors']:.2g} noise floors"
    )
    names = names_of(asked.found, problem.rivals)
    warnings = _not_settled(expected, asked.minutes)
    warnings += _never_sure(names, asked.effects)
    return _made(asked, problem, choice, _probes(problem, choice), why, names, expected, warnings)


def _expected(problem: Problem, choice: Chosen) -> list[Expected]:
    """How far apart each pair of rivals will be, and whether that settles it."""
    titles = [r.title for r in problem.rivals]
    behind = problem.log_bayes(choice.together)
    return [
        {
            "true": titles[m],
            "other": titles[n],
            "apart": problem.unit_size * (floors := _floors(each, choice.together)),
            "floors": floors,
            "log10_bayes": float(each / np.log(10)),
            "settles": bool(each >= goal),
            "outlook": "yes" if each >= goal else "perhaps" if _LONGER * each >= goal else "no",
        }
        for (m, n), each, goal in zip(problem.pairs, behind, problem.goals, strict=True)
    ]


def _probes(problem: Problem, choice: Chosen) -> list[ProbeRow]:
    """Each kind of probe with the pair that it tells apart best."""
    titles = [r.title for r in problem.rivals]
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
    return probes


def for_no_name(asked: Asked, problem: Problem, choice: Choice, gains: Sequence[float]) -> Experiment:
    """The experiment for an error that has no name yet, or that the data are too few to show."""
    carried = str(asked.found.get("carried_by") or "")
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
    return _made(asked, problem, choice, probes, why, _known(asked))


def _floors(log_bayes: float, outlook: Outlook) -> float:
    """By how many noise floors, root mean square, numbers are off that give a Bayes factor."""
    return float(np.sqrt(2 * max(log_bayes, 0.0) / (outlook.worth * outlook.numbers)))


def names_of(found: Summary, rivals: Sequence[Rival] = ()) -> list[str]:
    """All names that a diagnosis leaves open or takes for sure, each once."""
    return list(dict.fromkeys([*found["effects"], *found["rivals"], *(n for r in rivals for n in r.names)]))


def _not_settled(expected: Sequence[Expected], minutes: float) -> list[str]:
    """A line on the pairs that the programme may settle, and one on those that much longer ones do not tell apart."""
    doubts: dict[str, list[str]] = {"perhaps": [], "no": []}
    for e in expected:
        word = e.get("outlook", "perhaps")
        turned = f"{e['other']} from {e['true']}"
        if word in doubts and turned not in doubts["perhaps"] + doubts["no"]:
            doubts[word].append(f"{e['true']} from {e['other']}")
    out = []
    if doubts["perhaps"]:
        pairs = ", ".join(doubts["perhaps"])
        out.append(f"may not be enough to tell {pairs} within {minutes:g} min: allow more, or repeat it")
    if doubts["no"]:
        pairs = ", ".join(doubts["no"])
        out.append(
            f"set-points hardly tell {pairs}, not in {_LONGER} times as long: what is done by hand can"
        )
    return out


def _never_sure(names: Sequence[str], effects: Mapping[str, Effect]) -> list[str]:
    """A line for each name that a diagnosis does not call sure, whatever is measured: what confirms it is to look."""
    most = {name: shipped().at_most(name) for name in names if name in effects}
    return [
        f"{name} is never called sure from set-points alone ({chance(p)} at most): they show what else it is not; "
        f"to confirm it: {effects[name].ruled_out_by or effects[name].experiment}"
        for name, p in most.items()
        if p < SURE
    ]


def _known(asked: Asked) -> list[str]:
    """The names that a diagnosis leaves open or takes for sure, if they are effects."""
    return [n for n in names_of(asked.found) if n in asked.effects]


def _made(
    asked: Asked,
    problem: Problem,
    choice: Choice,
    probes: list[ProbeRow],
    why: str,
    names: Sequence[str],
    expected: Sequence[Expected] = (),
    warnings: Sequence[str] = (),
) -> Experiment:
    """The experiment, and beside it what a person can rule out."""
    rows, limits = problem.context.rows, problem.limits
    points, owner = points_of(choice)
    ruled_out = [line for each in asked.suspects for line in each.said]
    summary: Proposed = {
        "verdict": str(asked.found["verdict"]),
        "separates": list(names),
        "units": rows.unit[int(problem.counted[0])],
        "actuation_units": rows.actuation_unit,
        "units_of": dict(zip(rows.chambers, rows.own_units, strict=False)),
        "minutes": Probe("", "", tuple(points)).seconds(limits) / 60,
        "captures": len(points),
        "why": why,
        "probes": sorted(probes, key=lambda p: -p.get("log10_bayes", p.get("nats", 0.0))),
        "expected": list(expected),
        "floor": problem.floor,
        "by_hand": [*ruled_out, *by_hand(names, asked.effects)],
        "warnings": list(warnings),
    }
    return Experiment(
        summary=summary,
        points=tuple(points),
        repeats=tuple(repeat_labels(points, limits.rest)),
        labels=tuple(choice.probes[i].title for i in owner),
        limits=limits,
        chambers=rows.chambers,
        again=asked.suspects,
    )
