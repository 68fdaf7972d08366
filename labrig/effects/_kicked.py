"""When the frame was moved, for good or for a while: a camera that was pushed, a rig that shifted in its clamp."""

import numpy as np

from labrig.effects._context import Context
from labrig.effects._family import Space, acting, field
from labrig.effects._fields import frame_modes
from labrig.effects._in_parts import affine, orientations
from labrig.effects._rows import capture_means
from labrig.effects._slips import errors_by_capture, in_scatters
from labrig.effects._stretches import Stretch, stretch_of


def kick(context: Context) -> Stretch | None:
    """When the captures' own rigid motions are most another; None of too few captures or coordinates.

    A marker or two cannot say a motion in each capture: there it is what each coordinate does with the places.
    """
    rows = context.rows
    if (seen := int((rows.axis >= 0).sum())) < 3:
        return None
    captures, error = errors_by_capture(context)
    if len(captures) < 2:  # there is no scatter from one capture to the next
        return None
    if seen < 6:
        own = rows.axis >= 0
        turns, _ = capture_means(frame_modes(context)[:, own, 3:], rows.capture)
        turns = turns / np.maximum(np.sqrt((turns**2).mean(axis=(0, 1))), 1e-12)
        ways = np.concatenate([np.ones((*turns.shape[:2], 1)), turns], axis=2)
        return stretch_of(captures, in_scatters(error[:, own]), ways)
    modes = frame_modes(context).mean(axis=0)
    modes = modes / np.maximum(np.sqrt((modes**2).mean(axis=0)), 1e-12)
    motion = in_scatters(error @ np.linalg.pinv(modes, rcond=1e-6).T)
    return stretch_of(captures, motion, np.ones((*motion.shape, 1)))


def since_a_kick(context: Context) -> Space | None:
    """The frame was moved at the moment that a scan of the residuals finds: any affine motion of all markers since."""
    found = kick(context)
    if found is None:
        return None
    then = found.holds(context.rows.capture)[:, None]
    seen = [*affine(context), *orientations(context)]
    moved = [field(f"{f.name} since", f.values * then, f.weight) for f in seen]
    return Space(f"moved {found}", "frame since", acting(moved), scanned=found.among, absolute=False)
