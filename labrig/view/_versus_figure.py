"""Where each of two models is nearer: differences of their errors as points with intervals."""

import re
from collections.abc import Sequence

from labrig.contents import PlaceGap
from labrig.view._figures import FONT, Figure, _layout
from labrig.view._style import AFTER, BEFORE, FLOOR, INK

MOST_ROWS = 12
_ROW_PX, _MARGIN_PX = 22, 76


def differences(rows: Sequence[PlaceGap], names: tuple[str, str], units: str) -> Figure:
    """One line for each place, those that differ most: the first model's error minus the second's.

    Of `rows` with `name`, `error` (of both), `value`, `low`, `high`, `better`; places are named in their natural order.
    """
    shown = sorted(rows[:MOST_ROWS], key=lambda row: _natural(str(row["name"])), reverse=True)
    colours = {names[0]: BEFORE, names[1]: AFTER}
    data: list[Figure] = []
    for better, legend in (
        (names[0], f"{names[0]} nearer"),
        (names[1], f"{names[1]} nearer"),
        (None, "cannot tell"),
    ):
        own = [row for row in shown if row["better"] == better]
        if not own:
            continue
        colour = colours.get(str(better), FLOOR)
        data.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": legend,
                "x": [_short(row["value"]) for row in own],
                "y": [row["name"] for row in own],
                "error_x": {
                    "type": "data",
                    "symmetric": False,
                    "array": [_short(row["high"] - row["value"]) for row in own],
                    "arrayminus": [_short(row["value"] - row["low"]) for row in own],
                    "color": colour,
                    "thickness": 1.6,
                    "width": 0,
                },
                "marker": {"size": 8, "color": colour},
                "hovertext": [
                    "<br>".join(
                        [
                            str(row["name"]),
                            *(f"{name} {e:.3g} {units}" for name, e in zip(names, row["error"], strict=True)),
                        ]
                    )
                    for row in own
                ],
                "hoverinfo": "text",
            }
        )
    layout = _layout(
        height=_MARGIN_PX + _ROW_PX * max(len(shown), 3),
        margin={"t": 10, "l": 20, "b": 42},
        xaxis={
            "title": {"font": FONT, "text": f"difference, {units}"},
            "rangemode": "tozero",
            "zerolinecolor": INK,
        },
        yaxis={"categoryorder": "array", "categoryarray": [row["name"] for row in shown]},
        showlegend=False,
    )
    return {"data": data, "layout": layout}


def _natural(name: str) -> list[tuple[int, float | str]]:
    """Names in the order that people count in: m2 before m10, bands by their first number."""
    parts = re.split(r"(\d+(?:\.\d+)?)", name)
    return [(0, float(part)) if i % 2 else (1, part) for i, part in enumerate(parts)]


def _short(value: float) -> float:
    return float(f"{value:.5g}")
