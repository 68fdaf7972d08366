"""Plotly figures as plain values (data and layout), so that drawing them needs no heavy import."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig.view._fields import Cloud, Skin, capture_numbers, residuals, rms
from labrig.view._style import AFTER, BEFORE, ERROR_SCALE, FLOOR, GROUPS, INK, LINE, MUTED

if TYPE_CHECKING:
    import xarray as xr

    from labrig.diagnosis import Signature

Figure = dict[str, Any]
Floats = NDArray[np.float64]

FONT = {"family": "system-ui, Segoe UI, Roboto, Helvetica, Arial, sans-serif", "size": 13, "color": INK}
MAX_POINTS = 3000
BINS = 12


def _layout(**changes: Any) -> Figure:
    axis = {
        "title": {"font": FONT},
        "gridcolor": LINE,
        "zerolinecolor": "#b9b4a8",
        "linecolor": LINE,
        "ticks": "",
        "automargin": True,
    }
    layout: Figure = {
        "font": FONT,
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "margin": {"l": 56, "r": 12, "t": 10, "b": 46},
        "height": 300,
        "xaxis": dict(axis),
        "yaxis": dict(axis),
        "legend": {"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom"},
        "hoverlabel": {"font": FONT},
    }
    for key, value in changes.items():
        layout[key] = {**layout[key], **value} if isinstance(layout.get(key), dict) else value
    return layout


def surfaces(cloud: Cloud, skin: Skin | None, units: str) -> tuple[Figure, Figure]:
    """The surface at rest with the rms error of each marker in colour: before and after, on one scale."""
    before, after = rms(cloud.base_error_mm, axis=0), rms(cloud.model_error_mm, axis=0)
    top = float(np.nanmax(np.concatenate([before, after]))) or 1.0
    return _surface(cloud, skin, before, top, units, bar=False), _surface(
        cloud, skin, after, top, units, bar=True
    )


def _surface(cloud: Cloud, skin: Skin | None, error: Floats, top: float, units: str, bar: bool) -> Figure:
    scale = [[position, colour] for position, colour in ERROR_SCALE]
    colourbar = {
        "title": {"text": f"distance, {units}", "side": "right", "font": FONT},
        "thickness": 12,
        "len": 0.8,
        "outlinewidth": 0,
        "x": 1.0,
    }
    hover = [f"{name}<br>{value:.3g} {units}" for name, value in zip(cloud.names, error, strict=True)]
    proud = 0.008 * float(np.ptp(cloud.rest_mm, axis=0).max()) * front(cloud.rest_mm)
    x, y, z = (cloud.rest_mm + proud).T
    data: list[Figure] = [
        {
            "type": "scatter3d",
            "mode": "markers",
            "x": _plain(x),
            "y": _plain(y),
            "z": _plain(z),
            "text": hover,
            "hoverinfo": "text",
            "marker": {
                "size": 4 if skin else 7,
                "color": _plain(error),
                "colorscale": scale,
                "cmin": 0,
                "cmax": top,
                "line": {"color": INK, "width": 1},
                "showscale": bar and skin is None,
                "colorbar": colourbar,
            },
        }
    ]
    if skin is not None:
        vertices = skin.vertices(cloud.rest_mm)
        intensity = np.clip(skin.vertices(np.nan_to_num(error)), 0.0, top)
        i, j, k = skin.triangles.T
        data.append(
            {
                "type": "mesh3d",
                "x": _plain(vertices[:, 0]),
                "y": _plain(vertices[:, 1]),
                "z": _plain(vertices[:, 2]),
                "i": i.tolist(),
                "j": j.tolist(),
                "k": k.tolist(),
                "intensity": _plain(intensity),
                "colorscale": scale,
                "cmin": 0,
                "cmax": top,
                "hoverinfo": "skip",
                "flatshading": False,
                "lighting": {
                    "ambient": 0.62,
                    "diffuse": 0.55,
                    "specular": 0.05,
                    "roughness": 0.9,
                    "fresnel": 0.0,
                },
                "lightposition": dict(zip("xyz", _plain(_light(cloud.rest_mm)), strict=True)),
                "showscale": bar,
                "colorbar": colourbar,
            }
        )
    return {"data": data, "layout": scene_layout(_camera(cloud.rest_mm), bar)}


def scene_layout(camera: dict[str, Any], bar: bool) -> dict[str, Any]:
    """The layout of a picture in space: no axes, true proportions, room for a colour bar."""
    axis = {"visible": False, "showbackground": False}
    layout = _layout(
        height=430,
        margin={"l": 0, "r": 70 if bar else 0, "t": 0, "b": 0},
        showlegend=False,
        scene={
            "xaxis": axis,
            "yaxis": axis,
            "zaxis": axis,
            "aspectmode": "data",
            "camera": camera,
            "dragmode": "orbit",
        },
    )
    del layout["xaxis"], layout["yaxis"]
    return layout


def view_axes(rest_mm: Floats) -> tuple[Floats, Floats, Floats]:
    """Unit vectors to the right, up, and out of the surface, as somebody in front of it sees them."""
    normal = front(rest_mm)
    up = np.array([0.0, 0.0, 1.0]) if abs(normal[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    right = np.cross(up, normal)
    right /= np.linalg.norm(right)
    return right, np.cross(normal, right), normal


def _light(rest_mm: Floats) -> Floats:
    right, up, normal = view_axes(rest_mm)
    return 1e4 * (normal - 1.2 * right + 0.8 * up)


def _camera(rest_mm: Floats) -> Figure:
    """Look at the side that bulges, a little from the right and above."""
    right, up, normal = view_axes(rest_mm)
    eye = 2.15 * normal + 1.35 * right + 0.6 * up
    names = ("x", "y", "z")
    return {
        "eye": dict(zip(names, _plain(eye), strict=True)),
        "up": dict(zip(names, _plain(up), strict=True)),
    }


def front(rest_mm: Floats) -> Floats:
    """The unit direction that the surface faces: along its thinnest axis, to the side that bulges."""
    centred = rest_mm - rest_mm.mean(axis=0)
    if len(rest_mm) < 3:
        return np.array([0.0, 1.0, 0.0])
    normal = np.linalg.svd(centred, full_matrices=False)[2][2]
    depth = centred @ normal
    radius = np.linalg.norm(centred - depth[:, None] * normal, axis=1)
    bulge = depth[radius <= np.median(radius)].mean() - depth[radius > np.median(radius)].mean()
    if abs(bulge) > 1e-6 * (np.ptp(centred) or 1.0):
        return normal if bulge > 0 else -normal
    return normal if normal[np.argmax(np.abs(normal))] > 0 else -normal


def fit(fields: "xr.Dataset") -> Figure:
    """Measured against predicted, before and after; in standard deviations where the units differ."""
    measured = np.asarray(fields["measured"].values, dtype=float)
    units = sorted({str(unit) for unit in fields["unit"].values}) if "unit" in fields.coords else []
    scale, offset, label = np.ones(measured.shape[1]), np.zeros(measured.shape[1]), units[0] if units else ""
    if len(units) > 1:
        offset = np.nanmean(measured, axis=0)
        scale = np.nanstd(measured, axis=0)
        scale[~(scale > 0)] = 1.0
        label = "standard deviations"
    value = (measured - offset) / scale
    names = np.broadcast_to(np.array([str(n) for n in fields["observable"].values]), measured.shape)
    captures = np.broadcast_to(np.array([str(c) for c in fields["capture"].values])[:, None], measured.shape)
    data: list[Figure] = []
    for variable, name, colour in (("base", "before", BEFORE), ("model", "after", AFTER)):
        predicted = (np.asarray(fields[variable].values, dtype=float) - offset) / scale
        seen = np.isfinite(value) & np.isfinite(predicted)
        chosen = _thinned(np.flatnonzero(seen))
        text = [f"{n}, capture {c}" for n, c in zip(names.flat[chosen], captures.flat[chosen], strict=True)]
        data.append(_points(predicted.flat[chosen], value.flat[chosen], name, colour, text))
    finite = value[np.isfinite(value)]
    if finite.size:
        ends = [float(finite.min()), float(finite.max())]
        data.append(
            {**_curve(ends, ends, "exact", MUTED), "line": {"color": MUTED, "width": 1, "dash": "dot"}}
        )
    title = f", {label}" if label else ""
    layout = _layout(
        height=420,
        xaxis={"title": {"font": FONT, "text": f"predicted{title}"}},
        yaxis={"title": {"font": FONT, "text": f"measured{title}"}},
    )
    return {"data": data, "layout": layout}


def over_captures(fields: "xr.Dataset", units: str, floor: float | None) -> Figure:
    """The rms error of every capture in the order of the campaign, before and after, above the noise floor."""
    before, after = residuals(fields)
    x = capture_numbers(fields)
    data = [
        {**_curve(x, rms(before, axis=1), "before", BEFORE), "mode": "lines+markers", "marker": {"size": 5}},
        {**_curve(x, rms(after, axis=1), "after", AFTER), "mode": "lines+markers", "marker": {"size": 5}},
    ]
    if floor is not None:
        line = _curve(x[[0, -1]], [floor, floor], "noise floor", FLOOR)
        data.append({**line, "line": {"color": FLOOR, "width": 1.5, "dash": "dash"}})
    layout = _layout(
        height=280,
        xaxis={"title": {"font": FONT, "text": "capture"}},
        yaxis={"title": {"font": FONT, "text": f"rms error, {units}"}, "rangemode": "tozero"},
    )
    return {"data": data, "layout": layout}


def signature(item: "Signature", units: str) -> Figure:
    """Residual against the covariate that betrays an effect, each group apart, with its mean in bins."""
    x, residual = np.asarray(item.x, dtype=float), np.asarray(item.residual, dtype=float)
    group = np.array([str(name) for name in item.group])
    finite = np.isfinite(x) & np.isfinite(residual)
    names = sorted(set(group[finite].tolist()), key=lambda name: (name != "up", name != "down", name))
    data: list[Figure] = []
    for name, colour in zip(names, GROUPS * (len(names) // len(GROUPS) + 1), strict=False):
        inside = np.flatnonzero(finite & (group == name))
        shown = _thinned(inside)
        points = _points(x[shown], residual[shown], name, colour, None)
        data.append({**points, "showlegend": False, "legendgroup": name})
        centre, mean = _binned(x[inside], residual[inside])
        curve = {**_curve(centre, mean, name or "all", colour), "mode": "lines+markers", "legendgroup": name}
        data.append({**curve, "line": {"color": colour, "width": 3}, "marker": {"size": 7, "color": colour}})
    unit = f", {item.unit}" if item.unit and item.unit != "1" else ""
    layout = _layout(
        xaxis={"title": {"font": FONT, "text": f"{item.covariate}{unit}"}},
        yaxis={"title": {"font": FONT, "text": f"measured − predicted, {units}"}},
        showlegend=len(names) > 1,
    )
    return {"data": data, "layout": layout}


def _binned(x: Floats, y: Floats) -> tuple[list[float | None], list[float | None]]:
    """Means of y in bins of x that hold equally many points."""
    if not len(x):
        return [], []
    order = np.argsort(x, kind="stable")
    distinct = len(np.unique(x))
    parts = np.array_split(order, max(1, min(BINS, distinct, len(x) // 3)))
    return _plain(np.array([x[p].mean() for p in parts])), _plain(np.array([y[p].mean() for p in parts]))


def _thinned(index: NDArray[np.intp]) -> NDArray[np.intp]:
    if len(index) <= MAX_POINTS:
        return index
    return index[np.linspace(0, len(index) - 1, MAX_POINTS).astype(np.intp)]


def _points(x: Any, y: Any, name: str, colour: str, text: list[str] | None) -> Figure:
    points: Figure = {
        "type": "scatter",
        "mode": "markers",
        "name": name,
        "x": _plain(x),
        "y": _plain(y),
        "marker": {"size": 5, "color": colour, "opacity": 0.28},
    }
    return points if text is None else {**points, "text": text}


def _curve(x: Any, y: Any, name: str, colour: str) -> Figure:
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": _plain(x),
        "y": _plain(y),
        "line": {"color": colour, "width": 2},
    }


def _plain(values: Any) -> list[float | None]:
    """Five significant digits, and null for what is not a number: JSON that a browser reads."""
    return [float(f"{v:.5g}") if v is not None and np.isfinite(v) else None for v in values]
