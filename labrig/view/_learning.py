"""The report of a training: one HTML file with tables and pictures, and the pictures beside it."""

import base64
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from labrig._durable import aside, put_at, write_whole
from labrig.arrays import Floats
from labrig.view._page import Page, table
from labrig.view._style import AFTER, BEFORE, ERROR_SCALE, GROUPS, INK, MUTED, PAPER


@dataclass
class Learning:
    """What a report says: a headline, a line about it, tables (title, head, rows), notes, and pictures by title."""

    headline: str
    lead: str
    tables: list[tuple[str, Sequence[str], Sequence[Sequence[str]]]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    pictures: dict[str, Path] = field(default_factory=dict)


def write_learning(learning: Learning, folder: str | Path) -> Path:
    """Write `report.html` into `folder`; the pictures are put into it. Returns its path."""
    folder = Path(folder)
    page = Page(f"labrig: {learning.headline}")
    page.add(f"<h1>{escape(learning.headline)}</h1><p class='lead'>{escape(learning.lead)}</p>")
    for title, head, rows in learning.tables:
        page.section(title)
        cells = [[escape(cell) for cell in row] for row in rows]
        page.add(table([escape(name) for name in head], cells, ["", *["number"] * (len(head) - 1)]))
    shown = []
    for title, path in learning.pictures.items():
        data = base64.b64encode(path.read_bytes()).decode("ascii")
        image = f'<img alt="{escape(title)}" style="max-width:100%" src="data:image/png;base64,{data}">'
        shown.append(f'<div class="plot"><h3>{escape(title)}</h3>{image}</div>')
    page.add(f'<div class="plots">{"".join(shown)}</div>')
    if learning.notes:
        page.section("Notes")
        page.add("".join(f"<p>{escape(line)}</p>" for line in learning.notes))
    path = folder / "report.html"
    write_whole(path, page.html())
    return path


def draw_maps(
    maps: dict[str, Floats], unit: str, path: str | Path, top: float | None = None, good: bool = False
) -> Path:
    """Draw values over the surface's (u, v), one map (n_u, n_v) a name, all on one scale.

    What is `good` when it is high has colours of its own.
    """
    from matplotlib.colors import LinearSegmentedColormap

    figure, axes = _figure(1, len(maps), (2.6 * len(maps) + 1.0, 3.2))
    top = top or max(float(np.nanmax(values)) for values in maps.values()) or 1.0
    scale = list(ERROR_SCALE) if not good else [(0.0, BEFORE), (0.5, "#f1eee6"), (1.0, AFTER)]
    colours = LinearSegmentedColormap.from_list("values", scale)
    shown = None
    for axis, (name, values) in zip(axes.ravel(), maps.items(), strict=True):
        shown = axis.imshow(
            values.T, origin="lower", extent=(0, 1, 0, 1), vmin=0, vmax=top, cmap=colours, aspect="auto"
        )
        axis.set_title(name, fontsize=10, color=INK)
        axis.set_xlabel("u (across)", color=MUTED, fontsize=9)
        axis.tick_params(labelsize=8)
    axes.ravel()[0].set_ylabel("v (up)", color=MUTED, fontsize=9)
    bar = figure.colorbar(shown, ax=list(axes.ravel()), shrink=0.85, pad=0.02)
    bar.set_label(unit, color=MUTED)
    return save_figure(figure, path)


def draw_lines(
    lines: dict[str, tuple[Floats, Floats]],
    labels: tuple[str, str],
    path: str | Path,
    spread: dict[str, tuple[Floats, Floats]] | None = None,
    log: bool = False,
) -> Path:
    """Draw named lines (x, y), with bands (low, high) where there are any; the first in the colour of the old."""
    figure, axes = _figure(1, 1, (6.4, 3.8))
    axis = axes.ravel()[0]
    colours = (BEFORE, AFTER, *GROUPS[2:])
    for (name, (x, y)), colour in zip(lines.items(), colours * 3, strict=False):
        axis.plot(x, y, color=colour, label=name, marker="o" if len(x) < 30 else None, markersize=4)
        if spread and name in spread:
            axis.fill_between(x, *spread[name], color=colour, alpha=0.18, linewidth=0)
    axis.set_xlabel(labels[0], color=MUTED)
    axis.set_ylabel(labels[1], color=MUTED)
    if log:
        from matplotlib.ticker import FormatStrFormatter, LogLocator, NullLocator

        axis.set_yscale("log")
        axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.yaxis.set_major_formatter(FormatStrFormatter("%g"))
        axis.yaxis.set_minor_locator(NullLocator())
    else:
        axis.set_ylim(bottom=0)
    axis.legend(frameon=False, fontsize=9, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3)
    plain_axis(axis)
    return save_figure(figure, path)


def _figure(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, Any]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=130, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, columns, squeeze=False)
    for axis in axes.ravel():
        axis.set_facecolor(PAPER)
    return figure, axes


def plain_axis(axis: Any) -> None:
    """No frame where there is no axis."""
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)
    axis.tick_params(colors=INK)


def save_figure(figure: Any, path: str | Path) -> Path:
    """Save as PNG, in one piece."""
    path = Path(path)
    with aside(path) as partial:
        figure.savefig(partial, format="png", facecolor=PAPER)
        put_at(partial, path)
    return path
