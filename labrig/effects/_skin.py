"""What acts where it is seen, not in a chamber: histories of the observables themselves."""

import numpy as np

from labrig._linalg import svd
from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._family import motion_scale


def at_events(context: Context) -> Floats:
    """The predicted displacement at each event (E, K): of its rows, else by the chambers' deflections."""
    rows = context.rows
    E = len(rows.event_session)
    count = np.bincount(rows.event, minlength=E)
    total = np.zeros((E, context.base.shape[1]))
    np.add.at(total, rows.event, context.displacement)
    out = total / np.maximum(count, 1)[:, None]
    alone = count == 0
    if alone.any():
        by_chamber = np.linalg.lstsq(context.deflection, context.displacement, rcond=None)[0]
        out[alone] = context.event_deflection[alone] @ by_chamber
    return out


def play_behind(context: Context, width: float) -> Floats:
    """How far a play of `width`, a share of the whole motion, of each observable stays behind it, (F, K)."""
    drive = at_events(context)
    return context.played(width * motion_scale(context), drive) - drive[context.rows.event]


def lag_behind(context: Context, tau_s: float) -> Floats:
    """How far a first-order lag of each observable stays behind it, (F, K)."""
    drive = at_events(context)
    return context.lagged(tau_s, drive) - drive[context.rows.event]


def body_behind(context: Context, width: float) -> Floats:
    """How far the body stays behind, all of it, where a play of `width` holds its main way of moving back, (F, K)."""
    drive, scale = at_events(context), motion_scale(context)
    _, _, ways = svd(drive / scale)
    along = drive / scale @ ways[0]
    behind = context.played(width * np.sqrt(len(scale)), along) - along[context.rows.event]
    return behind[:, None] * ways[0] * scale
