"""A measuring frame that is turned by more than a little: the turn that fits best, solved exactly."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from labrig.arrays import Floats, Ints
from labrig.effects._context import Context
from labrig.effects._fields import centre_of
from labrig.effects._rows import Rows

FEWEST = 3
"""Markers from which on a turn is determined."""


def whole_markers(rows: Rows) -> Ints:
    """The observables (M, 3) along x, y, z of each marker that has all three."""
    found = []
    for m in np.unique(rows.marker[rows.marker >= 0]):
        own = [np.flatnonzero((rows.marker == m) & (rows.axis == a)) for a in range(3)]
        if all(len(o) == 1 for o in own):
            found.append([int(o[0]) for o in own])
    return np.array(found, dtype=np.int64).reshape(-1, 3)


def turn_of(context: Context) -> Floats | None:
    """The rotation vector (3,), rad, of the one turn that takes the predicted places nearest to the measured ones.

    None where fewer than three markers have all coordinates. The least squares of Kabsch, Acta Cryst. A 32 (1976) 922.
    """
    at = whole_markers(context.rows)
    if len(at) < FEWEST:
        return None
    predicted, measured = context.base[:, at], context.rows.values[:, at]
    seen = np.isfinite(measured).all(axis=2)
    a, b = predicted[seen], measured[seen]
    if len(a) < FEWEST or np.linalg.matrix_rank(a - a.mean(axis=0), tol=1e-6) < 2:
        return None
    found = Rotation.align_vectors(b - b.mean(axis=0), a - a.mean(axis=0))
    return np.asarray(found[0].as_rotvec(), dtype=float)


def turned(context: Context, turn_rad: Floats) -> Floats:
    """The change (F, K) of the observables that a turn about the centre of the markers at rest makes."""
    at = whole_markers(context.rows)
    out = np.zeros_like(context.base)
    about = context.base[:, at] - centre_of(context)
    out[:, at] = _apply(turn_rad, about) - about
    return out


def carried(context: Context, turn_rad: Floats) -> Context:
    """The same context where all that the model says of motions is turned, as the frame in which they are seen is."""
    at = whole_markers(context.rows)

    def turn(values: Floats) -> Floats:
        out = values.copy()
        out[..., at] = _apply(turn_rad, values[..., at])
        return out

    return replace(
        context,
        displaced=turn(context.displacement),
        elsewhere=None,
        jacobian=np.moveaxis(turn(np.moveaxis(context.jacobian, 1, 2)), 2, 1),
        inside={name: turn(change) for name, change in context.inside.items()},
        _memo={},
    )


def _apply(turn_rad: Floats, vectors: Floats) -> Floats:
    return np.asarray(Rotation.from_rotvec(turn_rad).apply(vectors.reshape(-1, 3))).reshape(vectors.shape)
