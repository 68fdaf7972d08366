"""The tables that commands print for a person."""

from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.table import Table

from labrig._text import counted
from labrig.cli._console import new_console
from labrig.contents import Proposed, Summary, Versus
from labrig.investigation_contents import InvestigationContent

_VERDICTS = {
    "nothing_missing": "nothing is missing: the model is as good as the measurements",
    "identified": "one effect is missing",
    "multiple": "several effects are missing",
    "confounded": "an effect is missing, and these data do not determine which",
    "unknown": "an effect is missing that is none of those that labrig knows",
    "underpowered": "too few data, or an effect as small as the tolerance could not be seen",
}
_PERHAPS = "an effect is missing; one that labrig knows fits"
_TOGETHER = "effects are missing that fit together, none of them surely"
_ASTRAY = "some captures are mistaken, and left out; beside them nothing is missing"
_NEARLY = "nothing is surely missing: the model is nearly as good as the measurements"
_BESIDE = "nothing is missing beside what was left out"
_WHERE_ROWS = 6
_PROBES = 4
"""Parts of the next experiment that are named."""
_RANKING_ROWS = 5


def print_summary(summary: Summary, title: str) -> None:
    """Print what diagnosis.json or compare.json says, as a few lines and two small tables."""
    from labrig.view import astray, at_one_moment, much_left_out, none_surely, note, only_perhaps, possible

    console = new_console()
    units = summary["units"]
    error = summary["error"]
    if verdict := summary.get("verdict"):
        if astray(summary):
            meaning = _ASTRAY
        elif verdict == "nothing_missing" and much_left_out(summary):
            meaning = _BESIDE
        elif verdict == "nothing_missing" and possible(summary):
            meaning = _NEARLY
        elif only_perhaps(summary):
            meaning = _PERHAPS
        else:
            meaning = _TOGETHER if none_surely(summary) else _VERDICTS[verdict]
        console.print(f"verdict: {verdict} ({meaning})", highlight=False)
        _print_effects(console, summary)
    _print_errors(console, units, error, summary.get("error_by_unit", {}))
    if ranked := summary.get("ranking"):
        ranking = Table("effect", "form", "held-out error", "drop", title="single-effect ranking")
        for entry in ranked[:_RANKING_ROWS]:
            ranking.add_row(
                entry["effect"],
                entry["form"],
                f"{entry['heldout_error']:.3g} {units}",
                f"{entry['drop'] or 0.0:.0%}",
            )
        console.print(ranking)
    places = [p for p in summary["where"] if p.get("clear")][:_WHERE_ROWS]
    if places:
        whose = "where the old model fails" if title == "improve" else "where it fails"
        table = Table(whose, "", "error", "share", title="significantly above noise")
        for p in places:
            table.add_row(p["group"], p["name"], f"{p['error']:.3g} {units}", f"{p.get('share', 0.0):.0%}")
        console.print(table)
    planned = summary.get("next_experiment") or {}
    if at_one_moment(summary):
        console.print(f"next: {note(summary).next_}", highlight=False)
    elif programme := planned.get("programme"):
        names = list(dict.fromkeys(p["probe"] for p in programme))
        more = len(names) - _PROBES
        shown = "; ".join([*names[:_PROBES], *([f"and {more} more"] if more > 0 else [])])
        console.print(
            f"next: {shown} ({planned.get('minutes', 0.0):.1f} min); labrig next writes it", highlight=False
        )
    for warning in summary.get("warnings", []):
        console.print(f"note: {warning}", highlight=False)


def print_versus(summary: Versus) -> None:
    """Print what comparison.json says of two models: the difference, both errors, and where each is nearer."""
    from labrig.view import difference_words, interval_words, share_words, versus_headline

    console = new_console()
    units, names = summary["units"], [model["name"] for model in summary["models"]]
    for line in (versus_headline(summary), difference_words(summary), share_words(summary)):
        console.print(line, highlight=False, soft_wrap=True)
    _print_errors(console, units, summary["error"], summary.get("error_by_unit", {}))
    for name in names:
        nearer = [row for row in summary["where"] if row["better"] == name][:_WHERE_ROWS]
        if not nearer:
            continue
        table = Table("where", "", *names, f"difference, {units}", title=f"where “{name}” is nearer")
        for column in table.columns[2:]:
            column.justify = "right"
        for row in nearer:
            both = [f"{value:.3g}" for value in row["error"]]
            table.add_row(row["group"], row["name"], *both, interval_words(row)[1])
        console.print(table)
    for warning in summary["warnings"]:
        console.print(f"note: {warning}", highlight=False, soft_wrap=True)


def _print_errors(
    console: Console, units: str, error: Mapping[str, Any], by_unit: Mapping[str, Mapping[str, Any]]
) -> None:
    """The errors, a row for each unit that was measured in."""
    table = Table(title="error, rms" if by_unit else f"error, {units} rms")
    if by_unit:
        table.add_column("in")
    for name in error:
        table.add_column("predictability bound" if name == "ceiling" else name, justify="right")
    for unit, row in (dict(by_unit) | {units: error}).items():
        values = [row.get(name) for name in error]
        shown = [f"{value:.3g}" if isinstance(value, float | int) else "-" for value in values]
        table.add_row(*([unit] if by_unit else []), *shown)
    console.print(table)


def _print_effects(console: Console, summary: Summary) -> None:
    """What is sure and what is possible: some lines, and a table with sizes."""
    from labrig.view import effect_rows, not_it, summary_words, unseen_words

    words = summary_words(summary)
    for line in (words.named, words.whole, words.unnamed):
        if line:
            console.print(line, highlight=False, soft_wrap=True)
    rows = effect_rows(summary)
    shown = [row for row in rows if row[1] in ("sure", "possible")]
    others = [row[0] for row in rows if row[1] == "not it"]
    if shown:
        table = Table(
            "effect",
            "",
            "probability",
            f"size, {summary['units']}",
            "× noise of a capture",
            title="what is missing",
        )
        for column in table.columns[2:]:
            column.justify = "right"
        for row in shown:
            table.add_row(*row)
        console.print(table)
    if others:
        console.print(f"{not_it(summary)}: {', '.join(others)}", highlight=False, soft_wrap=True)
    if unseen := unseen_words(summary):
        console.print(unseen, highlight=False, soft_wrap=True)


def print_experiment(report: Proposed) -> None:
    """The table of probes, what it is expected to say, and why this programme."""
    from labrig.view import PROMISES_KEPT

    console = new_console(highlight=False)
    console.print(
        f"verdict: {report['verdict']}; to separate: {', '.join(report['separates']) or 'what is open'}"
    )
    named = bool(report["expected"])
    last = "difference" if named else "information"
    table = Table(
        "probe", "shows", "separates", "times", last, "min", title=counted(report["captures"], "capture")
    )
    for probe in report["probes"]:
        amount = f"{probe.get('floors', 0.0):.2g} floors" if named else f"{probe.get('nats', 0.0):.2g} nats"
        table.add_row(
            probe["probe"],
            probe["shows"],
            probe["separates"],
            str(probe["times"]),
            amount,
            f"{probe['minutes']:.1f}",
        )
    if "ruled_out" not in report and "put_back" not in report:
        console.print(table)
    if named:
        expected = Table(
            "if it is", "would be off by", "", "settles", title="fitted again to the run and to this"
        )
        for each in report["expected"]:
            off = f"{each['apart']:.2g} {report['units']} ({each['floors']:.2g} floors)"
            expected.add_row(each["true"], each["other"], off, each.get("outlook", "perhaps"))
        console.print(expected)
        if any(each["settles"] for each in report["expected"]):
            console.print(PROMISES_KEPT, soft_wrap=True)
    console.print(f"why this one: {report['why']}", soft_wrap=True)
    console.print(f"takes {report['minutes']:.1f} min")
    for hand in report["by_hand"]:
        takes = f" ({hand['minutes']:.1f} min)" if "minutes" in hand else ""
        console.print(f"by hand, for {hand['effect']}: {hand['what']}{takes}", soft_wrap=True)
    for warning in report["warnings"]:
        console.print(f"note: {warning}", soft_wrap=True)


def print_investigation(content: InvestigationContent) -> None:
    """The table of an investigation's rounds (the content of investigation.json), and how it ended."""
    console, units = new_console(highlight=False), content["units"]
    head = ("round", "programme", "captures", "min", "verdict", "effects", f"error, {units}", "floor")
    table = Table(*head, box=None, pad_edge=False)
    for each in content["rounds"]:
        names = ", ".join(each["effects"]) + (f" (or {', '.join(each['rivals'])})" if each["rivals"] else "")
        error = each["error"]
        table.add_row(
            str(each["round"]),
            each["programme"],
            str(each["captures"]),
            f"{each['minutes']:.1f}",
            each["verdict"],
            names,
            f"{error['model']:.3g}",
            f"{error['floor']:.3g}",
        )
    console.print(table)
    console.print(f"{content['state']}: {content['conclusion']}", soft_wrap=True)
    console.print(f"{content['minutes']:.1f} of {content['budget_min']:g} min used")
    for warning in content["warnings"]:
        console.print(f"note: {warning}", soft_wrap=True)


__all__ = ["print_experiment", "print_investigation", "print_summary", "print_versus"]
