"""What gives an effect away: what was measured as dots, what the fitted effect says as a line."""

from typing import TYPE_CHECKING

import numpy as np

from labrig.arrays import Floats
from labrig.view._figures import (
    FONT,
    Figure,
    _curve,
    _layout,
    _plain,
    _points,
    _thinned,
)
from labrig.view._style import FLOOR, GROUPS

if TYPE_CHECKING:
    from labrig.diagnosis import Signature

BINS = 16
_LOGARITHMIC = 10.0  # times in hold that span so many times the shortest have a logarithmic axis
_FEWEST = 3  # points that a mean is worth drawing of


def signature(item: "Signature") -> Figure:
    """Every point, the means of what was measured in bins as dots, and those of the fitted effect as a line."""
    known = np.isfinite(item.x) & np.isfinite(item.measured) & np.isfinite(item.fitted) & (item.weight > 0)
    names = list(dict.fromkeys(item.group[known].tolist()))
    names.sort(key=lambda name: (name.startswith("the other"), name))
    data: list[Figure] = []
    low, high = [0.0], [0.0]
    for k, name in enumerate(names):
        colour = FLOOR if name.startswith("the other") else GROUPS[1:][k % (len(GROUPS) - 1)]
        inside = np.flatnonzero(known & (item.group == name))
        shown = _thinned(inside)
        points = _points(item.x[shown], item.measured[shown], name, colour, None)
        points["marker"] = {"size": 4, "color": colour, "opacity": 0.16}
        data.append({**points, "showlegend": False, "legendgroup": name, "hoverinfo": "skip"})
        x, measured, fitted = binned(item, inside)
        line = {**_curve(x, fitted, name or "fitted", colour), "legendgroup": name}
        data.append({**line, "line": {"color": colour, "width": 3}})
        dots = {**_points(x, measured, f"{name}, measured", colour, None), "legendgroup": name}
        dots["marker"] = {"size": 8, "color": colour, "line": {"color": "#fcfbf8", "width": 1.5}}
        data.append({**dots, "showlegend": False})
        ends = np.quantile(item.measured[inside], [0.03, 0.97])
        low += [ends[0], measured.min(), fitted.min()]
        high += [ends[1], measured.max(), fitted.max()]
    room = 0.06 * (max(high) - min(low) or 1.0)
    layout = _layout(
        height=320,
        xaxis={"title": {"font": FONT, "text": _title(item.x_name, item.x_unit)}},
        yaxis={
            "title": {"font": FONT, "text": _title(item.y_name, item.y_unit)},
            "range": _plain(np.array([min(low) - room, max(high) + room])),
        },
        showlegend=len(names) > 1,
    )
    x = item.x[known]
    if item.x_name == "time in hold" and len(x) and x.min() > 0 and x.max() > _LOGARITHMIC * x.min():
        # with labels of their own: a logarithmic axis calls 20 "2"
        decades = 10.0 ** np.arange(np.floor(np.log10(x.min())), np.log10(x.max()) + 1)
        ticks = np.multiply.outer(decades, [1, 2, 5]).ravel().tolist()
        layout["xaxis"] |= {"type": "log", "tickvals": ticks, "ticktext": [f"{t:g}" for t in ticks]}
    return {"data": data, "layout": layout}


def binned(item: "Signature", inside: np.ndarray) -> tuple[Floats, Floats, Floats]:
    """Means of x, measured and fitted of the points `inside`, in bins along x."""
    parts = _bins(item, inside[np.argsort(item.x[inside], kind="stable")])
    mean = [
        [np.average(values[p], weights=item.weight[p]) for p in parts if len(p)]
        for values in (item.x, item.measured, item.fitted)
    ]
    return np.array(mean[0]), np.array(mean[1]), np.array(mean[2])


def _bins(item: "Signature", order: np.ndarray) -> list[np.ndarray]:
    """Points in the `order` of their x, in parts: of one x each where there are few, else of equally many.

    Of times in the hold each part is longer than the one before: there are few moments late in long holds.
    """
    x = item.x[order]
    places = np.unique(x)
    if len(places) <= BINS or item.x_name == "capture":
        return np.split(order, np.searchsorted(x, places[1:]))
    if item.x_name == "time in hold" and x[0] > 0:
        return np.split(order, np.searchsorted(x, np.geomspace(x[0], x[-1], BINS + 1)[1:-1]))
    return np.array_split(order, max(1, min(BINS, len(order) // _FEWEST)))


def _title(name: str, unit: str) -> str:
    return name if unit in ("", "1") else f"{name}, {unit}"
