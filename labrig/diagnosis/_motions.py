"""How the base itself moves, where that is wrong: another way, as places beside it do, or by another curve.

It has no name, and is no mystery: no model is exact. A pattern of its own for each chamber (`_unnamed`) holds all this,
too, but with so many coefficients that effects which cancel one another are the plainer explanation.
"""

from collections.abc import Iterator

import numpy as np

from labrig.arrays import Floats
from labrig.effects import (
    FEW_OBSERVABLES,
    STRAINS,
    Context,
    Feature,
    Space,
    acting,
    any_curve,
    by_marker,
    field,
    reached,
    to_rows,
)

MOTION = "motion"
"""What these spaces belong to: one of them holds."""
_WIDTHS = (0.25, 0.5, 1.0)
"""How far beside a marker places are whose motion it may have, of the body's radius: a grid."""
_BODY = 9
"""Coordinates of markers from which on they are a body."""
_LEAST = 0.05
"""Of the motion's size: what changes it less is not made larger than itself."""


def motions(context: Context) -> Iterator[Space]:
    """The base's own error of form in few numbers.

    Each marker's motion goes through one small linear map (a turn, a shear, one axis against another: a model whose
    axes are not the rig's, or whose body gives way otherwise across than along); or it has the motion of places beside
    it (markers or patches that sit elsewhere, a mesh that is too coarse). Or walls follow another curve, which is then
    one with that of the effects of a chamber's own pressure; or a chamber moves as its neighbours do, too, which is one
    with what reaches it from them. Or each of several sensors has a bow of its own (IEC 61298-2).
    """
    if not context.moves:
        return
    rows = context.rows
    known = rows.rest_mm is not None and bool(np.isfinite(rows.rest_mm).all())
    if known and (rows.axis >= 0).sum() >= _BODY and (rows.marker >= 0).any():
        motion = by_marker(context, context.displacement)
        load = context.deflection.mean(axis=1)[:, None, None]
        out = list(_otherwise(context, motion))
        out += [
            field(f"{name} load", to_rows(context, load * (motion @ way.T)), 0.3 * weight)
            for name, way, weight in _maps()
        ]
        yield Space("how all moves", MOTION, acting(out))
    if curves := list(_of_sensors(context)):
        yield Space("what each sensor makes of it", MOTION, acting(curves))
    yield any_curve(context)
    if len(rows.chambers) > 1:
        yield reached(context)


def _of_sensors(context: Context) -> Iterator[Feature]:
    """A bow and an S of each of a few sensors, (F, K) each; the axes of one or two markers are sensors, too. None of a
    single one, whose own curve is that of all that moves it; nor a gain, which is what is settled of any history.
    """
    rows, moved = context.rows, context.displacement
    of_markers = np.flatnonzero((rows.axis >= 0) & (np.abs(moved).max(axis=0) > 0))
    own = np.flatnonzero((rows.axis < 0) & (np.abs(moved).max(axis=0) > 0))
    own = np.union1d(own, of_markers) if len(of_markers) < _BODY else own
    if len(own) > FEW_OBSERVABLES or len(own) + len(of_markers) < 2:
        return
    for k in own:
        most = np.abs(moved[:, k]).max()
        for power, weight in ((2, 0.5), (3, 0.3)):
            values = np.zeros_like(moved)
            values[:, k] = most * (moved[:, k] / most) ** power
            yield field(f"{rows.observables[k]} to the power of {power}", values, weight)


def _otherwise(context: Context, motion: Floats) -> Iterator[Feature]:
    """A motion (F, M, 3) that goes another way, and that places beside each marker have, (F, K) each."""
    for name, way, weight in _maps():
        yield field(name, to_rows(context, motion @ way.T), weight)
    size = float(np.sqrt((motion**2).mean()))
    for name, beside in _beside(context):
        moved = beside @ motion
        own = float(np.sqrt((moved**2).mean()))
        yield field(name, to_rows(context, moved * size / max(own, _LEAST * size, 1e-300)), 0.5)


def _maps() -> Iterator[tuple[str, Floats, float]]:
    """Small linear maps (3, 3) that leave the mean scale as it is: turns, shears, one axis against another."""
    for a, name in enumerate("xyz"):
        turn = np.cross(np.eye(3)[a], np.eye(3)).T
        yield f"about {name}", turn, 1.0
    for name, strain in STRAINS.items():
        yield name, strain, 0.5


def _beside(context: Context) -> Iterator[tuple[str, Floats]]:
    """Weights (M, M) of other places' motions: of all about a marker less its own, and of those ahead of it."""
    place = context.rows.rest_mm
    assert place is not None
    radius = float(np.sqrt(((place - place.mean(axis=0)) ** 2).sum(axis=1).mean())) or 1.0
    apart = (place[None] - place[:, None]) / radius
    for width in _WIDTHS:
        near = np.exp(-0.5 * (apart**2).sum(axis=2) / width**2)
        near /= near.sum(axis=1, keepdims=True)
        yield f"blurred {width}", near - np.eye(len(place))
        for a, name in enumerate("xyz"):
            yield f"along {name} {width}", near * apart[:, :, a] / width
