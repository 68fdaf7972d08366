"""A plate that many sensors of one length meet: the heights of a skin, or a row of rangefinders."""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.effects._context import FEW_OBSERVABLES, Context
from labrig.effects._family import Space, acting, field, motion_scale, one_way, pressure
from labrig.effects._speeds import LENGTHS

_LEVELS = (0.4, 0.55, 0.7, 0.85)
"""Where the plate stands, shares of the way from the lowest value to the farthest: a stop between two of these is
nearly a mixture of their features."""
_MET = 0.005
"""Share of what was predicted that has to be beyond a plate for it to be asked about."""


def plates(context: Context) -> Iterator[Space]:
    """All sensors of one length stop at one value, from above or from below, each by itself or with what moves them.

    Where each is, is not known, so a plate is not aslant.
    """
    for unit in dict.fromkeys(context.rows.unit):
        own = np.flatnonzero((np.array(context.rows.unit) == unit) & (context.rows.marker < 0))
        if unit not in LENGTHS - {"deg", "rad"} or len(own) <= FEW_OBSERVABLES:
            continue
        push = pushing(context)
        for side in (1.0, -1.0):
            yield from _across(context, own, side, push)


def _across(context: Context, own: Ints, side: float, push: Callable[[Floats], Floats]) -> Iterator[Space]:
    """Plates at several heights that these sensors (n,) meet on one side."""
    height = side * context.base[:, own]
    sign = "+" if side > 0 else "-"
    low, high = context.yardstick(f"heights {sign}{context.rows.unit[own[0]]}", partial(_ends_of, height))
    for level in _LEVELS:
        met, pushed = [], []
        for name, share, weight in (("back", 0.0, 1.0), ("sooner", -0.1, 0.3), ("later", 0.07, 0.3)):
            past = np.maximum(height - low - (level + share) * (high - low), 0.0)
            change = np.zeros_like(context.base)
            change[:, own] = -side * past
            met.append(field(name, change, weight))
            pushed.append(pressure(name, push(change), weight))
        if context.shows(bool((met[0].values != 0).mean() >= _MET)):
            yield one_way(Space(f"plate {sign}{level}", "contact sensors' plate", acting(met)))
            yield one_way(Space(f"plate {sign}{level}, chambers", "contact plate's push", acting(pushed)))


def pushing(context: Context) -> Callable[[Floats], Floats]:
    """What a push does to the pressures, shares of the range (F, C), where it would change the observables by so much
    (F, K): by virtual work it pushes the chambers back that move a place, and so all that these move.
    """
    scale = motion_scale(context)
    scale = np.where(scale > 0, scale, 1.0)
    slopes = (context.jacobian * context.span / scale[:, None]).transpose(0, 2, 1)
    most = max(float(context.yardstick("slopes", (slopes**2).sum(axis=2).max)), 1e-300)
    return lambda change: np.asarray((slopes @ (change / scale)[..., None])[..., 0] / most)


def _ends_of(height: Floats) -> Floats:
    return np.array([np.percentile(height, 5), height.max()])
