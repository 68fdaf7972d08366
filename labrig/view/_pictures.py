"""The pictures of a report by name, each made when it is asked for: what a notebook draws."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from labrig.arrays import Floats
from labrig.view._colours import floor_for_colours
from labrig.view._fields import Cloud, cloud, skin
from labrig.view._figures import FONT, Figure, _layout, fit, over_captures
from labrig.view._outlines import chamber_outlines
from labrig.view._signature_figure import signature
from labrig.view._surface_figure import surface_figure
from labrig.view._waterfall import _colour, _meaning, shown_name
from labrig.view._words import has_improved

if TYPE_CHECKING:
    from labrig.diagnosis import Result


def pictures_of(result: "Result") -> dict[str, Callable[[], Figure]]:
    """What can be drawn of a result, as functions that give plotly's data and layout.

    `error` (from the model to the noise), `surface` (and `surface before`, where the model was improved), `fit`,
    `captures`, and `creep` for the signature of creep.
    """
    units, both = str(result.summary.get("units", "")), has_improved(result.summary)
    floor = result.summary.get("error", {}).get("floor")
    pictures: dict[str, Callable[[], Figure]] = {"error": partial(error_bars, result.waterfall, units)}
    markers = cloud(result.fields)
    if markers is not None:
        colours = floor_for_colours(floor, markers.before_mm)
        pictures["surface"] = partial(surface_of, markers, markers.after_mm, colours, units)
        if both:
            pictures["surface before"] = partial(surface_of, markers, markers.before_mm, colours, units)
    pictures["fit"] = partial(fit, result.fields, both)
    pictures["captures"] = partial(over_captures, result.fields, units, floor, both)
    return pictures | {item.effect: partial(signature, item) for item in result.signatures}


def surface_of(markers: Cloud, error: Floats, floor: float, units: str) -> Figure:
    """The markers' errors (M,) on their surface, in noise floors."""
    surface = skin(markers.rest_mm)
    if surface is None or markers.reach is None:
        return surface_figure(markers.names, markers.rest_mm, error, floor, units, surface)
    lines = chamber_outlines(surface, markers.chambers, markers.reach)
    return surface_figure(markers.names, markers.rest_mm, error, floor, units, surface, lines)


def error_bars(steps: list[tuple[str, float]], units: str) -> Figure:
    """A bar for each step from a model down to the floor."""
    bars: Figure = {
        "type": "bar",
        "x": [shown_name(label) for label, _ in steps],
        "y": [value for _, value in steps],
        "marker": {"color": [_colour(label, index) for index, (label, _) in enumerate(steps)]},
        "text": [f"{value:.3g}" for _, value in steps],
        "textposition": "outside",
        "cliponaxis": False,
        "hovertext": [_meaning(label) for label, _ in steps],
        "hoverinfo": "text",
    }
    title = {"title": {"text": f"error, {units} rms", "font": FONT}}
    return {"data": [bars], "layout": _layout(yaxis=title, showlegend=False)}
