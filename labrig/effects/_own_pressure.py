"""What a chamber's own pressure does by a law that nobody knows yet: one space for all effects that act through it.

A regulator that is off, a wall that stiffens and a skin that is stretched each change how far a chamber moves with its
own pressure. Which of them a curve is by can be said of the laws that are known. One that is unlike those lies here,
where it is as good under each name: then these effects can't be told apart.
"""

import numpy as np

from labrig.effects._context import Context
from labrig.effects._family import Feature, Space, acting, pressure

_POINTS = 13
"""Of the grid of hats and steps over the range: a grid, no limit of a verdict."""


def curves(context: Context) -> tuple[Feature, ...]:
    """Curves of each chamber's own pressure that act in it alone: plain ones, steps and bumps.

    The gain, the offset where it isn't vented, the same everywhere, dead bands, two waves; steps and hats at twelve
    parts of the range.
    """
    x = context.rows.fraction
    on = (np.abs(context.rows.actuation - context.vented) > 1e-9 * np.abs(context.span)).astype(float)
    out = [
        pressure("gain", x),
        pressure("offset", on, 0.3),
        pressure("zero", np.ones_like(x), 0.3),
        pressure("band 0.04", -np.minimum(x, 0.04), 0.15),
        pressure("band 0.1", -np.minimum(x, 0.1), 0.15),
        pressure("wave 2", on * np.sin(2 * np.pi * x) / np.pi, 0.15),
        pressure("wave 1", on * np.sin(np.pi * x), 0.15),
    ]
    grid = np.linspace(0, 1, _POINTS)
    steps = [pressure(f"from {at:.2f}", on * (x >= at), 0.02) for at in (grid[1:] + grid[:-1])[:-1] / 2]
    hats = [
        pressure(f"at {at:.2f}", on * np.maximum(1 - np.abs(x - at) / grid[1], 0), 0.02) for at in grid[1:]
    ]
    return acting([*out, *steps, *hats])


def any_curve(context: Context) -> Space:
    """The space of laws unlike those that are known; its spectrum is learnt from the laws of all who share it."""
    return Space("any curve", "own pressure", curves(context), 0.4)
