"""A surface with an error in colour, in noise floors: its skin, its markers by name, its chambers' outlines."""

from collections.abc import Sequence

import numpy as np

from labrig._text import number
from labrig.arrays import Floats
from labrig.view._colours import shade
from labrig.view._fields import Skin
from labrig.view._figures import FONT, Figure, _plain
from labrig.view._names_in_space import name_places, proud
from labrig.view._outlines import Outline
from labrig.view._space import camera, light, room_for, scene_layout
from labrig.view._style import ERROR_SCALE, INK

MARKERS, NAMES, SKIN, LINES, CHAMBERS = range(5)
"""The traces of the figure, in this order; the last three only where there is a skin. Behind them is the room of what
would be too thin."""
_ABOVE = 5  # how many times as far names do
_LETTER, _TALL = (
    0.025,
    0.07,
)  # half the room that a letter of a name takes, and a name's height, of the surface's size


def surface_figure(
    names: Sequence[str],
    places_mm: Floats,
    error: Floats,
    floor: float,
    units: str,
    skin: Skin | None = None,
    outlines: Sequence[Outline] = (),
) -> Figure:
    """Markers `names` at places (M, 3) with errors (M,) per coordinate, in colours that `floor` alone scales."""
    off = proud(places_mm)
    named = name_places(names, places_mm, skin, outlines)
    scale = [[position, colour] for position, colour in ERROR_SCALE]
    shades = {"colorscale": scale, "cmin": 0, "cmax": 1, "showscale": False}
    data: list[Figure] = [
        {
            "type": "scatter3d",
            "mode": "markers",
            **_at(places_mm + off),
            "hovertext": hover_words(names, error, floor, units),
            "hoverinfo": "text",
            "customdata": _plain(error),
            "marker": {
                "size": 4 if skin else 7,
                "color": _plain(shade(error, floor)),
                "line": {"color": INK, "width": 1},
                **shades,
            },
        },
        {
            "type": "scatter3d",
            "mode": "text",
            **_at(places_mm + named.of_markers),
            "text": list(names),
            "textposition": "top center",
            "textfont": {**FONT, "size": 10, "color": INK},
            "hoverinfo": "skip",
        },
    ]
    if skin is not None:
        data.append(_mesh(skin, places_mm, error, floor) | shades)
        data += _chambers(places_mm, outlines, named.of_chambers)
    if (room := room_for(places_mm)) is not None:
        data.append({"type": "scatter3d", "mode": "none", "name": "room", **_at(room), "hoverinfo": "skip"})
    return {"data": data, "layout": scene_layout(camera(places_mm), False)}


def hover_words(names: Sequence[str], error: Floats, floor: float, units: str) -> list[str]:
    """What is said of each marker that is pointed at."""
    return [
        f"{name}: not seen"
        if value != value
        else f"{name}: {number(float(value))} {units}<br>{value / floor:.1f} floors"
        for name, value in zip(names, error, strict=True)
    ]


def _mesh(skin: Skin, places_mm: Floats, error: Floats, floor: float) -> Figure:
    vertices = skin.vertices(places_mm)
    value = np.clip(skin.vertices(np.nan_to_num(error)), 0.0, None)
    i, j, k = skin.triangles.T
    return {
        "type": "mesh3d",
        **_at(vertices),
        "i": i.tolist(),
        "j": j.tolist(),
        "k": k.tolist(),
        "intensity": _plain(shade(value, floor)),
        "hoverinfo": "skip",
        "flatshading": False,
        "lighting": {"ambient": 0.68, "diffuse": 0.5, "specular": 0.05, "roughness": 0.9, "fresnel": 0.0},
        "lightposition": light(places_mm),
    }


def _chambers(places_mm: Floats, outlines: Sequence[Outline], named: Floats) -> list[Figure]:
    """The lines of all chambers as one trace, and their names as another."""
    if not outlines:
        return []
    off = proud(places_mm)
    ends = np.concatenate([o.ends for o in outlines]) @ places_mm + off
    gaps = np.full((len(ends), 1, 3), np.nan)
    lines = np.concatenate([ends, gaps], axis=1).reshape(-1, 3)
    middles = np.array([o.middle for o in outlines]) @ places_mm + named
    return [
        {
            "type": "scatter3d",
            "mode": "lines",
            **_at(lines),
            "line": {"color": INK, "width": 2},
            "opacity": 0.55,
            "hoverinfo": "skip",
        },
        {
            "type": "scatter3d",
            "mode": "text",
            **_at(middles),
            "text": [o.name for o in outlines],
            "textposition": "bottom center",
            "textfont": {**FONT, "size": 14, "color": INK, "weight": 600},
            "hoverinfo": "skip",
        },
    ]


def _at(points_mm: Floats) -> Figure:
    return dict(zip("xyz", map(_plain, points_mm.T), strict=True))
