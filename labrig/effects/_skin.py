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
    along, way = _main_way(context)
    return (context.played(width, along) - along[context.rows.event])[:, None] * way


def body_settled(context: Context, power: float) -> Floats:
    """How far the body would go along its main way if that went with a power of the way, (F, K)."""
    along, way = _main_way(context)
    now = along[context.rows.event]
    return (np.sign(now) * np.abs(now) ** power)[:, None] * way


def marker_behind(context: Context, width: float) -> Floats:
    """How far each marker stays behind that is dragged in space by a thread of `width`, of the whole motion, (F, K).

    Dry friction that knows no direction: J. J. Moreau, Trends in Applications of Pure Mathematics to Mechanics II
    (Pitman 1979). Each observable without a marker by itself.
    """
    scale, marker = motion_scale(context), context.rows.marker
    drive = at_events(context) / scale
    of_one = ((marker[:, None] == marker) & (marker >= 0) | np.eye(len(marker), dtype=bool)).astype(float)
    state = drive.copy()
    for e, before in enumerate(context.started):
        behind = drive[e] - (state[before] if before >= 0 else 0.0)
        length = np.sqrt(behind**2 @ of_one)
        state[e] = drive[e] - behind * np.minimum(1.0, width / np.maximum(length, 1e-12))
    return ((state - drive) * scale)[context.rows.event]


def _main_way(context: Context) -> tuple[Floats, Floats]:
    """How far the body is along its main way at each event (E,), as a share of the whole motion, and that way (K,)."""
    drive, scale = at_events(context), motion_scale(context)
    _, _, ways = svd(drive / scale)
    return drive / scale @ ways[0] / np.sqrt(len(scale)), ways[0] * scale * np.sqrt(len(scale))
