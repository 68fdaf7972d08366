"""Surfaces that are flat but for a dome: a scan beside its place is brought there and is not thrown off."""

import numpy as np
import pytest

from labrig.surface import Mesh, grid, register
from labrig.surface._damped import damped_step

UV, TRIANGLES = grid(61, 61)
START = np.eye(3), np.zeros(3)


def sheet(height_mm, width):
    """A flat sheet of 200 mm with one round dome in its middle."""
    up = height_mm * np.exp(-((UV - 0.5) ** 2).sum(axis=1) / width)
    return np.stack([200 * UV[:, 0], up, 200 * UV[:, 1]], axis=1)


@pytest.mark.parametrize("noise_mm", [0.0, 0.1])
@pytest.mark.parametrize("shift", [(1.0, 0.0, 0.5), (3.0, 0.0, 2.0), (10.0, 0.0, 5.0)])
@pytest.mark.parametrize("dome", [(20.0, 0.03), (5.0, 0.03), (20.0, 0.12)])
def test_a_scan_beside_its_place_is_brought_there(dome, shift, noise_mm):
    """From some millimetres aside a sheet's dome comes to lie on its dome, and the sheet is hardly turned about it."""
    there = sheet(*dome)
    noise = noise_mm * np.random.default_rng(0).normal(size=there.shape)
    found = register(Mesh(there + shift + noise, TRIANGLES), Mesh(there, TRIANGLES), START)
    middle = np.array([100.0, dome[0], 100.0])
    assert np.linalg.norm(found.apply(middle + shift) - middle) < 0.25
    assert np.linalg.norm(found.apply(there + shift) - there, axis=1).max() < 5.0


def test_a_step_moves_nothing_that_the_pairs_do_not_fix():
    """On a plane a step takes away the height and the tilt, and neither shifts nor turns along the plane."""
    rng = np.random.default_rng(0)
    points = np.stack([*(100 * rng.random((2, 500))), np.zeros(500)], axis=1)
    height = 1.0 + 0.02 * points[:, 0] + 0.01 * rng.normal(size=500)
    points[:, 2] = height
    normal = np.tile([0.0, 0.0, 1.0], (500, 1))
    motion = damped_step(points, height, normal, np.ones(500), 0.01)
    moved = points @ motion[:3, :3].T + motion[:3, 3]
    assert np.abs(moved[:, 2]).max() < 0.1
    assert motion[:2, 3] == pytest.approx([0.0, 0.0], abs=0.05)
    assert motion[0, 1] == pytest.approx(0.0, abs=1e-6)
