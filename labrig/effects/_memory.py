"""What a chamber remembers of where it turned: any law by its pressure now and by the last two places it turned at.

Loops of walls and of sliding parts have many formulas. What all of them act by is where the chamber last turned, where
before that, and how far it has come since (E. Madelung, Ann. Phys. 322 (1905) 861).
"""

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._family import Feature, pressure

_POINTS = 5
_WAYS = (0.02, 0.05, 0.1, 0.2, 0.4)
"""Grids of the places, and of the way since the last turn, shares of the range: no limits of a verdict."""
_STILL = 0.01
"""A way back that is shorter, share of the range, is no turn: measured pressures tremble."""


def turns(context: Context) -> tuple[Floats, Floats, Floats]:
    """Where each chamber last turned and where before that, shares of the range, and which way it goes, (E, C) each.

    A chamber that has not turned yet came from where it was vented.
    """
    at, vented = context.rows.share(context.rows.event_actuation), context.rows.share(context.vented)
    last, before, way, far = (np.zeros_like(at) for _ in range(4))
    for e, b in enumerate(context.started):
        if b == e:  # it began at rest where it is
            last[e] = before[e] = far[e] = at[e]
            continue
        rest = (vented, vented, np.zeros_like(vented), vented)
        old = tuple(v[b] for v in (last, before, way, far)) if b >= 0 else rest
        gone = at[e] - old[3]
        begins = (old[2] == 0) & (np.abs(gone) > _STILL)
        turned = (old[2] * gone < 0) & (np.abs(gone) > _STILL)
        last[e] = np.where(turned, old[3], old[0])
        before[e] = np.where(turned, old[0], old[1])
        way[e] = np.where(begins | turned, np.sign(gone), old[2])
        far[e] = np.where(begins | turned | (old[2] * gone > 0), at[e], old[3])
    return last, before, way


def memory(context: Context) -> list[Feature]:
    """Hats of the pressure by hats of each of the last two turns, and what comes up with the way since the last."""
    rows, x = context.rows, context.rows.fraction
    last, before, way = (values[rows.event] for values in turns(context))

    def hats(values: Floats) -> list[Floats]:
        place = (_POINTS - 1) * np.clip(values, 0.0, 1.0)
        return [np.maximum(1 - np.abs(place - k), 0.0) for k in range(_POINTS)]

    out = []
    for name, turn in (("last", last), ("before", before)):
        out += [
            pressure(f"{name} turn {j} at {i}", now * then, 0.1)
            for i, now in enumerate(hats(x))
            for j, then in enumerate(hats(turn))
        ]
    for share in _WAYS:
        up = way * np.expm1(-np.abs(x - last) / share)
        out += [pressure(f"way {share} load{n}", up * x**n, 0.2) for n in (0, 1, 2)]
    return out
