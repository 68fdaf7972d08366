"""Figures of shapes: signed distances in colour on a surface, and their histograms."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.view._figures import FONT, Figure, _layout, _plain
from labrig.view._space import scene_layout
from labrig.view._style import AFTER, BEFORE, INK, LINE

# From inside the target through on it to standing out of it; paper in the middle.
SIGNED_SCALE = (
    (0.0, "#123f55"),
    (0.25, "#1f6f8b"),
    (0.42, "#bcd2da"),
    (0.5, "#e9ece6"),
    (0.58, "#f3cf9b"),
    (0.75, "#c0563a"),
    (1.0, "#5c123c"),
)
NOTHING = "#d3d6d2"
_DIGITS = 2


def signed_map(
    vertices_mm: Floats, triangles: NDArray[np.int64], signed_mm: Floats, top_mm: float, bar: bool = True
) -> Figure:
    """A surface coloured by signed distances (V,), from -top to top mm; grey where nothing is opposite (NaN)."""
    known = np.isfinite(signed_mm)
    opposite = known[triangles].all(axis=1)
    data = []
    if (~opposite).any():
        data.append(plain_mesh(vertices_mm, triangles[~opposite], NOTHING))
    if opposite.any():
        value = np.nan_to_num(signed_mm)
        data.append(
            _mesh(vertices_mm, triangles[opposite])
            | {
                "intensity": _short(np.clip(value, -top_mm, top_mm)),
                "customdata": _short(value),
                "hovertemplate": "%{customdata:.2f} mm<extra></extra>",
                "colorscale": [[position, colour] for position, colour in SIGNED_SCALE],
                "cmin": -top_mm,
                "cmax": top_mm,
                "showscale": bar,
                "colorbar": {
                    "title": {"text": "inside  ·  mm  ·  outside", "side": "right", "font": FONT},
                    "thickness": 12,
                    "len": 0.8,
                    "outlinewidth": 0,
                },
            }
        )
    camera = {"eye": {"x": 0.66, "y": 2.25, "z": 0.32}, "up": {"x": 0, "y": 0, "z": 1}}
    return {"data": data, "layout": scene_layout(camera, bar)}


def histogram(series: Sequence[tuple[str, Floats]], top_mm: float) -> Figure:
    """How signed distances are spread, one outline a series; what is beyond `top_mm` counts at the ends."""
    edges = np.linspace(-top_mm, top_mm, 61)
    data = []
    for number, (name, signed_mm) in enumerate(series):
        values = np.clip(signed_mm[np.isfinite(signed_mm)], -top_mm, top_mm)
        count = np.histogram(values, edges)[0] / max(1, len(values))
        colour = (AFTER, BEFORE, INK)[number % 3]
        data.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": name,
                "x": _short(0.5 * (edges[1:] + edges[:-1])),
                "y": [round(100.0 * float(share), 3) for share in count],
                "line": {"shape": "hvh", "color": colour, "width": 1.6},
                "fill": "tozeroy" if len(series) == 1 else "none",
                "hovertemplate": "%{x:.2f} mm: %{y:.1f} %<extra></extra>",
            }
        )
    layout = _layout(
        height=260,
        showlegend=len(series) > 1,
        xaxis={"title": {"text": "signed distance, mm", "font": FONT}},
        yaxis={"title": {"text": "share of the surface, %", "font": FONT}, "rangemode": "tozero"},
        shapes=[
            {"type": "line", "x0": 0, "x1": 0, "yref": "paper", "y0": 0, "y1": 1, "line": {"color": LINE}}
        ],
    )
    return {"data": data, "layout": layout}


def plain_mesh(vertices_mm: Floats, triangles: NDArray[np.int64], colour: str) -> Figure:
    """A surface in one colour: vertices (V, 3), mm, and triangles (T, 3)."""
    return _mesh(vertices_mm, triangles) | {"color": colour, "hoverinfo": "skip"}


def points_in_space(points_mm: Floats) -> Figure:
    """A cloud of points (P, 3), mm."""
    x, y, z = (_short(points_mm[:, axis]) for axis in range(3))
    marker = {"size": 2.2, "color": [AFTER] * len(points_mm)}
    return {
        "type": "scatter3d",
        "mode": "markers",
        "x": x,
        "y": y,
        "z": z,
        "marker": marker,
        "hoverinfo": "skip",
    }


def _mesh(vertices_mm: Floats, triangles: NDArray[np.int64]) -> Figure:
    i, j, k = triangles.T
    return {
        "type": "mesh3d",
        "x": _short(vertices_mm[:, 0]),
        "y": _short(vertices_mm[:, 1]),
        "z": _short(vertices_mm[:, 2]),
        "i": i.tolist(),
        "j": j.tolist(),
        "k": k.tolist(),
        "flatshading": False,
        "lighting": {"ambient": 0.62, "diffuse": 0.55, "specular": 0.05, "roughness": 0.9, "fresnel": 0.0},
        "lightposition": {"x": 300.0, "y": 2000.0, "z": 800.0},
    }


def _short(values: Floats) -> list[float | None]:
    return _plain(np.round(values, _DIGITS))
