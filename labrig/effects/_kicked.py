"""When the frame was moved: a camera that was pushed, a rig that shifted in its clamp, at one moment of a session."""

from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._family import Space, acting, field
from labrig.effects._fields import frame_modes
from labrig.effects._in_parts import affine
from labrig.effects._slips import errors_by_capture, in_scatters, moment, step_gain

_FEWEST = 8


@dataclass(frozen=True)
class Kick:
    """The clearest step of the frame: `first` is the first capture after it, `among` of how many moments."""

    first: int
    among: int

    def after(self, context: Context) -> Floats:
        """Which rows lie after it, (F,) of 0 and 1."""
        return (context.rows.capture >= self.first).astype(float)

    def moment_s(self, context: Context) -> float:
        """When it was, s since the run began."""
        return moment(context.rows, self.first)


def kick(context: Context) -> Kick | None:
    """Where the captures' own rigid motions step most; None of too few captures, or of markers that cannot say one."""
    rows = context.rows
    if rows.n_captures < _FEWEST or (rows.axis >= 0).sum() < 6:
        return None
    captures, error = errors_by_capture(context)
    modes = frame_modes(context).mean(axis=0)
    modes = modes / np.maximum(np.sqrt((modes**2).mean(axis=0)), 1e-12)
    motion = error @ np.linalg.pinv(modes, rcond=1e-6).T
    gain = step_gain(in_scatters(motion))
    return Kick(int(captures[int(np.argmax(gain)) + 1]), len(captures)) if gain.max() > 0 else None


def since_a_kick(context: Context) -> Space | None:
    """The frame was moved at the moment that a scan of the residuals finds: any affine motion of all markers since."""
    found = kick(context)
    if found is None:
        return None
    after = found.after(context)[:, None]
    moved = [field(f"{f.name} since", f.values * after, f.weight) for f in affine(context)]
    key, places = f"moved before capture {found.first}", found.among
    return Space(key, "frame since", acting(moved), scanned=places, absolute=False)
