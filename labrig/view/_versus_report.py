"""The report of two models on the same measurements: one page, both errors, and where each is nearer."""

from collections.abc import Callable
from datetime import datetime
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from labrig._text import counted, number
from labrig.contents import PlaceGap, Versus
from labrig.view._colours import floor_for_colours
from labrig.view._explorer import surface_explorer
from labrig.view._fields import capture_words, cloud, skin
from labrig.view._figures import Figure, fit, over_captures
from labrig.view._ik_report import write_page
from labrig.view._page import Page, table
from labrig.view._pictures import error_bars, surface_of
from labrig.view._report import GROUPS, REPORT_NAME
from labrig.view._style import AFTER, BEFORE, FLOOR, MUTED
from labrig.view._versus_figure import differences
from labrig.view._versus_words import difference_words, interval_words, share_words, versus_headline
from labrig.view._words import runs_in_short

if TYPE_CHECKING:
    from labrig.diagnosis import VersusResult

_COLOURS = (BEFORE, AFTER)


def write_versus(result: "VersusResult", folder: str | Path) -> Path:
    """Write `report.html` into `folder` (made if it is missing), in one piece, and return its path."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    return write_page(versus_page(result), folder / REPORT_NAME)


def versus_pictures(result: "VersusResult") -> dict[str, Callable[[], Figure]]:
    """What can be drawn of two models: `error`, `fit`, `captures`, a `surface NAME` each, and `where GROUP`."""
    summary, units, names = result.summary, str(result.summary["units"]), _names(result.summary)
    floor = float(summary["error"]["floor"])
    pictures: dict[str, Callable[[], Figure]] = {"error": partial(error_bars, result.waterfall, units)}
    markers = cloud(result.fields)
    if markers is not None:
        colours = floor_for_colours(floor, markers.before_mm)
        for name, error in zip(names, (markers.before_mm, markers.after_mm), strict=True):
            pictures[f"surface {name}"] = partial(surface_of, markers, error, colours, units)
    pictures["fit"] = partial(fit, result.fields, True, names)
    pictures["captures"] = partial(over_captures, result.fields, units, floor, True, names)
    for group, rows in _by_group(summary).items():
        pictures[f"where {group}"] = partial(differences, rows, names, units)
    return pictures


def versus_page(result: "VersusResult") -> Page:
    """The page, figures included."""
    summary, names = result.summary, _names(result.summary)
    units = str(summary["units"])
    headline = versus_headline(summary)
    page = Page(f"labrig: {headline}")
    _opening(page, result, headline)
    _surface(page, result, names, units)
    _places(page, summary, names, units)
    page.section("Capture by capture", "The error of every capture in the order in which they were taken.")
    page.add(page.plot(over_captures(result.fields, units, summary["error"]["floor"], True, names)))
    page.add(
        "<footer><dl><dt>Error</dt><dd>A root mean square over the captures, of markers per coordinate, of both models "
        "over the same values.</dd><dt>Interval</dt><dd>From a jackknife over blocks of captures, which may depend on "
        "each other within a block. Intervals of places are wider, so that all of one kind hold together.</dd>"
        "<dt>Noise floor</dt><dd>What repeats of one set-point with the same history differ by: "
        f"{number(summary['error']['floor'])} {escape(units)}.</dd></dl></footer>"
    )
    return page


def _names(summary: Versus) -> tuple[str, str]:
    first, second = (str(model["name"]) for model in summary["models"])
    return first, second


def _by_group(summary: Versus) -> dict[str, list[PlaceGap]]:
    rows = [row for row in summary["where"] if row["low"] == row["low"]]
    groups = {group: [row for row in rows if row["group"] == group] for group in GROUPS}
    return {group: inside for group, inside in groups.items() if inside}


def _opening(page: Page, result: "VersusResult", headline: str) -> None:
    summary, fields, names = result.summary, result.fields, _names(result.summary)
    units = escape(str(summary["units"]))
    measured = "marker" if fields.sizes.get("marker", 0) else "observable"
    sizes = [counted(fields.sizes["capture"], "capture"), counted(fields.sizes[measured], measured)]
    when = datetime.now().astimezone().strftime("%d %B %Y, %H:%M")
    about = " · ".join(filter(None, ["labrig", runs_in_short(summary.get("runs") or []), *sizes, when]))
    page.add(
        f'<div class="over"><span class="badge" style="background:{MUTED}">two models</span>'
        f"<span>{escape(about)}</span></div><h1>{escape(headline)}</h1>"
        f'<p class="lead">{escape(difference_words(summary))}</p><p>{escape(share_words(summary))}</p>'
    )
    shown = [(name, summary["error"][name], colour) for name, colour in zip(names, _COLOURS, strict=True)]
    shown.append(("noise floor", summary["error"]["floor"], FLOOR))
    figures = "".join(
        f'<div class="figure" style="border-color:{colour}"><b>{number(value)} <small>{units}</small></b>'
        f"<span>{escape(name)}</span></div>"
        for name, value, colour in shown
    )
    page.add(f'<div class="figures">{figures}</div>')
    if summary["warnings"]:
        lines = "".join(f"<p>{escape(str(line))}</p>" for line in summary["warnings"])
        page.add(f'<div class="warnings"><h3>Notes</h3>{lines}</div>')


def _surface(page: Page, result: "VersusResult", names: tuple[str, str], units: str) -> None:
    markers = cloud(result.fields)
    if markers is None:
        page.section("Measured against predicted", "On the dotted line a model is exact.")
        page.add(page.plot(fit(result.fields, True, names)))
        return
    page.section(
        "On the surface",
        "The error of each marker over the run, per coordinate, in noise floors, with one scale for both models. Turn "
        "it with the mouse; pick a capture to see its shape.",
    )
    floor = floor_for_colours(result.summary["error"]["floor"], markers.before_mm)
    captures = [capture_words(result.fields, n) for n in range(result.fields.sizes["capture"])]
    surface_explorer(page, markers, skin(markers.rest_mm), floor, units, names, captures, names)


def _places(page: Page, summary: Versus, names: tuple[str, str], units: str) -> None:
    groups = _by_group(summary)
    if not groups:
        return
    page.section(
        "Where each is nearer",
        f"Error of “{names[0]}” minus error of “{names[1]}”, {units} rms, with intervals. Right of zero "
        f"“{names[1]}” is nearer, left of it “{names[0]}”. Grey: the run cannot tell.",
    )
    blocks = []
    for group, rows in groups.items():
        figure = page.plot(differences(rows, names, units))
        header = [GROUPS[group], *map(escape, names), "difference"]
        cells = [
            [
                escape(str(row["name"])),
                *map(number, row["error"]),
                "{} ({})".format(*interval_words(row)),
            ]
            for row in rows
        ]
        figures = table(header, cells, ["", "number", "number", "number"])
        blocks.append(
            f'<div class="plot"><h3>{escape(GROUPS[group].capitalize())}</h3>{figure}'
            f"<details><summary>in figures, {escape(units)}</summary>{figures}</details></div>"
        )
    page.add(f'<div class="plots">{"".join(blocks)}</div>')
