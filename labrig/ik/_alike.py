"""Whether the model's surface can be turned onto itself: then a target lies on it in several ways, equally well."""

import numpy as np

from labrig.arrays import Floats
from labrig.surface import Mesh

ALIKE = 0.008
"""Root mean square distance, as a share of the size, up to which a turned surface is the same."""


def turns_onto_itself(shape: Mesh) -> list[tuple[Floats, Floats]]:
    """The motions (rotation, translation) that bring a square grid of points onto itself, without the identity.

    A mirror image is no motion; a sheet that would lie upside down counts only if it does not bulge.
    """
    points = shape.vertices_mm
    side = round(np.sqrt(len(points)))
    number = np.arange(len(points)).reshape(side, side)
    middle = points.mean(axis=0)
    own = points - middle
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    found = []
    for flipped in (number, number.T):
        for quarters in range(4):
            other = own[np.rot90(flipped, quarters).ravel()]
            if other is own or np.array_equal(other, own):
                continue
            left, _, right = np.linalg.svd(other.T @ own)
            R = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
            if np.sqrt(((own @ R.T - other) ** 2).sum(axis=1).mean()) < ALIKE * size:
                found.append((R, middle - R @ middle))
    return found
