"""The report of a diagnosis: one HTML file that reads like a colleague's note."""

import math
import re
from datetime import datetime
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from labrig._durable import write_whole
from labrig._text import amount, capital, chance, counted, listed, number, percent, word
from labrig.contents import Summary
from labrig.view import _figures
from labrig.view._colours import floor_for_colours
from labrig.view._explorer import surface_explorer
from labrig.view._fields import capture_words, cloud, skin, worst_captures
from labrig.view._naming import added
from labrig.view._page import Page, bar, table
from labrig.view._pressures import pressures
from labrig.view._report_effects import considered, ranking, values
from labrig.view._signature_figure import signature
from labrig.view._style import AFTER, BEFORE, CEILING, FLOOR, VERDICT_COLOURS
from labrig.view._values import units_of
from labrig.view._waterfall import waterfall_svg
from labrig.view._words import fitted_anything, has_improved, meanings, note, runs_in_short

if TYPE_CHECKING:
    from labrig.diagnosis import Result

REPORT_NAME = "report.html"
ROWS_A_GROUP = 6

GROUPS = {
    "marker": "marker",
    "region": "region of the surface",
    "observable": "observable",
    "chamber": "chamber",
    "pair of chambers": "pair of chambers",
    "pressure band": "mean pressure",
    "input band": "mean input",
    "direction": "direction of approach",
    "time in hold": "time in the hold",
    "time in session": "time in the session",
    "input speed": "speed of the input",
    "stretch": "stretch of the record",
}
_ORDERED = ("pressure band", "input band", "time in hold", "time in session", "input speed")


def write_report(result: "Result", folder: str | Path) -> Path:
    """Write `report.html` into `folder` (made if it is missing) and return its path.

    The file is complete in itself: it opens without a network. It is written under another name first, so
    that a report is never half a report.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / REPORT_NAME
    write_whole(path, report_html(result))
    return path


def report_html(result: "Result") -> str:
    """The report as one string of HTML."""
    words = note(result.summary)
    page = Page(f"labrig: {words.headline}")
    _opening(page, result)
    considered(page, result)
    values(page, result)
    _waterfall(page, result)
    ranking(page, result.summary, units_of(result.fields))
    _surface(page, result)
    _where(page, result)
    _signatures(page, result)
    pressures(page, result.fields)
    _captures(page, result)
    _closing(page, result.summary)
    return page.html()


def _opening(page: Page, result: "Result") -> None:
    summary, fields = result.summary, result.fields
    words = note(summary)
    measured = "marker" if fields.sizes.get("marker", 0) else "observable"
    sizes = [counted(fields.sizes["capture"], "capture"), counted(fields.sizes[measured], measured)]
    model = Path(str(summary.get("model") or "")).name
    when = datetime.now().astimezone().strftime("%d %B %Y, %H:%M")
    about = " · ".join(
        filter(None, ["labrig", runs_in_short(summary.get("runs") or []), model, *sizes, when])
    )
    # only where the verdict's own probability is that of all that is said: each effect has one of its own
    alone = summary.get("verdict") in ("nothing_missing", "unknown")
    sure = f", {chance(summary.get('probability'))} sure" if alone else ""
    colour = VERDICT_COLOURS[words.verdict]
    page.add(
        f'<div class="over"><span class="badge" style="background:{colour}">{escape(words.verdict + sure)}</span>'
        f"<span>{escape(about)}</span></div>"
    )
    page.add(f"<h1>{escape(words.headline)}</h1>")
    if words.named:
        whole = words.named.replace(" %", "\u00a0%").replace(" ± ", "\u00a0±\u00a0")
        page.add(f'<p class="lead">{escape(whole)}</p>')
    page.add(f'<p class="lead">{escape(words.why)}</p>')
    for meaning in meanings(summary):
        page.add(f"<p>{escape(meaning)}</p>")
    page.add(_errors(summary))
    answers = [
        ("Alternatives", words.else_),
        ("Next experiment", words.next_),
    ]
    shown = "".join(
        f"<div><h3>{escape(question)}</h3><p>{_with_code(answer)}</p></div>"
        for question, answer in answers
        if answer
    )
    page.add(f'<div class="answers">{shown}</div>')
    if warnings := summary.get("warnings"):
        lines = "".join(f"<p>{escape(str(line))}</p>" for line in warnings)
        page.add(f'<div class="warnings"><h3>Notes</h3>{lines}</div>')


def _errors(summary: Summary) -> str:
    verdict = summary.get("verdict")
    new = added(summary)
    after = "with " + ", ".join(word(name) for name in new) if new else "with the best candidate"
    names = [("base", "the model as it was", BEFORE), ("model", after, AFTER)]
    if not has_improved(summary) and not (summary.get("effects") and not verdict):
        names = [("base" if "base" in summary.get("error", {}) else "model", "the model as it is", AFTER)]
    names += [("ceiling", "predictability bound", CEILING), ("floor", "noise floor", FLOOR)]
    error, units = summary.get("error", {}), escape(str(summary.get("units", "")))
    shown = "".join(
        f'<div class="figure" style="border-color:{colour}"><b>{number(error[key])} <small>{units}</small></b>'
        f"<span>{escape(label)}</span></div>"
        for key, label, colour in names
        if error.get(key) is not None
    )
    words = {key: label for key, label, _ in names}
    others = [
        f"In {escape(unit)}: "
        + listed([f"{escape(words[key])} {number(value)}" for key, value in row.items() if key in words])
        for unit, row in summary.get("error_by_unit", {}).items()
        if unit != summary.get("units")
    ]
    also = f"<p>{'. '.join(others)}.</p>" if others else ""
    return f'<div class="figures">{shown}</div>{also}'


def _waterfall(page: Page, result: "Result") -> None:
    if len(result.waterfall) < 2:
        return
    which = "on held-out captures" if fitted_anything(result.summary) else "of the model as it stands"
    page.section(
        "From the model to the noise",
        f"Root-mean-square error {which}. No model can be better than the noise floor.",
    )
    page.add(waterfall_svg(result.waterfall, str(result.summary.get("units", ""))))


def _surface(page: Page, result: "Result") -> None:
    summary, markers = result.summary, cloud(result.fields)
    units = str(summary.get("units", ""))
    both = has_improved(summary)
    if markers is None:
        page.section(
            "Measured against predicted",
            "Every number that was measured; on the dotted line the model is exact.",
        )
        page.add(page.plot(_figures.fit(result.fields, both)))
        return
    page.section(
        "On the surface",
        "The error of each marker over the campaign, per coordinate as in all tables, in noise floors: the same "
        "colours in every report. Turn it with the mouse; pick a capture to see its shape. Lines: where a chamber "
        "alone moves the surface by half of its most or more.",
    )
    new = listed(added(summary)) or "the best candidate"
    titles = ["Before: the model as it was", f"After: with {new}"] if both else ["The model as it is"]
    names = [capture_words(result.fields, n) for n in range(result.fields.sizes["capture"])]
    surface = skin(markers.rest_mm)
    floor = floor_for_colours(summary.get("error", {}).get("floor"), markers.before_mm)
    surface_explorer(page, markers, surface, floor, units, titles, names)


def _where(page: Page, result: "Result") -> None:
    rows = [row for row in result.where if row["group"] in GROUPS and row["error"] == row["error"]]
    if not rows:
        return
    units, top = str(result.summary.get("units", "")), max(float(row["error"]) for row in rows) or 1.0
    page.section(
        "Where it fails",
        f"Error of the model as it {'was' if has_improved(result.summary) else 'is'}, in {units}, root mean square "
        "per coordinate, and its share of what can be explained. "
        "Pale: not significantly above noise.",
    )
    blocks = []
    for group, title in GROUPS.items():
        inside = sorted((row for row in rows if row["group"] == group), key=lambda row: -row["error"])
        if not inside:
            continue
        shown = inside[:ROWS_A_GROUP]
        if group in _ORDERED:
            shown = sorted(inside, key=lambda row: _first_number(str(row["name"])))
        cells = [
            [
                escape(str(row["name"])),
                bar(row["error"] / top, 150, pale=not row.get("clear", True)),
                number(row["error"]),
                percent(row.get("share")),
            ]
            for row in shown
        ]
        body = table([title, "", f"error, {escape(units)}", "share"], cells, ["", "", "number", "number"])
        blocks.append(f'<div class="plot">{body}</div>')
    page.add(f'<div class="plots">{"".join(blocks)}</div>')


def _first_number(name: str) -> float:
    found = re.match(r"[-+]?[0-9.]+(e[-+]?[0-9]+)?", name)
    return float(found[0]) if found else math.inf


def _signatures(page: Page, result: "Result") -> None:
    if not result.signatures:
        return
    page.section(
        "Signatures",
        "Measured (dots: means; pale: single points) and fitted (line), with all other effects removed.",
    )
    blocks = [
        f'<div class="plot"><h3>{escape(capital(word(item.effect)))}</h3><p class="about">{escape(item.says)}</p>'
        f"{page.plot(signature(item))}</div>"
        for item in result.signatures
    ]
    page.add(f'<div class="plots">{"".join(blocks)}</div>')


def _captures(page: Page, result: "Result") -> None:
    units = str(result.summary.get("units", ""))
    worst, both = worst_captures(result.fields), has_improved(result.summary)
    if not worst:
        return
    page.section("Capture by capture", "The error of every capture in the order in which they were taken.")
    floor = result.summary.get("error", {}).get("floor")
    page.add(page.plot(_figures.over_captures(result.fields, units, floor, both)))
    page.add("<h3>The worst captures</h3>")
    several = len({capture.session for capture in worst}) > 1
    errors = ["before", "after"] if both else ["error"]
    header = ["capture", "set-points", "worst at", *(f"{name}, {escape(units)}" for name in errors)]
    cells = [
        [
            escape(capture.capture + (f" ({capture.session})" if several else "")),
            escape(capture.commanded),
            escape(capture.where),
            *([number(capture.base), number(capture.model)] if both else [number(capture.base)]),
        ]
        for capture in worst
    ]
    page.add(table(header, cells, ["", "", "", "number", "number"][: len(header)]))


def _closing(page: Page, summary: Summary) -> None:
    terms = {
        "Error": "A root mean square over the captures, of markers per coordinate: a distance is 1.73 times as much.",
        "Held out": "Errors are measured on whole blocks of captures that took no part in the fit.",
        "Noise floor": f"What repeats of one set-point with the same history differ by: {amount(summary, 'floor')}.",
    }
    if not fitted_anything(summary):
        del terms["Held out"]
    if summary.get("error", {}).get("ceiling") is not None:
        terms["Predictability bound"] = (
            "The held-out error of a flexible learner that may use everything that was logged: "
            f"{amount(summary, 'ceiling')}. Nothing that was tried predicts what remains below it."
        )
    shown = "".join(f"<dt>{escape(term)}</dt><dd>{escape(text)}</dd>" for term, text in terms.items())
    page.add(f"<footer><dl>{shown}</dl></footer>")


def _with_code(text: str) -> str:
    """Escape, with `words in backquotes` as code."""
    parts = escape(text).split("`")
    return "".join(f"<code>{part}</code>" if i % 2 else part for i, part in enumerate(parts))
