"""Angles and quaternions as the model counts them: a whole turn more or less, or the other sign, is no error."""

from dataclasses import replace

import numpy as np

from labrig._turns import quaternions, turn_of
from labrig.effects import Context

_TOGETHER = 0.5
"""How much errors agree but for whole turns: the length of their mean direction, 0.5 where they spread by a sixth."""


def as_the_model_turns(context: Context) -> Context:
    """The campaign with each angle within half a turn of what the model says and its zero is off, and each quaternion
    on the model's side.

    An angle that was seen over more than a turn counts turns itself, and stays as it is; so does one that is off by any
    share of a turn: whole ones explain nothing there.
    """
    rows = context.rows
    values = rows.values.copy()
    for k, unit in enumerate(rows.unit):
        seen = values[np.isfinite(values[:, k]), k]
        turn = turn_of(unit)
        if turn and len(seen) and np.ptp(seen) <= turn:
            off = values[:, k] - context.base[:, k]
            mean = np.nanmean(np.exp(2j * np.pi * off / turn))
            if abs(mean) >= _TOGETHER:
                values[:, k] -= turn * np.round((off - turn / (2 * np.pi) * np.angle(mean)) / turn)
    for own in quaternions(rows.unit, values):
        away = (values[:, own] * context.base[:, own]).sum(axis=1) < 0
        values[away, own] *= -1
    same = np.array_equal(values, rows.values, equal_nan=True)
    return context if same else replace(context, rows=replace(rows, values=values))
