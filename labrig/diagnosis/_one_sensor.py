"""One sensor, or one marker, alone: what is wrong with its gain, its zero or its curve says nothing of the others.

Without this such a fault is named after what comes nearest to it through the pressures, which moves them all.
"""

from collections.abc import Iterator

import numpy as np

from labrig.arrays import Ints
from labrig.diagnosis._alone import FEWEST, MOST
from labrig.diagnosis._observations import Observations
from labrig.effects import Context, Feature, Space, acting, field, motion_scale

_WAVES = 4
"""Half waves along a sensor's reach that its characteristic may have: two turns of a wheel that is out of true."""
SENSOR = "sensor"
"""What one sensor, or one marker, has wrong in itself."""


def of_one_sensor(observations: Observations) -> Iterator[Space]:
    """Curves of the set-points in that sensor or marker in which most of what is missing is, if it is a half or more,
    and a sensor's gain alone; none where there are two or fewer.
    """
    context = observations.context
    group = np.unique(context.rows.owner, return_inverse=True)[1]
    beyond = (observations.values**2 - observations.left[:, None]).sum(axis=0)
    each = np.maximum(np.bincount(group, weights=beyond), 0.0)
    seen = len(np.unique(group[observations.seen]))
    most = int(each.argmax())
    if seen < FEWEST or not each.any() or each[most] < MOST * each.sum():
        return
    own = np.flatnonzero(group == most)
    name = _name(context, own)
    if len(own) == 1:
        yield Space(f"{name} alone, gain", f"{SENSOR} gain", acting([_gain(context, own[0])]), scanned=seen)
    yield Space(f"{name} alone", SENSOR, acting(list(_curves(context, own))), scanned=seen)


def _name(context: Context, own: Ints) -> str:
    """The marker that these observables are of, or the observable's own name."""
    rows = context.rows
    return rows.markers[rows.marker[own[0]]] if rows.marker[own[0]] >= 0 else rows.observables[own[0]]


def _gain(context: Context, k: int) -> Feature:
    """A gain of the k-th observable that is off, about the sensor's zero: a share of what the base predicts."""
    out = np.zeros_like(context.base)
    size = float(np.sqrt((context.base[:, k] ** 2).mean())) or 1.0
    out[:, k] = (motion_scale(context)[k] or 1.0) / size * context.base[:, k]
    return field(f"gain of {k}", out)


def _curves(context: Context, own: Ints) -> Iterator[Feature]:
    """What may be off in a sensor: its gain, its zero, its characteristic (waves along its reach); and each set-point
    and its square. All have the size of its motion.
    """
    x, moved = context.rows.fraction, context.displacement
    scale = motion_scale(context)
    for k in own:
        size, reach = scale[k] or 1.0, float(np.ptp(moved[:, k]))
        functions = {"gain": (moved[:, k] / size, 1.0), "zero": (np.ones(len(x)), 0.3)}
        if reach > 0:
            along = np.pi * (moved[:, k] - moved[:, k].min()) / reach
            functions |= {f"wave {n}": (np.cos(n * along), 0.3) for n in range(1, _WAVES + 1)}
        for c in range(x.shape[1]):
            functions[f"pressure {c}"] = (x[:, c], 0.3)
            functions[f"pressure {c} square"] = (x[:, c] ** 2, 0.3)
        for name, (values, weight) in functions.items():
            out = np.zeros_like(moved)
            out[:, k] = size * values
            yield field(f"{name} of {k}", out, weight)
