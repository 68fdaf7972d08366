"""What several rigs share: names, and the law of a membrane that stiffens with the cube of its deflection."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable


def chambers(count: int) -> tuple[str, ...]:
    """The names of the chambers: c1, c2, ..."""
    return tuple(f"c{i + 1}" for i in range(count))


def markers(count: int) -> tuple[tuple[str, ...], tuple[Observable, ...]]:
    """The names of the markers, and their coordinates in mm, marker by marker."""
    names = tuple(f"m{i + 1}" for i in range(count))
    return names, tuple(
        Observable(f"{name}.{'xyz'[axis]}", "mm", i, axis)
        for i, name in enumerate(names)
        for axis in range(3)
    )


def cubic_membrane(load: Floats, cubic: Floats) -> Floats:
    """The deflection d with (1 - cubic) d + cubic d^3 = load: 1 at load 1, and as much the other way below zero."""
    linear = 1.0 - cubic
    scale = 2.0 * np.sqrt(linear / (3.0 * cubic))
    return scale * np.sinh(np.arcsinh(3.0 * load / (linear * scale)) / 3.0)


def turns(rotation: Floats) -> tuple[Floats, Floats]:
    """The matrices (..., 3, 3) of rotation vectors (..., 3), and the means of the rotations up to each: what a straight
    way that is bent evenly comes to.
    """
    angle = np.linalg.norm(rotation, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(rotation, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)
    sine, half = np.sinc(angle / np.pi), 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    small = angle < 1e-3
    third = np.where(small, 1 / 6, (1 - sine) / np.where(small, 1.0, angle) ** 2)
    square = cross @ cross
    return np.eye(3) + sine * cross + half * square, np.eye(3) + half * cross + third * square
