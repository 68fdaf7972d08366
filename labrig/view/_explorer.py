"""Two surfaces side by side that a person turns together: before and after, over all captures or at one of them."""

import json
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from labrig._text import number
from labrig.arrays import Floats
from labrig.view._colours import STEPS
from labrig.view._explorer_script import EXPLORER
from labrig.view._fields import (
    Cloud,
    Skin,
    filled,
    kept_captures,
    rms,
)
from labrig.view._figures import STATES
from labrig.view._names_in_space import name_places, proud
from labrig.view._outlines import Outline, chamber_outlines
from labrig.view._page import Page
from labrig.view._style import ERROR_SCALE
from labrig.view._surface_figure import surface_figure

MAX_CAPTURES = 200
_DIGITS = 2


def surface_explorer(
    page: Page,
    cloud: Cloud,
    skin: Skin | None,
    floor: float,
    units: str,
    titles: Sequence[str],
    captures: Sequence[str],
    states: Sequence[str] = STATES,
) -> None:
    """Add the surface to a page: one picture for each of the `titles` (the model as it was, and improved), a legend, a
    list of `captures` (N, in words) to pick from, and a switch between the pictures, whose short names are `states`.
    """
    outlines = (
        [] if skin is None or cloud.reach is None else chamber_outlines(skin, cloud.chambers, cloud.reach)
    )
    errors = [cloud.before_mm, cloud.after_mm] if len(titles) > 1 else [cloud.after_mm]
    each = [cloud.base_error_mm, cloud.model_error_mm] if len(titles) > 1 else [cloud.model_error_mm]
    drawn = []
    for title, error in zip(titles, errors, strict=True):
        figure = surface_figure(cloud.names, cloud.rest_mm, error, floor, units, skin, outlines)
        drawn.append(f'<div class="plot state"><h3>{escape(title)}</h3>{page.plot(figure)}</div>')
    kept = kept_captures(len(captures), rms(each[0], axis=1), MAX_CAPTURES)
    content = _data(cloud, skin, outlines, errors, each, kept, floor, units)
    page.add(
        '<div class="explorer">'
        + _controls(captures, kept, rms(each[0], axis=1), units, states if len(titles) > 1 else ())
        + colour_legend(floor, units)
        + f'<div class="plots">{"".join(drawn)}</div>'
        + f'<script type="application/json">{content}</script></div>'
    )
    page.script("explorer", EXPLORER)


def colour_legend(floor: float, units: str) -> str:
    """The scale of colours, the same on every page: noise floors, and what they are in units here."""
    stops = ", ".join(f"{colour} {100 * position:.0f}%" for position, colour in ERROR_SCALE)
    marks = "".join(
        f"<span>{step}{' or less' if i == 0 else ' or more' if step == STEPS[-1] else ''}<br>"
        f"{number(step * floor)} {escape(units)}</span>"
        for i, step in enumerate(STEPS)
    )
    return (
        '<div class="scale"><span class="of">error in noise floors</span>'
        f'<div class="colours" style="background:linear-gradient(90deg, {stops})"></div>'
        f'<div class="marks">{marks}</div></div>'
    )


def _controls(
    captures: Sequence[str], kept: Sequence[int], error: Floats, units: str, states: Sequence[str]
) -> str:
    worst = int(np.nanargmax(error)) if np.isfinite(error).any() else -1
    options = '<option value="-1">all captures</option>' + "".join(
        f'<option value="{place}"{" data-worst=1" if n == worst else ""}>{escape(captures[n])}'
        f"{f' ({number(float(error[n]))} {escape(units)})' if np.isfinite(error[n]) else ''}"
        f"{', the worst' if n == worst else ''}</option>"
        for place, n in enumerate(kept)
    )
    buttons = "".join(
        f'<button data-show="{place}">{escape(state)}</button>' for place, state in enumerate(states)
    )
    switch = (
        f'<span class="switch"><button data-show="all" class="on">both</button>{buttons}</span>'
        if states
        else ""
    )
    return (
        f'<div class="controls"><label>capture <select>{options}</select></label>'
        '<span class="switch"><button data-go="-1" aria-label="previous capture">◂</button>'
        '<button data-go="1" aria-label="next capture">▸</button><button data-go="worst">worst</button></span>'
        f'{switch}<label><input type="checkbox" checked> names</label></div>'
    )


def _data(
    cloud: Cloud,
    skin: Skin | None,
    outlines: Sequence[Outline],
    errors: Sequence[Floats],
    each: Sequence[Floats],
    kept: Sequence[int],
    floor: float,
    units: str,
) -> str:
    shape = filled(cloud.measured_mm, cloud.base_mm)[kept]
    named = name_places(cloud.names, cloud.rest_mm, skin, outlines)
    content: dict[str, Any] = {
        "names": list(cloud.names),
        "floor": floor,
        "units": units,
        "steps": STEPS[-1],
        "off": _short(proud(cloud.rest_mm), 3),
        "above": [_short(named.of_markers), _short(named.of_chambers)],
        "rest": _short(cloud.rest_mm),
        "shapes": _short(shape),
        "errors": [_short(error, 4) for error in errors],
        "each": [_short(error[kept], 4) for error in each],
        "weight": [] if skin is None else _short(skin.weight, 4),
        "ends": _short(np.concatenate([o.ends for o in outlines]), 3) if outlines else [],
        "middles": _short(np.array([o.middle for o in outlines]), 3) if outlines else [],
    }
    return json.dumps(content, allow_nan=False, separators=(",", ":")).replace("</", "<\\/")


def _short(values: Floats, digits: int = _DIGITS) -> Any:
    """Nested lists of rounded numbers, None for what is not one."""
    rounded = np.round(values, digits).astype(object)
    rounded[~np.isfinite(values)] = None
    return rounded.tolist()
