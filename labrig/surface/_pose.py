"""Rigid motions: small ones as vectors, best ones between points, and where to begin when nothing is known."""

import numpy as np

from labrig.arrays import Floats


def rotation_of(vector: Floats) -> Floats:
    """The rotation (3, 3) about the axis `vector` (3,) by its length in rad (Rodrigues)."""
    angle = float(np.sqrt(vector @ vector))
    x, y, z = vector
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < 1e-8:
        return np.eye(3) + K + 0.5 * K @ K
    return np.eye(3) + np.sin(angle) / angle * K + (1.0 - np.cos(angle)) / angle**2 * K @ K


def angle_deg(rotation: Floats) -> float:
    """By how much a rotation turns, degrees."""
    return float(np.rad2deg(np.arccos(np.clip((np.trace(rotation) - 1.0) / 2.0, -1.0, 1.0))))


def upright_frames(points: Floats) -> Floats:
    """Principal axes of points as the columns of a rotation, the longest first, (3, 3)."""
    axes = np.linalg.eigh(np.cov((points - points.mean(axis=0)).T))[1][:, ::-1]
    if np.linalg.det(axes) < 0:
        axes[:, 2] *= -1.0
    return axes


def cube_rotations() -> Floats:
    """The 24 rotations that bring a cube onto itself, (24, 3, 3)."""
    from scipy.spatial.transform import Rotation

    return Rotation.create_group("O").as_matrix()


def spread_rotations(count: int) -> Floats:
    """Rotations spread evenly over all there are, (count, 3, 3): a super-Fibonacci sequence (Alexa 2022)."""
    s = np.arange(count) + 0.5
    r, R = np.sqrt(s / count), np.sqrt(1.0 - s / count)
    alpha, beta = 2.0 * np.pi * s / np.sqrt(2.0), 2.0 * np.pi * s / 1.533751168755204288118041
    x, y, z, w = r * np.sin(alpha), r * np.cos(alpha), R * np.sin(beta), R * np.cos(beta)
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], -1),
            np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], -1),
            np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], -1),
        ],
        axis=1,
    )
