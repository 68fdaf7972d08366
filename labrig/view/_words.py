"""A verdict in words: what a colleague would write on top of the pictures."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

from labrig._text import amount, capital, counted, listed, number, percent, with_unit, word
from labrig.contents import MANY_LEFT_OUT, HeldOff, Next, RunNamed, Summary
from labrig.view._naming import (
    added,
    astray,
    at_one_moment,
    carries,
    names,
    naming,
    naming_sentences,
    none_surely,
    only_perhaps,
    possible,
    share_of_all,
    sure,
    unnamed_words,
)
from labrig.view._others import what_else

VERDICTS = {
    "nothing_missing": "nothing missing",
    "identified": "identified",
    "multiple": "several effects",
    "confounded": "confounded",
    "unknown": "unknown effect",
    "underpowered": "too few data",
}


AFTER_IMPROVING = (
    "Run `labrig diagnose` with the new model to see whether anything else is missing, preferably on a new run with "
    "other set-points, another order and other holds."
)
MOST_NAMED = 3  # of the effects that are possible, in a headline; of runs, above it
STANDS_OUT = 1.15  # an error worth a word, as a multiple of the usual one


@dataclass(frozen=True)
class Note:
    """The words of a report, as plain text: the verdict's name, one headline, and short answers.

    `named` says which effect is sure and which is possible, with what probability and how large.
    """

    verdict: str
    headline: str
    why: str
    else_: str
    next_: str
    named: str = ""


def has_improved(summary: Summary) -> bool:
    """Whether there is a before and an after to show."""
    base, model = (summary.get("error", {}).get(which) for which in ("base", "model"))
    return base is not None and model is not None and model < 0.995 * base


def fitted_anything(summary: Summary) -> bool:
    """Whether effects were fitted at all: not in a comparison."""
    return "base" in summary.get("error", {})


def note(summary: Summary) -> Note:
    """Put a diagnosis into words, or a comparison or an improvement, which have no verdict."""
    verdict = str(summary.get("verdict", ""))
    if verdict not in VERDICTS and summary.get("effects"):
        return Note("improved model", _improved(summary), _where(summary), "", AFTER_IMPROVING)
    if verdict not in VERDICTS:
        return Note("comparison", _compared(summary), _where(summary), "", _after_comparison(summary))
    return Note(
        VERDICTS[verdict],
        _headline(summary),
        _why(summary),
        what_else(summary),
        next_experiment(summary),
        " ".join(naming_sentences(summary)) if verdict != "underpowered" else "",
    )


@dataclass(frozen=True)
class Lines:
    """A result in single lines, for a terminal."""

    headline: str
    found: str
    named: str = ""
    whole: str = ""
    unnamed: str = ""


def summary_words(summary: Summary) -> Lines:
    """What a command prints about a diagnosis, a comparison or an improvement."""
    words = note(summary)
    if str(summary.get("verdict", "")) not in VERDICTS:
        return Lines(words.headline, words.verdict)
    named = naming(summary)
    return Lines(
        words.headline, f"{words.verdict}: {named}", named, share_of_all(summary), unnamed_words(summary)
    )


def much_left_out(summary: Summary) -> bool:
    """Whether more was left out as mistaken than single mistakes, or a marker or sensor through whole holds."""
    return bool(summary.get("left_out")) or summary.get("left_out_share", 0.0) >= MANY_LEFT_OUT


def _headline(summary: Summary) -> str:
    effects = [str(name) for name in summary.get("effects", [])]
    match summary.get("verdict"):
        case "nothing_missing" if off := summary.get("left_out"):
            return f"Nothing is missing beside what was left out: {_held_off(off)}."
        case "nothing_missing" if much_left_out(summary):
            share = percent(summary["left_out_share"])
            return f"Nothing is missing beside {share} of the values, which were left out as mistaken."
        case "nothing_missing" if perhaps := names(possible(summary)):
            may = f"{listed(perhaps, 'or')} may be missing"
            return f"Nothing is surely missing: the model is nearly as good as the measurements, and {may}."
        case "nothing_missing":
            return "Nothing is missing: the model is as good as the measurements."
        case "identified":
            return f"{capital(listed(effects))} is missing from the model."
        case "multiple":
            return f"{capital(listed(effects))} are missing from the model."
        case "confounded":
            perhaps = [name for name in names(possible(summary)) if name not in effects]
            if len(perhaps) == 1 and not effects:
                return f"An effect is missing: perhaps {listed(perhaps)}, or one that labrig does not know."
            several = none_surely(summary)
            if not effects and several:
                return f"Effects are missing that fit together, none of them surely: {listed(several)}."
            if not effects:
                return f"An effect is missing, and these data do not determine which: {_either(perhaps)}."
            known = f"{capital(listed(effects))} {'is' if len(effects) == 1 else 'are'} missing"
            return f"{known}, and these data do not determine whether {_either(perhaps)} is missing too."
        case "unknown" if astray(summary):
            return "Some captures are mistaken, and left out; beside them nothing is missing."
        case "unknown":
            if certain := names(sure(summary)):
                return f"Besides {listed(certain)}, an effect is missing that is none of those that labrig knows."
            if possible(summary):
                return "An effect is missing, more probably none of those that labrig knows."
            return "An effect is missing, and it is none of those that labrig knows."
        case _:
            return "The data are too few or too noisy for a verdict."


def _held_off(found: list[HeldOff]) -> str:
    """`M3 in 3 captures (by up to 14.6 mm)`, of each."""
    each = []
    for one in found[:MOST_NAMED]:
        count = len(one["captures"])
        by = with_unit(number(one["error"]), one["units"])
        each.append(f"{one['name']} in {count} capture{'s' if count > 1 else ''} (off by up to {by})")
    more = [f"{len(found) - MOST_NAMED} others"] if len(found) > MOST_NAMED else []
    return listed([*each, *more])


def _either(effects: list[str]) -> str:
    if len(effects) > MOST_NAMED:
        return f"{', '.join(word(name) for name in effects[:MOST_NAMED])} or one of {len(effects) - MOST_NAMED} others"
    return listed(effects, "or")


def _why(summary: Summary) -> str:
    base, model, floor = (amount(summary, which) for which in ("base", "model", "floor"))
    floor_words = f"the noise floor is {floor}"
    match summary.get("verdict"):
        case "nothing_missing":
            return (
                f"The model's error on held-out captures is {base}, and {floor_words}: nothing is left to explain. "
                + _where(summary)
            ).strip()
        case "underpowered":
            return f"The model's error is {base}, and {floor_words}; an effect that matters could be hidden in it."
        case "unknown":
            carried = summary.get("carried_by")
            what = carries(str(carried)) if carried else "is carried by something that was not logged"
            return (
                f"The model's error is {base}, and {floor_words}. The unexplained part {what}. The "
                "predictability bound, the error of a flexible learner on everything that was logged, is "
                f"{amount(summary, 'ceiling')}. " + _where(summary)
            ).strip()
    chosen, likeliest = added(summary), ""
    if len(chosen) > len(summary.get("effects", [])):
        likeliest = ", the likeliest of what is possible,"
    with_what = f"with {listed(chosen)}{likeliest} added" if chosen else "with the best candidate added"
    share = _explained(summary)
    explained = f" That is {share} of the explainable error." if share else ""
    error = summary.get("error", {})
    rises = (error.get("model") or 0.0) > (error.get("base") or 0.0)
    return (
        f"The held-out error {'rises' if rises else 'falls'} from {base} to {model} {with_what}; "
        f"{floor_words}.{explained} " + _where(summary, "The model as it was fails")
    ).strip()


def _known(effect: str, what: str) -> str:
    """What the library says of an effect, on one line; nothing of an effect that it does not have."""
    from labrig.effects import library

    known = library().get(effect)
    return " ".join(str(getattr(known, what)).split()).rstrip(".") if known else ""


def meanings(summary: Summary) -> list[str]:
    """One sentence on each effect that was found."""
    texts = [(str(name), _known(str(name), "meaning")) for name in summary.get("effects", [])]
    return [f"{capital(word(name))}: {text[0].lower()}{text[1:]}." for name, text in texts if text]


def _explained(summary: Summary) -> str:
    error = summary.get("error", {})
    base, model = error.get("base"), error.get("model")
    bottom = [value for value in (error.get("floor"), error.get("ceiling")) if value is not None]
    if base is None or model is None or not bottom or base <= max(bottom):
        return ""
    return percent(min(1.0, (base - model) / (base - max(bottom))))


def _where(summary: Summary, start: str = "It fails") -> str:
    """The two clearest places of the failure that stand out from the rest."""
    error = summary.get("error", {})
    usual = error.get("base", error.get("model")) or 0.0
    clear = [
        row
        for row in summary.get("where", [])
        if row.get("clear", True) and row.get("error") is not None and row["error"] > STANDS_OUT * usual
    ]
    sentences = []
    for group, form in (
        ("marker", "at marker {name}"),
        ("observable", "in {name}"),
        ("time in hold", "{name} into the hold"),
        ("time in session", "{name} into the session"),
        ("input speed", "where the input goes at {name}"),
        ("pressure band", "at mean pressures of {name}"),
        ("input band", "at mean inputs of {name}"),
        ("direction", "on strokes that go {name}"),
        ("chamber", "with {name}"),
        ("pair of chambers", "with {name}"),
    ):
        rows = [row for row in clear if row.get("group") == group]
        if len(rows) >= 1:
            worst = max(rows, key=lambda row: row["error"])
            sentences.append(
                form.format(name=worst["name"])
                + f" ({number(worst['error'])}\u00a0{summary.get('units', '')})"
            )
        if len(sentences) == 2:
            break
    return f"{start} most {' and '.join(sentences)}." if sentences else ""


def _programme(planned: Next) -> str:
    """A proposed programme in two sentences."""
    names = list(dict.fromkeys(str(p["probe"]).replace(": ", ", ") for p in planned.get("programme", [])))
    separates = [str(name) for name in planned.get("separates", [])]
    sure = planned.get("unsettled") == []  # a file of before does not say
    would = "would" if sure or len(separates) < 2 else "aims to"
    what = f"tell {listed(separates)} apart" if len(separates) > 1 else "learn more"
    caution = "" if would == "would" else ", and may not settle it by itself"
    minutes, captures = (
        f"{planned.get('minutes', 0.0):.1f} min",
        counted(int(planned.get("captures", 0)), "capture"),
    )
    probes = "; ".join(names)
    does = f"{would} {what}{caution}"
    return f"A programme of {minutes} and {captures} {does}: {probes}. `labrig next` writes it for your rig."


def next_experiment(summary: Summary) -> str:
    """What to measure next, in a sentence; what follows from the verdict where no experiment was designed."""
    if at_one_moment(summary):
        return (
            "Look at what happened to the rig at that moment: hoses, seams, markers, what lies on it. Then measure the "
            "same set-points again; if the change stays, diagnose the captures after it by themselves."
        )
    planned = summary.get("next_experiment") or {}
    if planned.get("programme"):
        return _programme(planned)
    if only_perhaps(summary):
        return _confirm(names(possible(summary)))
    probes = list(dict.fromkeys(str(probe).rstrip(".") for probe in planned.get("probes", [])))
    if probes:
        known = summary.get("effects", []) if summary.get("verdict") == "confounded" else []
        separated = [str(name) for name in planned.get("separates", []) if name not in known]
        why = f"To tell {listed(separated)} apart: " if len(separated) > 1 else "To be sure: "
        if known and len(separated) == 1:
            why = f"To learn whether {listed(separated)} is there too: "
        return why + "; or ".join(probes) + ". `labrig next` makes a procedure of it."
    match summary.get("verdict"):
        case "nothing_missing" if much_left_out(summary):
            return "Find what makes so many values wrong, and measure these again: what they hide is in no verdict."
        case "nothing_missing":
            return "None needed. More repeats of the same set-points would reveal smaller effects."
        case "identified" | "multiple":
            return _confirm([str(name) for name in summary.get("effects", [])])
        case "unknown" if astray(summary):
            return "Put right what the warnings say of single captures, and measure these again."
        case "confounded" | "unknown":
            return "Run `labrig next` for the pressure programme that best separates the explanations."
        case _:
            return "Repeat the same set-points more often, with the same history before each."


def _confirm(effects: list[str]) -> str:
    isolate = "; ".join(probe for name in effects if (probe := _known(name, "experiment")))
    return (f"Experiment that isolates it: {isolate}. " if isolate else "") + (
        "To confirm it, add it to the model, and measure a new run with other set-points, another order and other "
        "holds: a wrong effect may fit this run, but it does not predict another."
    )


def _compared(summary: Summary) -> str:
    return f"The model's error is {amount(summary, 'model')}; the noise floor is {amount(summary, 'floor')}."


def _improved(summary: Summary) -> str:
    base, model = amount(summary, "base"), amount(summary, "model")
    effects = listed([str(name) for name in summary.get("effects", [])])
    if has_improved(summary):
        return f"With {effects} the held-out error falls from {base} to {model}."
    return f"Adding {effects} does not help: the held-out error goes from {base} to {model}."


def _after_comparison(summary: Summary) -> str:
    error = summary.get("error", {})
    model, floor = error.get("model"), error.get("floor")
    if model is None or floor is None:
        return ""
    if model > 1.5 * floor:
        return "Run `labrig diagnose` with the same arguments to find out which effect is missing."
    return "The model's error is close to the noise floor."


def runs_in_short(runs: Sequence[RunNamed]) -> str:
    """The runs that a result is about, each with the folder that it lies in; of many the first. Empty for none."""
    named = ["/".join(PurePosixPath(each["run"]).parts[-2:]) for each in runs]
    return ", ".join(named) if len(named) <= MOST_NAMED else f"{named[0]} and {len(named) - 1} more runs"
