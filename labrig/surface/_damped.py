"""One step of point-to-plane registration that moves nothing by what the pairs do not fix."""

import numpy as np

from labrig.arrays import Floats
from labrig.surface._pose import rotation_of


def damped_step(moved: Floats, height: Floats, normal: Floats, weight: Floats, width_mm: float) -> Floats:
    """The motion (4, 4) that takes points `moved` (n, 3) nearer to the planes under them, `height` (n,) mm below.

    A Gauss-Newton step in the motion's six numbers, turns counted by how far they move the points, with a damping
    (Levenberg 1944) of the square of `width_mm`, the heights' own spread, as a share of the points' size: a motion that
    changes the heights by less, on a way as long as the points reach, stays away. `normal` (n, 3), `weight` (n,).
    """
    middle = weight @ moved / weight.sum()
    centred = moved - middle
    size = max(float(np.sqrt(weight @ (centred**2).sum(axis=1) / weight.sum())), 1e-9)
    rows = np.concatenate([np.cross(centred, normal) / size, normal], axis=1)
    weighed = rows * (weight / weight.sum())[:, None]
    step = -np.linalg.solve(weighed.T @ rows + (width_mm / size) ** 2 * np.eye(6), weighed.T @ height)
    motion = np.eye(4)
    motion[:3, :3] = rotation_of(step[:3] / size)
    motion[:3, 3] = middle - motion[:3, :3] @ middle + step[3:]
    return motion
