"""A rig's history as one still picture, for pages and notebooks."""

import math
from datetime import datetime
from pathlib import Path
from typing import Any

from labrig.contents import HistoryContent
from labrig.view._history_figures import Curve, axis_title, colour_of, history_pictures, series_of
from labrig.view._still import save_still
from labrig.view._style import BEFORE, FLOOR, INK, MUTED


def write_history_picture(content: HistoryContent, path: Path) -> Path:
    """Draw every quantity of a history (the content of history.json) over the dates; the ending names the format.

    It is written under another name first, so that a picture is never half a picture.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    names = list(history_pictures(content))
    rows = math.ceil(len(names) / 2)
    figure = Figure(figsize=(12, 2.5 * rows + 0.6), dpi=130, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(
        f"{content['rig']}, {len(content['runs'])} runs", fontsize=14, color=INK, fontweight="bold"
    )
    for place, name in enumerate(names):
        _draw(figure.add_subplot(rows, 2, place + 1), name, series_of(content, name))
    return save_still(figure, path)


def _draw(axes: Any, name: str, curves: list[Curve]) -> None:
    from matplotlib.dates import AutoDateLocator, ConciseDateFormatter, date2num

    for number, curve in enumerate(curves):
        colour = colour_of(curves, number)
        days = date2num([datetime.fromisoformat(date) for date in curve["date"]])
        if colour == FLOOR:
            axes.plot(days, curve["y"], color=colour, linewidth=0.5)
            continue
        sd = [math.nan if each is None else each for each in curve["sd"]]
        style = {"color": colour, "marker": "o", "markersize": 3, "linewidth": 1, "elinewidth": 0.7}
        axes.errorbar(days, curve["y"], sd, label=curve["name"], **style)
        for change in curve["changes"]:
            begins = date2num(datetime.fromisoformat(change["date"]))
            axes.axvline(begins, color=BEFORE, linestyle=":", linewidth=1)
    locator = AutoDateLocator()
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(ConciseDateFormatter(locator))
    axes.set_ylabel(axis_title(name, curves), fontsize=8, color=MUTED)
    axes.tick_params(labelsize=8)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(fontsize=7, frameon=False, ncols=3)
