"""The pictures of a rig's history by name, each made when it is asked for, from the content of history.json."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from labrig.view._figures import FONT, Figure, _layout, _plain
from labrig.view._style import AFTER, BEFORE, FLOOR, GROUPS, MUTED

_PICTURES = {
    "effects": ("effect", "multiple of what the model has"),
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
_COLOURS = (*GROUPS, "#5c123c", "#2f8f83", "#b05fa0")
_PLACES = ("marker", "frame")
_TOLD_APART = 9


def history_pictures(content: dict[str, Any]) -> dict[str, Callable[[], Figure]]:
    """What can be drawn of a history: `effects`, `error`, `leaks`, `zeros`, `markers`, `cameras`, `lost`, `ambient`."""
    there = {quantity["group"] for quantity in content["quantities"]}
    return {
        name: partial(_picture, content, name) for name, (group, _) in _PICTURES.items() if group in there
    }


def series_of(content: dict[str, Any], name: str) -> list[dict[str, Any]]:
    """The curves of a picture: `name`, `unit`, `date`, `y` and `sd` (None where unknown) of each, and its `changes`.

    A place is drawn as its distance from the middle of its first runs.
    """
    group, _ = _PICTURES[name]
    wanted = (group, _OVERLAID.get(name))
    curves = []
    for quantity in content["quantities"]:
        if quantity["group"] not in wanted or (group == "frame" and quantity["name"] != "shift"):
            continue
        mine = (quantity["group"], quantity["name"])
        changes = [c for c in content["changes"] if (c["group"], c["name"]) == mine]
        y = [v[0] for v in quantity["value"]]
        if group in _PLACES:
            start = [_median([v[a] for v in quantity["value"][:5]]) for a in range(3)]
            y = [math.dist(v, start) for v in quantity["value"]]
        dates = [content["runs"][number]["date"] for number in quantity["runs"]]
        curves.append(
            {"name": quantity["name"], "unit": quantity["unit"], "date": dates, "y": y, "sd": quantity["sd"]}
            | {"changes": changes}
        )
    return curves


def axis_title(name: str, curves: Sequence[dict[str, Any]]) -> str:
    """What the upright axis of a picture says."""
    return _PICTURES[name][1].format(unit="/".join(dict.fromkeys(curve["unit"] for curve in curves)))


def colour_of(curves: Sequence[dict[str, Any]], number: int) -> str:
    """Its own for each of a few curves; of many, only those that changed stand out."""
    if len(curves) <= _TOLD_APART:
        return _COLOURS[number % len(_COLOURS)]
    changed = [i for i, curve in enumerate(curves) if curve["changes"]]
    return _COLOURS[changed.index(number) % len(_COLOURS)] if number in changed else FLOOR


def _picture(content: dict[str, Any], name: str) -> Figure:
    curves = series_of(content, name)
    data: list[Figure] = []
    for number, curve in enumerate(curves):
        colour = colour_of(curves, number)
        stands_out = colour != FLOOR or len(curves) <= _TOLD_APART
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
    return {"data": data, "layout": _layout(yaxis=upright, shapes=lines + _fitted(content), height=320)}


def _line(date: str, colour: str = BEFORE) -> Figure:
    """An upright line at a date."""
    place = {"x0": date, "x1": date, "y0": 0, "y1": 1, "xref": "x", "yref": "paper"}
    return {"type": "line", **place, "line": {"color": colour, "width": 1, "dash": "dot"}}


def _fitted(content: dict[str, Any]) -> list[Figure]:
    """Where the model was fitted, if that is within the runs."""
    fitted, dates = content["fitted_until"], [run["date"] for run in content["runs"]]
    return [_line(fitted, AFTER)] if fitted and dates and min(dates) <= fitted <= max(dates) else []


def _median(values: Sequence[float]) -> float:
    return sorted(values)[len(values) // 2]


def write_history_picture(content: dict[str, Any], path: Any) -> None:
    """Write the whole history as one still picture, whole or not at all; the ending names the format."""
    import os
    from datetime import datetime

    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Canvas

    names = [name for name in _PICTURES if name in history_pictures(content)]
    rows = math.ceil(len(names) / 2)
    figure = Canvas(figsize=(12, 2.6 * rows + 0.6), dpi=130, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(f"{content['rig']}: {len(content['runs'])} runs", fontsize=14)
    for place, name in enumerate(names):
        axes = figure.add_subplot(rows, 2, place + 1)
        curves = series_of(content, name)
        for number, curve in enumerate(curves):
            colour = colour_of(curves, number)
            days = [datetime.fromisoformat(date) for date in curve["date"]]
            sd = [math.nan if each is None else each for each in curve["sd"]]
            grey = colour == FLOOR and len(curves) > _TOLD_APART
            if grey:
                axes.plot(days, curve["y"], color=colour, linewidth=0.5)  # type: ignore[arg-type]
            else:
                axes.errorbar(
                    days,
                    curve["y"],
                    sd,
                    color=colour,
                    marker="o",
                    markersize=3,
                    linewidth=1,
                    label=curve["name"],
                )  # type: ignore[arg-type]
            for change in curve["changes"]:
                axes.axvline(datetime.fromisoformat(change["date"]), color=BEFORE, linestyle=":", linewidth=1)  # type: ignore[arg-type]
        axes.set_ylabel(axis_title(name, curves), fontsize=8, color=MUTED)
        axes.tick_params(labelsize=8)
        if axes.get_legend_handles_labels()[1]:
            axes.legend(fontsize=7, frameon=False, ncols=3)
    temporary = path.with_name(f".{os.getpid()}-{path.name}")
    try:
        figure.autofmt_xdate(rotation=0, ha="center")
        figure.savefig(temporary)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
