"""The legend of a recording as a picture: a viewer has no scale of colours, and cuts long lists of curves."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from labrig._text import number
from labrig.view._colours import STEPS, error_colours
from labrig.view._scene import CHAMBER_COLOURS

INK, PAPER = "#e6e9ee", "#161a21"
WIDTH_INCHES, DPI = 4.0, 160
_COLUMNS = 5


def legend_picture(floor: float | None, units: str, chambers: Sequence[str]) -> NDArray[np.uint8]:
    """The scale of errors in noise floors (none without a floor) and the colours of the chambers, (H, W, 3)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    rows = -(-len(chambers) // _COLUMNS)
    scale = 0.75 if floor is not None else 0.0
    height = scale + (0.28 * (rows + 1) if chambers else 0.0) + 0.1
    figure = Figure(figsize=(WIDTH_INCHES, height), dpi=DPI, facecolor=PAPER)
    canvas = FigureCanvasAgg(figure)
    if floor is not None:
        axis = figure.add_axes((0.07, 1 - 0.42 / height, 0.86, 0.13 / height))
        share = np.linspace(0.0, np.log2(STEPS[-1]), 256)
        axis.imshow(error_colours(2.0**share, 1.0)[None], aspect="auto", extent=(0, share[-1], 0, 1))
        marks = [f"{s}\n{number(s * floor)}" for s in STEPS]
        marks[-1] = marks[-1].replace("\n", "+\n")
        axis.set_xticks(np.log2(STEPS), marks, color=INK, fontsize=7.5)
        axis.set_yticks([])
        axis.tick_params(length=0)
        axis.set_title(
            f"error per coordinate in noise floors and {units}; grey: not seen",
            color=INK,
            fontsize=8.5,
            loc="left",
            pad=4,
        )
    for k, chamber in enumerate(["chambers:", *chambers] if chambers else []):
        place = k - 1
        x = 0.07 if k == 0 else 0.07 + 0.19 * (place % _COLUMNS)
        y = height - scale - 0.18 - (0 if k == 0 else 0.28 * (1 + place // _COLUMNS))
        colour = INK if k == 0 else CHAMBER_COLOURS[place % len(CHAMBER_COLOURS)]
        figure.text(
            x, y / height, chamber if k == 0 else f"━ {chamber}", color=colour, fontsize=8.5, va="center"
        )
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()
