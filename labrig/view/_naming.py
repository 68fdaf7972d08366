"""Sure, possible, not it: what a diagnosis says of each effect, in words."""

from dataclasses import dataclass
from math import inf, sqrt
from typing import TYPE_CHECKING

from labrig._text import capital, chance, give_or_take, listed, with_unit, word
from labrig.contents import Summary, TrackRecord

if TYPE_CHECKING:
    from labrig.effects import Effect

UNSEEN = "can't be seen"
"""What is said of an effect that the runs could not show."""
WORTH_SAYING = 0.1  # of the floor: what is smaller, and has no name, is not spoken of

_ENOUGH = 10
"""How often a name must have been sure for it to be said how often it was there."""

_CARRIES = {
    "form": "is a structural error of the base model: chambers move the rig in other patterns than it predicts",
    "where chambers act": "comes from chambers that act in other places than the base model assumes",
    "how the base itself moves": "is a structural error of the base model: all move another way than it predicts, as "
    "places beside them do, or by another curve of the pressures",
    "a curve of the set-points": "is a curve of the set-points, which only effects that remember would hold: look at "
    "what the model, or a sensor, says at each of them",
    "curves that the fitted map lacks": "is a curve of the set-points, which the map that was fitted as base may lack",
    "captures that have each other's measurements": "is in captures that have each other's measurements, and which are "
    "left out of these figures",
    "single set-points that a chamber missed": "is in single captures, in which a chamber did not do what it "
    "was told, and which are left out of these figures",
    "pressures together": "depends on several pressures together",
    "another curve of the pressure": "is another curve of the pressure, in another pattern than the model has",
    "place": "is the same at all pressures",
    "time in hold": "changes within the holds",
    "time": "changes over the session",
    "time through the pressures": "changes over the session, as an error of the pressures",
    "history through the pressures": "depends on earlier pressures, as an error of the pressures",
    "history": "depends on earlier pressures (history-dependent)",
    "other chambers through the pressures": "depends on the pressures of the other chambers",
    "use so far through the pressures": "grows with how much the chambers have been moved",
    "a plane in space": "comes as markers pass a plane in space, as where other cameras take over",
    "what was recorded beside": "follows another logged quantity",
    "what rises during a hold": "rises during a hold, as no leak does: chambers that fill slowly, or a body that "
    "creeps; hold longer, and put set-points at which nothing was measured (a vent between captures) into the table",
    "what is ahead of the input": "is ahead of the input: compare the clocks of input and measurement, and the lags of "
    "the model; a viscous force is ahead, too",
    "nothing that was recorded": "follows no logged quantity",
}


_ASTRAY = {"single set-points that a chamber missed", "captures that have each other's measurements"}


def astray(summary: Summary) -> bool:
    """Whether nothing is missing but what single captures were left out for."""
    return summary.get("verdict") == "unknown" and summary.get("carried_by") in _ASTRAY


@dataclass(frozen=True)
class Called:
    """One effect: what is said of it, how probable it is, and how large it would be, in units and in floors.

    `call` is sure, possible, not it, or `UNSEEN` where the runs have nothing that it could be seen by.
    """

    effect: str
    call: str
    probability: float | None = None
    size: float | None = None
    size_sd: float | None = None
    size_floors: float | None = None
    size_sd_floors: float | None = None

    @property
    def name(self) -> str:
        """The effect as a word."""
        return word(self.effect)


def called(summary: Summary) -> list[Called]:
    """Every effect that was considered, surest first; of an older diagnosis, those that it names."""
    out = []
    for row in summary.get("effects_considered") or []:
        sizes = ("size", "size_sd", "size_floors", "size_sd_floors")
        there = row.get("size") or 0.0
        known = {key: row.get(key) for key in sizes} if there > 0 else {}
        seen = row.get("seen", True)
        call, probability = (str(row["call"]), row.get("probability")) if seen else (UNSEEN, None)
        out.append(Called(str(row["effect"]), call, probability, **known))
    seen = {one.effect for one in out}
    for key, call in (("effects", "sure"), ("rivals", "possible")):
        names = dict.fromkeys(str(name) for name in summary.get(key) or [])
        out += [Called(name, call) for name in names if name not in seen]
        seen |= set(names)
    return out


def sure(summary: Summary) -> list[Called]:
    """The effects that are sure."""
    return [one for one in called(summary) if one.call == "sure"]


def possible(summary: Summary) -> list[Called]:
    """The effects that may be there, or not."""
    return [one for one in called(summary) if one.call == "possible"]


def names(found: list[Called]) -> list[str]:
    """The names alone."""
    return [one.effect for one in found]


def at_one_moment(summary: Summary) -> bool:
    """Whether what is missing, and has no name, began at one moment: nobody learns more of it from set-points."""
    return str(summary.get("carried_by")).startswith("a sudden change")


def only_perhaps(summary: Summary) -> bool:
    """Whether one name is all that is left, and not sure."""
    return summary.get("verdict") == "confounded" and not sure(summary) and len(possible(summary)) == 1


def unseen_words(summary: Summary) -> str:
    """The effects that these runs could not show, and what they need, as a sentence; empty where there are none."""
    from labrig.effects import library

    known = library()
    unseen = [one.effect for one in called(summary) if one.call == UNSEEN]
    needs = {name: needed(summary, known.get(name), name) for name in unseen}
    each = [f"{word(name)} (needs {needs[name]})" if needs[name] else word(name) for name in unseen]
    return f"can't be seen in these runs: {', '.join(each)}" if each else ""


def needed(summary: Summary, effect: "Effect | None", name: str) -> str:
    """What runs must have for an effect to show; where it was ruled out in all of these, one in which it was not."""
    runs = summary.get("runs") or []
    if runs and all(name in run.get("ruled_out", ()) for run in runs):
        return "a run in which it was not ruled out"
    return effect.needs if effect else ""


def added(summary: Summary) -> list[str]:
    """What the model of `error.model` has and the base has not: what is sure, else the likeliest beside it too."""
    effects = [str(name) for name in summary.get("effects") or []]
    if summary.get("verdict") == "confounded":
        effects += partners(summary) or [str(name) for name in (summary.get("rivals") or [])[:1]]
    return list(dict.fromkeys(effects))


def partners(summary: Summary) -> list[str]:
    """Of the rivals those that the likeliest explanation has together, with what is sure."""
    together = summary.get("together") or ()
    return [str(name) for name in summary.get("rivals") or () if name in together]


def none_surely(summary: Summary) -> list[str]:
    """Those of them where there are several: they are no alternatives, and yet none is sure."""
    return several if len(several := partners(summary)) > 1 else []


def size_words(one: Called, units: str) -> str:
    """`2.1 ± 0.1 mm`; nothing where an effect has no size."""
    return "" if one.size is None else with_unit(give_or_take(one.size, one.size_sd), units)


def naming(summary: Summary) -> str:
    """`hysteresis, sure (over 99 %, 2.1 ± 0.1 mm); possible beside it: regulator (34 %); ...`."""
    verdict, units = str(summary.get("verdict", "")), str(summary.get("units", ""))
    if verdict == "underpowered":
        return "the data are too few or too noisy"
    probability = summary.get("probability")
    certain, perhaps = sure(summary), possible(summary)
    parts = []
    if verdict == "nothing_missing":
        parts.append(f"{chance(probability)} sure")
    if astray(summary):
        parts.append(f"nothing is missing beside captures that were left out, {chance(probability)} sure")
    elif verdict == "unknown":
        parts.append(f"an effect that labrig does not know, {chance(probability)} sure")
    if certain:
        parts.append(" and ".join(_with_figures(one, units) for one in certain))
    elif verdict == "confounded":
        parts += [] if only_perhaps(summary) else ["nothing is sure"]
    if perhaps:
        beside = "" if not certain else " beside it" if len(certain) == 1 else " beside them"
        shown = ", ".join(
            f"{one.name} ({chance(one.probability)})" if one.probability is not None else one.name
            for one in perhaps
        )
        if only_perhaps(summary):
            parts.append(f"perhaps {shown}, or an effect that labrig does not know")
        elif several := none_surely(summary):
            parts.append(f"possible{beside}: {shown}; {listed(several)} fit together, none of them surely")
        else:
            needless = ", neither needed nor ruled out"
            parts.append(
                f"possible{beside}: {shown}"
                f"{needless if verdict in ('identified', 'multiple') else '; these data do not determine it'}"
            )
    return "; ".join(parts)


def effect_rows(summary: Summary) -> list[tuple[str, str, str, str, str]]:
    """Every effect as a row of words: name, call, probability, size, size in floors; none where nothing was weighed."""
    found = called(summary)
    if summary.get("verdict") == "underpowered" and not any(one.probability for one in found):
        return []
    return [
        (
            one.name,
            one.call,
            chance(one.probability),
            give_or_take(one.size, one.size_sd),
            give_or_take(one.size_floors, one.size_sd_floors),
        )
        for one in found
    ]


def names_in_short(summary: Summary) -> str:
    """For the cell of a table: `hysteresis (sure); regulator 34 %, stiffening 12 %`."""
    certain, perhaps = sure(summary), possible(summary)
    parts = [f"{', '.join(one.name for one in certain)} (sure)"] if certain else []
    if perhaps:
        shown = (f"{one.name} {chance(one.probability)}" if one.probability else one.name for one in perhaps)
        parts.append(("perhaps " if certain else "") + " or ".join(shown))
    return "; ".join(parts)


def _with_figures(one: Called, units: str) -> str:
    figures = [chance(one.probability)] if one.probability is not None else []
    figures += [size_words(one, units)] if one.size is not None else []
    return f"{one.name}, sure" + (f" ({', '.join(figures)})" if figures else "")


def share_of_all(summary: Summary) -> str:
    """How probable the answer is as a whole, why what evidence is sure of is not, and how often such a verdict was
    right; empty where nothing is known.
    """
    return " ".join(filter(None, (_share_of_all(summary), _less_than_evidence(summary), _counted(summary))))


def _less_than_evidence(summary: Summary) -> str:
    """Why a name is possible only that evidence alone is sure of, where that is what such names were worth; of one
    that is doubted for another reason a warning says why.
    """
    from labrig.diagnosis import SURE, calibration

    said = []
    for row in summary.get("effects_considered") or ():
        name, by_evidence = row["effect"], row.get("by_evidence", 0.0)
        worth = calibration().of_name(name, by_evidence, row.get("share", 1.0), row.get("gone", 0.5))
        if row["call"] == "possible" and by_evidence >= SURE > worth:
            said.append(
                f"Evidence alone makes {word(name)} {chance(by_evidence)}, but such names were there less often, on "
                f"laws that nothing was learnt from.{_never_sure(name)}"
            )
    return " ".join(said)


def _never_sure(name: str) -> str:
    """That more measurements make a name no surer, and what would tell, where it is so."""
    from labrig.diagnosis import SURE, calibration
    from labrig.effects import library

    most, effect = calibration().at_most(name), library().get(name)
    if most >= SURE or effect is None:
        return ""
    return (
        f" Set-points alone never make it sure ({chance(most)} at most); what confirms it: "
        f"{confirmed_by(effect)}."
    )


def not_it(summary: Summary) -> str:
    """What is said of the effects that are neither sure nor possible: where something without a name explains most, one
    of them may be there by a law of its own.
    """
    return "not it" + (
        ", unless by a law that labrig does not know" if summary.get("verdict") == "unknown" else ""
    )


def confirmed_by(effect: "Effect") -> str:
    """What confirms an effect that set-points alone do not: whatever law it follows."""
    return (
        f"{effect.ruled_out_by}, and measure again (labrig next)"
        if effect.ruled_out_by
        else effect.experiment
    )


def _counted(summary: Summary) -> str:
    """How often such a verdict was right, and each name that is sure."""
    counted = [*_of_verdict(summary.get("track_record")), *_of_names(summary)]
    return f"On laws and rigs that nothing was learnt from, {'; '.join(counted)}." if counted else ""


def _of_verdict(record: TrackRecord | None) -> list[str]:
    if not record:
        return []
    right, of = record["right"], record["of"]
    if "there" not in record:
        return [f"{right} of {of} such verdicts were right"]
    return [
        f"what such a verdict names was there {record['there']} times of {of}, and nothing else {right} times"
    ]


def _of_names(summary: Summary) -> list[str]:
    rows = [row for row in summary.get("effects_considered") or () if row["call"] == "sure"]
    known = [(row["effect"], found) for row in rows if (found := row.get("track_record"))]
    return [
        f"{word(name)} was sure {found['of']} times, and there {found['there']} times"
        for name, found in known
        if found["of"] >= _ENOUGH
    ]


def _share_of_all(summary: Summary) -> str:
    probability = summary.get("probability")
    if probability is None:
        return ""
    match summary.get("verdict"):
        case "identified" | "multiple":
            effects = listed([str(name) for name in summary.get("effects") or []])
            return f"Probability of {effects} and nothing else: {chance(probability)}."
        case "confounded" if len(possible(summary)) > 1:
            return f"Probability that at least one of the possible effects is missing: {chance(probability)}."
        case _:
            return ""


def carries(what: str) -> str:
    """What carries something without a name, as the end of a sentence about it."""
    if what.endswith(" alone"):
        return f"is in {what}: look at its calibration, its cable and its mount first"
    return _CARRIES.get(what, f"is carried by {what}")


def unnamed_words(summary: Summary) -> str:
    """What has no name, with its size, in a sentence; empty where nothing of it is worth a word.

    Nothing is said to be larger than what the named effects leave of the held-out error above the floor.
    """
    error = summary.get("error") or {}
    units, floor = str(summary.get("units", "")), error.get("floor") or 0.0
    own = summary.get("unnamed_units") or {}  # of one sensor alone
    left, after = inf, error.get("model")
    if summary.get("verdict") in ("identified", "multiple") and after is not None:
        left = sqrt(max(after**2 - floor**2, 0.0))
    found = sorted((summary.get("unnamed") or {}).items(), key=lambda item: -item[1])
    here = {what: what not in own or own[what] == units for what, _ in found}
    sizes = [(what, min(size, left) if here[what] else size) for what, size in found]
    shown = [(what, size) for what, size in sizes if not here[what] or size > WORTH_SAYING * floor]
    if not shown:
        return ""
    parts = [f"{with_unit(f'{size:.2g}', own.get(what, units))} {carries(what)}" for what, size in shown]
    return f"Unexplained by any effect: {'; '.join(parts)}."


def naming_sentences(summary: Summary) -> list[str]:
    """All of it as sentences, for a report: who, how probable as a whole, and what has no name."""
    said = [f"{capital(naming(summary))}.", share_of_all(summary), unnamed_words(summary)]
    return [sentence for sentence in said if sentence]
