"""A still picture of a result, for papers and pages: the surface before and after, and the waterfall."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig._text import number, word
from labrig.arrays import Floats
from labrig.view._colours import STEPS, error_colours, floor_for_colours, rgb
from labrig.view._fields import (
    Cloud,
    cloud,
    residuals,
    rms,
    skin,
)
from labrig.view._naming import added
from labrig.view._space import view_axes
from labrig.view._still import save_still
from labrig.view._style import AFTER, BEFORE, CEILING, ERROR_SCALE, FLOOR, INK, MUTED
from labrig.view._words import has_improved, note

if TYPE_CHECKING:
    from labrig.diagnosis import Result

LIGHT = np.array([-0.45, 0.35, 0.82])  # to the right, up, towards who looks


def write_picture(result: "Result", path: str | Path) -> Path:
    """Write a result as a picture; the ending names the format (.png, .pdf, .svg). Returns the path.

    It is written under another name first, so that a picture is never half a picture.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure = Figure(figsize=(11, 4.6), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(note(result.summary).headline, fontsize=15, color=INK, fontweight="bold")
    markers = cloud(result.fields)
    columns = figure.add_gridspec(1, 3, width_ratios=(1, 1, 1.15))
    if markers is None:
        _errors(figure.add_subplot(columns[0, :2]), result)
    else:
        _surfaces([figure.add_subplot(columns[0, k]) for k in (0, 1)], markers, result)
    _waterfall(figure.add_subplot(columns[0, 2]), result)
    return save_still(figure, path)


def _surfaces(axes: list[Any], markers: Cloud, result: "Result") -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, LogNorm

    both = has_improved(result.summary)
    before, after = markers.before_mm, markers.after_mm
    floor = floor_for_colours(result.summary.get("error", {}).get("floor"), before)
    new = " + ".join(word(name) for name in added(result.summary)) or "the best candidate"
    titles = ("the model as it was", f"with {new}") if both else ("the model as it is", "")
    for axis, error, title in zip(axes, (before, after), titles, strict=True):
        axis.set_axis_off()
        if title:
            axis.set_title(title, color=INK, fontsize=11)
            _surface(axis, markers, error, floor)
    scale = ScalarMappable(
        LogNorm(STEPS[0], STEPS[-1]), LinearSegmentedColormap.from_list("error", list(ERROR_SCALE))
    )
    bar = axes[0].figure.colorbar(scale, ax=axes, shrink=0.7, pad=0.02, aspect=30)
    bar.set_ticks(list(STEPS), labels=[f"{s}" for s in STEPS])
    bar.minorticks_off()
    units = result.summary.get("units", "")
    bar.set_label(f"error in noise floors of {number(floor)} {units}", color=MUTED)
    bar.outline.set_visible(False)


def _surface(axis: Any, markers: Cloud, error: Floats, floor: float) -> None:
    """The surface at rest as somebody in front of it sees it, lit from the left, in the colour of the error."""
    from matplotlib.collections import PolyCollection

    right, up, normal = view_axes(markers.rest_mm)
    turned = np.stack([0.86 * right + 0.5 * normal, up, 0.86 * normal - 0.5 * right])
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    surface = skin(markers.rest_mm, subdivisions=3)
    if surface is not None:
        seen = surface.vertices(markers.rest_mm) @ turned.T
        corners = seen[surface.triangles]
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        facing *= np.sign(facing[:, 2:3])
        light = facing @ LIGHT / np.maximum(np.linalg.norm(facing, axis=1), 1e-12)
        value = surface.vertices(np.nan_to_num(error))[surface.triangles].mean(axis=1)
        colours = error_colours(np.clip(value, 0.0, None), floor) / 255.0 * (0.55 + 0.5 * light)[:, None]
        order = np.argsort(corners[:, :, 2].mean(axis=1))
        faces = np.clip(colours[order], 0.0, 1.0)
        axis.add_collection(
            PolyCollection(list(corners[order, :, :2]), facecolors=faces, edgecolors=faces, linewidths=0.4)
        )
    points = markers.rest_mm @ turned.T
    known = np.isfinite(error)
    shades = error_colours(error[known], floor) / 255.0
    axis.scatter(points[known, 0], points[known, 1], c=shades, s=16, edgecolors=INK, linewidths=0.6, zorder=3)
    axis.set_aspect("equal")
    axis.margins(0.04)


def _errors(axis: Any, result: "Result") -> None:
    """The error of each capture, before and after, where there is no surface to draw."""
    before, after = residuals(result.fields)
    both = has_improved(result.summary)
    axis.plot(rms(before, axis=1), color=BEFORE, label="before" if both else "error", linewidth=1.2)
    if both:
        axis.plot(rms(after, axis=1), color=AFTER, label="after", linewidth=1.2)
    axis.set_xlabel("capture", color=MUTED)
    axis.set_ylabel(f"rms error, {result.summary.get('units', '')}", color=MUTED)
    axis.set_ylim(bottom=0)
    axis.legend(frameon=False)
    _plain(axis)


def _waterfall(axis: Any, result: "Result") -> None:
    units = str(result.summary.get("units", ""))
    steps = [(label.removeprefix("+ "), float(value)) for label, value in result.waterfall]
    colours = [{"ceiling": CEILING, "floor": FLOOR}.get(label, AFTER) for label, _ in steps]
    if steps:
        colours[0] = BEFORE
    places = np.arange(len(steps))
    axis.barh(
        places, [value for _, value in steps], color=[np.array(rgb(c)) / 255.0 for c in colours], height=0.6
    )
    for place, (_, value) in zip(places.tolist(), steps, strict=True):
        axis.text(value, place, f"  {number(value)} {units}", va="center", color=INK, fontsize=10)
    axis.set_yticks(places, [word(label) for label, _ in steps])
    axis.invert_yaxis()
    axis.set_xlim(right=1.3 * max((value for _, value in steps), default=1.0))
    axis.set_xlabel(f"held-out error, rms, {units}", color=MUTED)
    _plain(axis)


def _plain(axis: Any) -> None:
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)
    axis.tick_params(colors=INK, length=0)
