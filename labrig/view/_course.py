"""How a verdict sharpened while the campaign ran: probabilities, error and floor over captures, as a still picture."""

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig._text import counted, word
from labrig.view._still import save_still
from labrig.view._style import AFTER, CEILING, FLOOR, GROUPS, INK, LINE, MUTED

if TYPE_CHECKING:
    from labrig.live import Look

COURSE = "diagnosis-live.png"
_SHOWN = 6


def write_course(looks: "Sequence[Look]", ended: str | None, folder: Path) -> Path:
    """Draw looks at a campaign, and why it `ended` early, if it did, to `diagnosis-live.png` in a folder."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    path = folder / COURSE
    figure = Figure(figsize=(8, 6.4), dpi=130, layout="constrained")
    FigureCanvasAgg(figure)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    title = f"After {counted(looks[-1].captures, 'capture')}, {looks[-1].minutes:.1f} min"
    if ended:
        title = "\n".join(textwrap.wrap(f"{title}: {ended}", 88))
    figure.suptitle(title, color=INK, fontsize=11, x=0.02, ha="left")
    _probabilities(upper, looks)
    _errors(lower, looks)
    if ended:
        for axis in (upper, lower):
            axis.axvline(looks[-1].captures, color=INK, linewidth=1.0)
    return save_still(figure, path)


def _probabilities(axis: Any, looks: "Sequence[Look]") -> None:
    from labrig.diagnosis import POSSIBLE, SURE

    captures = [look.captures for look in looks]
    names = {name for look in looks for name in look.probability}
    course = {name: np.array([look.probability.get(name, np.nan) for look in looks]) for name in names}
    order = sorted(names, key=lambda name: -float(np.nansum(course[name] ** 2)))
    shown = [name for name in order if np.nanmax(course[name]) >= POSSIBLE][:_SHOWN]
    axis.axhspan(SURE, 1.03, color=LINE, alpha=0.55, linewidth=0)
    axis.axhspan(-0.03, POSSIBLE, color=LINE, alpha=0.55, linewidth=0)
    for name in order:
        if name not in shown:
            axis.plot(captures, course[name], color=FLOOR, linewidth=0.7, alpha=0.6)
    for k, name in enumerate(shown):
        colour = GROUPS[k % len(GROUPS)]
        axis.plot(captures, course[name], color=colour, marker="o", markersize=4, label=word(name))
    axis.set_ylim(-0.03, 1.03)
    axis.set_ylabel("probability", color=MUTED)
    axis.text(captures[0], 0.965, " sure", color=MUTED, fontsize=8, va="center")
    axis.text(captures[0], 0.04, " out", color=MUTED, fontsize=8, va="center")
    others = len(order) - len(shown)
    if others:
        axis.plot([], [], color=FLOOR, linewidth=0.7, label=f"{others} others")
    axis.legend(frameon=False, fontsize=9, loc="center left", bbox_to_anchor=(1.0, 0.5))
    _plain(axis)


def _errors(axis: Any, looks: "Sequence[Look]") -> None:
    captures = [look.captures for look in looks]
    error = np.array([look.error for look in looks])
    base = np.array([look.base for look in looks])
    floor = np.array([look.floor for look in looks])
    units = looks[-1].units
    lowest = np.maximum(floor, [look.ceiling for look in looks])
    axis.plot(
        captures, base, color=GROUPS[0], linestyle=":", marker="o", markersize=3, label="model as it is"
    )
    axis.plot(captures, error, color=AFTER, marker="o", markersize=4, label="with what was found")
    axis.plot(captures, floor, color=FLOOR, label="noise floor")
    axis.fill_between(captures, lowest, np.maximum(error, lowest), color=CEILING, alpha=0.3, linewidth=0)
    axis.plot(
        [], [], color=CEILING, alpha=0.4, linewidth=6, label=f"left to gain: {looks[-1].left:.2g} {units}"
    )
    axis.set_ylim(bottom=0)
    axis.set_ylabel(f"held-out error, rms, {units}", color=MUTED)
    axis.set_xlabel("captures", color=MUTED)
    axis.xaxis.get_major_locator().set_params(integer=True)
    axis.legend(frameon=False, fontsize=9, loc="center left", bbox_to_anchor=(1.0, 0.5))
    _plain(axis)


def _plain(axis: Any) -> None:
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)
    axis.tick_params(colors=INK, length=0)
