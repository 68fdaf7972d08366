"""Plotly figures as plain values (data and layout), so that drawing them needs no heavy import."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig.view._fields import capture_numbers, residuals, rms
from labrig.view._style import AFTER, BEFORE, FLOOR, INK, LINE, MUTED

if TYPE_CHECKING:
    import xarray as xr

Figure = dict[str, Any]

FONT = {"family": "system-ui, Segoe UI, Roboto, Helvetica, Arial, sans-serif", "size": 13, "color": INK}
MAX_POINTS = 3000
STATES = ("before", "after")


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
        "hoverlabel": {"font": FONT, "bgcolor": "#fff", "bordercolor": "#b9b4a8", "align": "left"},
    }
    for key, value in changes.items():
        layout[key] = {**layout[key], **value} if isinstance(layout.get(key), dict) else value
    return layout


def fit(fields: "xr.Dataset", both: bool = True, names: Sequence[str] = STATES) -> Figure:
    """Measured against predicted, before and after if `both`, under these `names`.

    In standard deviations where the units differ.
    """
    ever = np.isfinite(fields["measured"].values).any(axis=0)
    fields = fields.isel(observable=np.flatnonzero(ever))
    measured = np.asarray(fields["measured"].values, dtype=float)
    units = sorted({str(unit) for unit in fields["unit"].values}) if "unit" in fields.coords else []
    scale, offset, label = np.ones(measured.shape[1]), np.zeros(measured.shape[1]), units[0] if units else ""
    if len(units) > 1:
        offset = np.nanmean(measured, axis=0)
        scale = np.nanstd(measured, axis=0)
        scale[~(scale > 0)] = 1.0
        label = "standard deviations"
    value = (measured - offset) / scale
    labels = np.broadcast_to(np.array([str(n) for n in fields["observable"].values]), measured.shape)
    captures = np.broadcast_to(np.array([str(c) for c in fields["capture"].values])[:, None], measured.shape)
    data: list[Figure] = []
    states = (("base", names[0], BEFORE), ("model", names[1], AFTER))
    for variable, name, colour in states if both else [("model", "the model", AFTER)]:
        predicted = (np.asarray(fields[variable].values, dtype=float) - offset) / scale
        seen = np.isfinite(value) & np.isfinite(predicted)
        chosen = _thinned(np.flatnonzero(seen))
        text = [f"{n}, capture {c}" for n, c in zip(labels.flat[chosen], captures.flat[chosen], strict=True)]
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


def over_captures(
    fields: "xr.Dataset", units: str, floor: float | None, both: bool = True, names: Sequence[str] = STATES
) -> Figure:
    """The rms error of every capture in the order of the campaign, and the floor; `both` under `names`, or one."""
    before, after = residuals(fields)
    x = capture_numbers(fields)
    curves = [(before, names[0], BEFORE), (after, names[1], AFTER)] if both else [(after, "error", AFTER)]
    data = [
        {**_curve(x, rms(left, axis=1), name, colour), "mode": "lines+markers", "marker": {"size": 5}}
        for left, name, colour in curves
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
