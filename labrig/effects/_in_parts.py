"""What is another in each part of a run: how the body is seen in each session, or how it gives way in each pose.

Where each session has a pose of its own, the two are the same functions, and one space for both: what the frame did
between two sessions can't be told from what the weight did.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.effects._context import Context
from labrig.effects._family import Feature, Space, acting, field, motion_scale
from labrig.effects._fields import (
    STRAINS,
    frame_modes,
    orientation_modes,
    scale_mode,
    smooth_places,
    strain_modes,
)
from labrig.effects._sessions import MOST_SESSIONS

_AFFINE = ("x", "y", "z", "about x", "about y", "about z", "scale", *STRAINS)
_BENT = 0.1
"""Prior variance of each smooth bend, as those of a rest shape."""
_LIKELY = (1.0,) * 6 + (0.3,) + (0.1,) * 5


def affine(context: Context) -> Iterator[Feature]:
    """A rigid motion of all markers, a scale and a skew, each (F, K) of the size of the rig's motion."""
    modes = np.concatenate(
        [frame_modes(context), scale_mode(context)[:, :, None], strain_modes(context)], axis=2
    )
    size = context.yardstick("motions of all", lambda: np.sqrt((modes**2).mean(axis=(0, 1))))
    modes = modes / np.where(size > 0, size, 1.0) * motion_scale(context)[None, :, None]
    for j, (name, weight) in enumerate(zip(_AFFINE, _LIKELY, strict=True)):
        yield field(name, modes[:, :, j], weight)


def orientations(context: Context) -> Iterator[Feature]:
    """Quaternions as a turned frame sees them, about each axis, (F, K) of the size of the rig's motion; none of a run
    that has none.
    """
    modes = orientation_modes(context)
    size = context.yardstick("orientations", lambda: np.sqrt((modes**2).mean(axis=(0, 1))))
    modes = modes / np.where(size > 0, size, 1.0) * motion_scale(context)[None, :, None]
    for a, letter in enumerate("xyz"):
        if modes[:, :, a].any():
            yield field(f"seen about {letter}", modes[:, :, a])


def bends(context: Context) -> Iterator[Feature]:
    """Smooth bends of the body: squares of the places at rest along each axis, (F, K)."""
    scale, there = motion_scale(context), np.ones((len(context.base), 1))
    for i, shape in enumerate(smooth_places(context).T):
        yield field(f"bend {i}", there * scale * shape, _BENT)


def in_each(part: Ints, features: Iterable[Feature]) -> tuple[Feature, ...]:
    """Fields, each for every part (F,) of a run by itself; parts are counted as they come."""
    _, first, part = np.unique(part, return_index=True, return_inverse=True)
    order = np.argsort(np.argsort(first))[part.reshape(-1)]
    there = (order[:, None] == np.arange(len(first))).astype(float)
    return acting(
        [
            field(f"{f.name} in {i}", f.values * there[:, i, None], f.weight)
            for f in features
            for i in range(len(first))
        ]
    )


def another_in_each(context: Context, part: Ints) -> Space:
    """Another affine motion of all markers in each part (F,) of a run, whoever has it."""
    return Space("in each part", "affine in each part", in_each(part, affine(context)), absolute=False)


def another_bend_in_each(context: Context, pose: Ints) -> Space:
    """The same and smooth bends, which a body has under its weight and a frame has not."""
    both = in_each(pose, [*affine(context), *bends(context)])
    return Space("bent in each pose", "bent in each pose", both, absolute=False)


def poses_of(pulls: list[Floats]) -> Ints | None:
    """Which rows have the same weights and directions (F,), by what pulls; None where all have, or too many differ."""
    if not pulls:
        return None
    _, pose = np.unique(np.round(np.stack(pulls, axis=1), 3), axis=0, return_inverse=True)
    pose = pose.reshape(-1)
    return pose if 1 <= pose.max() < MOST_SESSIONS else None
