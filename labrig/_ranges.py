"""Shares of the ranges that chambers may go through, counted from a vented chamber."""

import numpy as np
from numpy.typing import ArrayLike

from labrig.arrays import Floats


def ends(low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Where ranges from `low` to `high` begin, and how far they go from there with its sign, (C,) each.

    A range begins at the limit that is nearer to a vented chamber: a rig that is driven by vacuum, -60 to 0 kPa, is the
    same rig as one whose vacuum is counted from 0 to 60.
    """
    origin = np.where(np.abs(high) < np.abs(low), high, low)
    return origin, low + high - 2 * origin


def within(low: Floats, high: Floats, share: ArrayLike, lowest: float = 0.0, highest: float = 1.0) -> Floats:
    """Set-points at a `share` of the ranges from `low` to `high` (C,), in their unit, (..., C).

    Of the way from a vented chamber to either limit they use the part from `lowest` to `highest`.
    """
    origin, span = ends(low, high)
    vented = np.clip(0.0, low, high)
    way = origin + np.asarray(share) * span - vented
    limit = np.where(way * span < 0, origin, origin + span)
    return vented + lowest * (limit - vented) + (highest - lowest) * way


def rounded(low: Floats, high: Floats, setpoint: Floats) -> Floats:
    """Set-points as they are commanded: with three decimals, and within `low` to `high` (C,) all the same."""
    return np.clip(np.round(setpoint, 3), low, high)
