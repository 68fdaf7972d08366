"""What a chamber remembers of where it turned: any law by its pressure now and by the last two places it turned at.

Loops of walls and of sliding parts have many formulas. What all of them act by is where the chamber last turned, where
before that, and how far it has come since (E. Madelung, Ann. Phys. 322 (1905) 861). A loop may also fade as the chamber
moves on, whichever way and however slowly, over more turns than two.
"""

from typing import Literal

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._family import Feature, pressure

_POINTS = 5
_WAYS = (0.02, 0.05, 0.1, 0.2, 0.4)
"""Grids of the places, and of the way since the last turn, shares of the range: no limits of a verdict."""
LENGTHS = (0.12, 0.35, 1.0, 3.0)
"""A grid of the ways on which what was before fades, shares of the range."""
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


def fading(context: Context) -> list[Feature]:
    """What fades by the way that a chamber goes: what trails its pressure, and the square of it, on all of the way, and
    what trails it on the way up only.

    With one length, the loops of B. D. Coleman and M. L. Hodgdon (Int. J. Eng. Sci. 24 (1986) 897), and of R. Bouc and
    Y. K. Wen (J. Eng. Mech. 102 (1976) 249) with an exponent of one, are sums of these while their sign stays.
    """
    out = []
    for length in LENGTHS:
        out += [
            pressure(f"trail {length}", trail(context, length), 0.5),
            pressure(f"trail {length} up", trail(context, length, loading=True), 0.5),
            pressure(f"trail {length} square", trail(context, length, power=2), 0.25),
        ]
    return out


def trail(context: Context, length: float, power: Literal[1, 2] = 1, loading: bool = False) -> Floats:
    """By how much what trails each chamber's pressure, or its square, is off it, shares of the range, (F, C)."""
    drive = (context.rows.event_actuation - context.vented) / context.span
    return trailing(context, drive, length, power, loading) - drive[context.rows.event] ** power


def trailing(
    context: Context, drive: Floats, length: float, power: Literal[1, 2] = 1, loading: bool = False
) -> Floats:
    """What trails a drive of the events, or its square, by the way that it goes, (E, C) -> (F, C).

    While the drive moves, or with `loading` while it moves away from zero, what was before is left to a part of
    1 / e on each `length` of its way: a clock that stands still with it (K. C. Valanis, Arch. Mech. 23 (1971) 517). It
    is zero where the drive began.
    """
    state = drive**power

    def far(x: Floats, way: Floats) -> Floats:
        """What it is on a way that has long gone up (1), or down (-1)."""
        return x - way * length if power == 1 else x**2 - 2 * way * length * x + 2 * length**2

    for e, before in enumerate(context.started):
        x, last = (drive[before], state[before]) if before >= 0 else (np.zeros_like(drive[e]),) * 2
        way = np.sign(drive[e] - x)
        left = np.exp(-np.abs(drive[e] - x) / length)
        moved = far(drive[e], way) + (last - far(x, way)) * left
        state[e] = np.where(way * (drive[e] + x) < 0, last, moved) if loading else moved
    return state[context.rows.event]
