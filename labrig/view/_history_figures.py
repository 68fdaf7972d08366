"""The pictures of a rig's history by name, each made when it is asked for, from the content of history.json."""

import math
from collections.abc import Callable, Sequence
from datetime import datetime, timedelta
from functools import partial
from statistics import median
from typing import TypedDict

from labrig.contents import HistoryChange, HistoryContent
from labrig.view._figures import FONT, Figure, _layout, _plain
from labrig.view._style import AFTER, BEFORE, FLOOR, GROUPS

_PICTURES = {
    "effects": ("effect", "multiple of what the model has"),
    "softness": ("gain", "displacement, {unit}"),
    "error": ("error", "error of the model, {unit} rms"),
    "leaks": ("leak", "leak rate, {unit}"),
    "zeros": ("zero", "reading at rest, {unit}"),
    "markers": ("marker", "distance from where it was at first, {unit}"),
    "cameras": ("frame", "shift of all markers together, mm"),
    "lost": ("lost", "markers not seen, {unit}"),
    "ambient": ("ambient", "{unit}"),
}
"""Each picture: the group of quantities that it shows, and what its axis says."""
_OVERLAID = {"error": "floor"}
_COLOURS = (*(colour for colour in GROUPS if colour != FLOOR), "#5c123c", "#2f8f83", "#b05fa0", "#3b4a8c")
_PLACES = ("marker", "frame")
_TOLD_APART = 9
_FIRST = 5


class Curve(TypedDict):
    """A quantity as it is drawn, and its changes; `sd` is None where it is not known."""

    name: str
    unit: str
    date: list[str]
    y: list[float]
    sd: list[float | None]
    changes: list[HistoryChange]


def history_pictures(content: HistoryContent) -> dict[str, Callable[[], Figure]]:
    """What can be drawn of a history, of these what was read.

    `effects`, `softness`, `error`, `leaks`, `zeros`, `markers`, `cameras`, `lost`, `ambient`.
    """
    there = {quantity["group"] for quantity in content["quantities"]}
    return {
        name: partial(_picture, content, name) for name, (group, _) in _PICTURES.items() if group in there
    }


def changed_pictures(content: HistoryContent) -> list[str]:
    """Those of `history_pictures` in which something changed."""
    return [
        name
        for name in history_pictures(content)
        if any(curve["changes"] for curve in series_of(content, name))
    ]


def series_of(content: HistoryContent, name: str) -> list[Curve]:
    """The curves of a picture: `name`, `unit`, `date`, `y` and `sd` (None where unknown) of each, and its `changes`.

    A place is drawn as its distance from the middle of the first runs of its kind.
    """
    group, _ = _PICTURES[name]
    wanted = (group, _OVERLAID.get(name))
    curves: list[Curve] = []
    for quantity in content["quantities"]:
        if quantity["group"] not in wanted or (group == "frame" and quantity["name"] != "shift"):
            continue
        mine = (quantity["group"], quantity["name"])
        changes = [c for c in content["changes"] if (c["group"], c["name"]) == mine]
        y = [v[0] for v in quantity["value"]]
        if group in _PLACES:
            y = _distances(
                quantity["value"], [content["runs"][number]["kind"] for number in quantity["runs"]]
            )
        dates = [content["runs"][number]["date"] for number in quantity["runs"]]
        curves.append(
            {
                "name": quantity["name"],
                "unit": quantity["unit"],
                "date": dates,
                "y": y,
                "sd": quantity["sd"],
                "changes": changes,
            }
        )
    return curves


def axis_title(name: str, curves: Sequence[Curve]) -> str:
    """What the upright axis of a picture says."""
    return _PICTURES[name][1].format(unit="/".join(dict.fromkeys(curve["unit"] for curve in curves)))


def colour_of(curves: Sequence[Curve], number: int) -> str:
    """Its own for each of a few curves; of many, all but those that changed are as pale as a noise floor."""
    if len(curves) <= _TOLD_APART:
        return _COLOURS[number % len(_COLOURS)]
    changed = [i for i, curve in enumerate(curves) if curve["changes"]]
    return _COLOURS[changed.index(number) % len(_COLOURS)] if number in changed else FLOOR


def _picture(content: HistoryContent, name: str) -> Figure:
    curves = series_of(content, name)
    data: list[Figure] = []
    for number, curve in enumerate(curves):
        colour = colour_of(curves, number)
        stands_out = colour != FLOOR
        data.append(
            {
                "type": "scatter",
                "mode": "lines+markers",
                "name": curve["name"],
                "x": curve["date"],
                "y": _plain(curve["y"]),
                "error_y": {
                    "type": "data",
                    "array": _plain(curve["sd"]),
                    "visible": stands_out,
                    "thickness": 1,
                },
                "line": {"color": colour, "width": 1.5 if stands_out else 0.5},
                "marker": {"size": 5 if stands_out else 2},
                "showlegend": stands_out,
            }
        )
    upright = {"title": {"text": axis_title(name, curves), "font": FONT}}
    lines = [_line(change["date"]) for curve in curves for change in curve["changes"]]
    along = _along([date for curve in curves for date in curve["date"]])
    return {
        "data": data,
        "layout": _layout(xaxis=along, yaxis=upright, shapes=lines + _fitted(content), height=320),
    }


def _along(dates: Sequence[str]) -> Figure:
    """The axis of dates; where there is a single one, that alone: a plot without a length has milliseconds on it."""
    axis: Figure = {"type": "date"}
    if len(set(dates)) == 1:
        day, one = timedelta(days=1), datetime.fromisoformat(dates[0])
        ends = [(one - day).isoformat(" "), (one + day).isoformat(" ")]
        axis |= {"range": ends, "tickvals": [dates[0]], "tickformat": "%Y-%m-%d %H:%M"}
    return axis


def _line(date: str, colour: str = BEFORE) -> Figure:
    """An upright line at a date."""
    place = {"x0": date, "x1": date, "y0": 0, "y1": 1, "xref": "x", "yref": "paper"}
    return {"type": "line", **place, "line": {"color": colour, "width": 1, "dash": "dot"}}


def _fitted(content: HistoryContent) -> list[Figure]:
    """Where the model was fitted, if that is within the runs."""
    fitted, dates = content["fitted_until"], [run["date"] for run in content["runs"]]
    return [_line(fitted, AFTER)] if fitted and dates and min(dates) <= fitted <= max(dates) else []


def _distances(values: Sequence[Sequence[float]], kinds: Sequence[str]) -> list[float]:
    """How far each place is from the middle of the first of the same kind."""
    starts = {}
    for kind in set(kinds):
        first = [value for value, own in zip(values, kinds, strict=True) if own == kind][:_FIRST]
        starts[kind] = [median(axis) for axis in zip(*first, strict=True)]
    return [math.dist(value, starts[kind]) for value, kind in zip(values, kinds, strict=True)]
