"""What fills one chamber and reaches another, whatever that one's own pressure is: all of it adds up.

What adds up can be said of each chamber alone: its motion has something of the others' motions. So the base's own
motions may be wrong by it as well as chambers may be coupled, and one space is for both.
"""

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._family import Space, acting, pressure
from labrig.effects._fields import overlap

_OTHERS = 6
"""How many neighbours act each for itself: a grid, no limit of a verdict."""


def reached(context: Context) -> Space:
    """Each chamber gets something of the pressure, or of the wall's way, of its nearest neighbours."""
    near, out = overlap(context), []
    walls = neighbours(near, context.deflection)
    for k, (y, wall) in enumerate(zip(neighbours(near, context.rows.fraction), walls, strict=True), start=1):
        out.append(pressure(f"from {k}", y))
        if not context.linear:
            out.append(pressure(f"from the wall of {k}", wall / context.deflection_slope))
    return Space("reached", "coupling reached", acting(out), 0.3)


def neighbours(near: Floats, x: Floats) -> list[Floats]:
    """What the pressures (F, C) of each chamber's nearest, second nearest, ... other chamber are, (F, C) each."""
    return nearest(near, x)[:_OTHERS]


def nearest(near: Floats, x: Floats) -> list[Floats]:
    """The same of all other chambers."""
    apart = near - 2.0 * np.eye(len(near))  # no chamber is its own neighbour, however few it has
    order = np.argsort(-apart, axis=1, kind="stable")[:, :-1]
    return [x[:, k] for k in order.T]
