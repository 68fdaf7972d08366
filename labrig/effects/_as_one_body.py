"""What follows something that was logged does to the body as a whole."""

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._family import Feature, acting, field, motion_scale, pressure
from labrig.effects._fields import frame_modes


def as_one_body(context: Context, values: Floats) -> tuple[Feature, ...]:
    """The pressures' zero and gain, and the rigid motions of all markers, that follow `values` (F,), however large.

    Nothing where the pressures move nothing: what follows a logged value there is free at each observable.
    """
    if not context.moves:
        return ()
    x = context.rows.fraction
    whole = (values / np.abs(values).max())[:, None]
    out = [pressure("held", np.repeat(whole, x.shape[1], axis=1)), pressure("held load", whole * x)]
    if (context.rows.axis >= 0).sum() >= 3:
        modes = frame_modes(context)
        modes = modes / (np.sqrt((modes**2).mean(axis=(0, 1))) + 1e-12) * motion_scale(context)[:, None]
        out += [field(f"mode {j}", modes[:, :, j] * whole, 0.5) for j in range(modes.shape[2])]
    return acting(out)
