"""The reports of `labrig next` and `labrig investigate`: HTML pages of the same kind as a diagnosis."""

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import cast

from labrig._durable import write_whole
from labrig._text import counted, number, word
from labrig.contents import ProgrammePoint, Proposed, Summary
from labrig.investigation_contents import Confirmation, InvestigationContent, Round
from labrig.view._figures import Figure
from labrig.view._naming import names_in_short
from labrig.view._page import Page, bar, table
from labrig.view._style import AFTER, BEFORE
from labrig.view._waterfall import waterfall_svg

REPORT_NAME = "report.html"
_COLOURS = ("#1f6f8b", "#c0563a", "#7a5ba6", "#4f8a4b", "#d8a23a", "#8d97a3", "#5c123c", "#2f8f83", "#b05fa0")
_VERDICTS = {
    "nothing_missing": "nothing is missing",
    "identified": "identified",
    "multiple": "several effects",
    "confounded": "confounded",
    "unknown": "unknown effect",
    "underpowered": "too few data",
}


def write_experiment(report: Proposed, programme: Sequence[ProgrammePoint], folder: Path) -> Path:
    """Write the page of a proposed experiment (`next.json` and its points) into `folder`; returns its path."""
    separates = " from ".join(word(str(n)) for n in report["separates"]) or "what is open"
    page = Page("labrig: the next experiment")
    _over(
        page,
        "next experiment",
        AFTER,
        [f"rig {report.get('rig', '')}", counted(report["captures"], "capture")],
    )
    without, back = report.get("ruled_out"), report.get("put_back")
    what = (
        f"with {word(without)} ruled out"
        if without
        else f"with {word(back)} as before"
        if back
        else f"to tell {separates}"
    )
    page.add(f"<h1>{report['minutes']:.1f} minutes {escape(what)}.</h1>")
    page.add(f'<p class="lead">Why this one: {escape(str(report["why"]))}.</p>')
    _warnings(page, report["warnings"])
    if without or back:
        _by_hand(page, report, "First, by hand", "The programme is measured once that is done.")
    page.section("What is measured", "Set-point of each chamber over the time of the programme.")
    page.add(page.plot(programme_figure(programme, report["actuation_units"])))
    if not without and not back:
        _probes(page, report)
        _expected(page, report)
        _by_hand(page, report, "By hand", "What no programme can do alone; nothing of it is run unattended.")
    return _write(page, folder)


def _by_hand(page: Page, report: Proposed, title: str, words: str) -> None:
    """What a person could do, if anything."""
    if report["by_hand"]:
        page.section(title, words)
        hands = [[escape(word(str(h["effect"]))), escape(str(h["what"]))] for h in report["by_hand"]]
        page.add(table(["effect", "what to do"], hands))


def write_investigation(report: InvestigationContent, folder: Path) -> Path:
    """Write the page of an investigation (investigation.json) into `folder`; returns its path."""
    page = Page("labrig: an investigation")
    used = f"{report['minutes']:.1f} of {report['budget_min']:g} min on the rig"
    _over(page, str(report["state"]), AFTER if report["state"] == "settled" else BEFORE, [used])
    page.add(f"<h1>{escape(str(report['conclusion']))}</h1>")
    _warnings(page, report["warnings"])
    page.section("Round by round", "Every round's report is behind its name.")
    page.add(
        table(
            ["round", "programme", "captures", "min", "verdict", "what is missing", "error", "floor"],
            [_round(each) for each in report["rounds"]],
            ["", "", "number", "number", "", "", "number", "number"],
        )
    )
    units = str(report.get("units") or "")
    if report.get("waterfall"):
        page.section("From the model to the noise", "Held-out error of all captures, with what was added.")
        page.add(waterfall_svg([(str(n), float(v)) for n, v in report["waterfall"]], units))
    if confirmation := report["confirmation"]:
        _confirmation(page, confirmation, units)
    return _write(page, folder)


def _round(each: Round) -> list[str]:
    name = escape(str(each["round"]))
    link = f'<a href="{escape(report)}">{name}</a>' if (report := each.get("report")) else name
    return [
        link,
        escape(str(each["programme"])),
        str(each["captures"]),
        f"{each['minutes']:.1f}",
        escape(_VERDICTS.get(str(each["verdict"]), str(each["verdict"]))),
        escape(names_in_short(cast(Summary, each))),
        number(each["error"]["model"]),
        number(each["error"]["floor"]),
    ]


def _confirmation(page: Page, found: Confirmation, units: str) -> None:
    page.section("On captures recorded after the verdict", "Another programme, to which nothing was fitted.")
    rows = [
        ["the model as it was", number(found["before"])],
        ["with what was added", number(found["after"])],
        ["repeats differ by", number(found["floor"])],
    ]
    page.add(table(["", f"error, {escape(units)}"], rows, ["", "number"]))


def _over(page: Page, badge: str, colour: str, about: list[str]) -> None:
    shown = escape(" · ".join(["labrig", *(a for a in about if a.strip() != "rig")]))
    page.add(
        f'<div class="over"><span class="badge" style="background:{colour}">{escape(badge)}</span>'
        f"<span>{shown}</span></div>"
    )


def _warnings(page: Page, warnings: Sequence[str]) -> None:
    if warnings:
        lines = "".join(f"<p>{escape(str(line))}</p>" for line in warnings)
        page.add(f'<div class="warnings"><h3>Keep in mind</h3>{lines}</div>')


def _probes(page: Page, report: Proposed) -> None:
    key = "floors" if report["expected"] else "nats"
    about = (
        "Difference: what is left of one explanation when the other is fitted to the probe too, in noise floors."
        if report["expected"]
        else "Information about what is not explained yet, nats."
    )
    page.section("The probes", about)
    top = max((p.get(key, 0.0) for p in report["probes"]), default=1.0) or 1.0
    rows = [
        [
            escape(str(p["probe"])),
            escape(str(p["shows"])),
            escape(str(p["separates"])),
            str(p["times"]),
            f"{bar(p.get(key, 0.0) / top, 90)} {number(p.get(key, 0.0))}",
            f"{p['minutes']:.1f}",
        ]
        for p in report["probes"]
    ]
    header = [
        "probe",
        "shows",
        "separates",
        "times",
        "difference" if key == "floors" else "information",
        "min",
    ]
    page.add(table(header, rows, ["", "", "", "number", "bars", "number"]))


PROMISES_KEPT = (
    "A yes takes the law for one that labrig knows: in the benchmark 14 of 20 such promises were kept "
    "(48 to 85 %)."
)
"""What a promise to settle is worth (benchmarks/RESULTS.md, "Next experiment")."""


def _expected(page: Page, report: Proposed) -> None:
    if not report["expected"]:
        return
    units = escape(str(report["units"]))
    page.section(
        "What it is expected to say",
        f"By what each would be off if another is true, fitted again to everything. {PROMISES_KEPT}",
    )
    rows = [
        [
            escape(str(e["true"])),
            escape(str(e["other"])),
            number(e["apart"]),
            number(e["floors"]),
            e.get("outlook", "perhaps"),
        ]
        for e in report["expected"]
    ]
    header = ["if it is", "this would be off by", units, "floors", "settles it"]
    page.add(table(header, rows, ["", "", "number", "number", ""]))


def programme_figure(programme: Sequence[ProgrammePoint], units: str) -> Figure:
    """Steps of every chamber's set-point, in `units`, over time, as a figure."""
    done = [(p.get("pressure_kpa", {}), p["hold_s"]) for p in programme if not p.get("by_hand")]
    chambers = sorted({c for kpa, _ in done for c in kpa}, key=lambda c: (len(c), c))
    ends = [0.0]
    for _, hold_s in done:
        ends.append(ends[-1] + hold_s / 60)
    data = [
        {
            "type": "scatter",
            "mode": "lines",
            "name": chamber,
            "x": [round(e, 4) for e in ends],
            "y": [*(kpa.get(chamber, 0.0) for kpa, _ in done), 0.0],
            "line": {"shape": "hv", "color": _COLOURS[i % len(_COLOURS)], "width": 1.5},
        }
        for i, chamber in enumerate(chambers)
    ]
    layout = {
        "height": 300,
        "margin": {"l": 50, "r": 10, "t": 10, "b": 40},
        "xaxis": {"title": {"text": "time, min"}},
        "yaxis": {"title": {"text": f"set-point, {units}"}},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
    }
    return {"data": data, "layout": layout}


def _write(page: Page, folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / REPORT_NAME
    write_whole(path, page.html())
    return path
