"""Whether a run's chambers are those of their names: none of them exchanged."""

from itertools import combinations

import numpy as np

from labrig._errors import LabrigError
from labrig.surrogate._captures import Frames
from labrig.surrogate._forward import ForwardModel

_EXCHANGED = 0.5
"""So much nearer to the model a run's markers move with chambers exchanged, where they are."""


def check_chambers(forward: ForwardModel, frames: Frames) -> None:
    """Raise `LabrigError` where the markers move as the model's do with the pressures of some chambers exchanged.

    `frames` are in the simulator's frame. Only how the markers move counts, not where they are.
    """
    seen = frames.captured.any(axis=0)
    uv = forward.markers(tuple(np.array(frames.marker_names)[seen]))
    there, own = frames.position_mm[:, seen], list(range(len(forward.chamber_names)))

    def off_mm(order: list[int]) -> float:
        off = forward.points(frames.pressure_kpa[:, order], uv) - there
        return float(np.sqrt(np.nanmean((off - np.nanmean(off, axis=0)) ** 2)))

    named = exchanged = off_mm(own)
    order, going = own, len(own) > 1
    while going:
        tried = [_exchange(order, i, j) for i, j in combinations(own, 2)]
        least, best = min((off_mm(one), one) for one in tried)
        if going := least < exchanged:
            exchanged, order = least, best
    if exchanged < _EXCHANGED * named:
        names = forward.chamber_names
        which = ", ".join(
            f"the run's {names[k]} is the model's {names[c]}" for c, k in enumerate(order) if c != k
        )
        raise LabrigError(
            f"sim2real: chambers are exchanged, by how the surface moves: {which} (markers {exchanged:.2g} instead of "
            f"{named:.2g} mm off); exchange the tubes and measure again, or the names in the run"
        )


def _exchange(order: list[int], i: int, j: int) -> list[int]:
    new = order.copy()
    new[i], new[j] = order[j], order[i]
    return new
