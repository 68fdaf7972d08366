"""The space warp: its formula, its derivatives, and the one through given points."""

import numpy as np
import pytest

from labrig import LabrigError
from labrig.surface._warp import Warp


def _warp(seed=0, count=7):
    rng = np.random.default_rng(seed)
    coefficients = rng.normal(size=(count + 4, 3))
    coefficients[1:4] = np.eye(3) + 0.05 * rng.normal(size=(3, 3))
    return Warp(rng.uniform(-100.0, 100.0, (count, 3)), coefficients, 3e-5), rng


def test_formula():
    """A warp is an affine map and a sum of Gaussian bells, term by term."""
    warp, rng = _warp()
    p = rng.uniform(-100.0, 100.0, 3)
    expected = warp.coefficients[0] + p @ warp.coefficients[1:4]
    for q, beta in zip(warp.centers_mm, warp.coefficients[4:], strict=True):
        expected = expected + beta * np.exp(-3e-5 * np.sum((p - q) ** 2))
    assert np.allclose(warp.apply(p)[0], expected, rtol=0, atol=1e-9)


def test_identity_moves_nothing():
    """The identity leaves every point where it is."""
    points = np.random.default_rng(1).normal(size=(20, 3)) * 50
    assert np.array_equal(Warp.identity(points[:5], 3e-5).apply(points), points)


def test_jacobian_by_points():
    """The derivative by the point is that of central differences."""
    warp, rng = _warp(2)
    points = rng.uniform(-100.0, 100.0, (5, 3))
    for axis in range(3):
        step = 1e-3 * np.eye(3)[axis]
        numeric = (warp.apply(points + step) - warp.apply(points - step)) / 2e-3
        assert np.allclose(warp.jacobian(points)[:, :, axis], numeric, atol=1e-7)


def test_jacobian_by_centers():
    """The derivative by moving centers is that of central differences."""
    warp, rng = _warp(3)
    points, change = rng.uniform(-100.0, 100.0, (5, 3)), rng.normal(size=(7, 3, 2))
    for k in range(2):
        there, back = (
            Warp(warp.centers_mm + s * 1e-4 * change[:, :, k], warp.coefficients, 3e-5).apply(points)
            for s in (1.0, -1.0)
        )
        assert np.allclose(warp.by_centers(points, change)[:, :, k], (there - back) / 2e-4, atol=1e-7)


def test_through_meets_the_targets():
    """Interpolation takes every center to its target."""
    rng = np.random.default_rng(4)
    centers = rng.uniform(-150.0, 150.0, (20, 3))
    targets = centers + rng.normal(size=(20, 3))
    assert np.allclose(Warp.through(centers, targets, 3e-4).apply(centers), targets, atol=1e-4)


def test_through_leaves_an_affine_map_to_its_affine_part():
    """An affine motion of the centers is met without any bell."""
    rng = np.random.default_rng(5)
    centers = rng.uniform(-150.0, 150.0, (12, 3))
    turned = 1.02 * centers @ np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) + 3.0
    warp = Warp.through(centers, turned, 1e-4)
    assert np.abs(warp.coefficients[4:]).max() < 1e-6


def test_wrong_shapes_are_refused():
    """Coefficients that are not the centers' are named, and so are missing targets."""
    with pytest.raises(LabrigError) as caught:
        Warp(np.zeros((3, 3)), np.zeros((5, 3)), 1e-5)
    assert str(caught.value) == "warp: 3 centers need coefficients (7, 3), not (5, 3)"
    with pytest.raises(LabrigError) as caught:
        Warp.through(np.zeros((4, 3)), np.full((4, 3), np.nan), 1e-5)
    assert str(caught.value) == "warp: four or more centers, each with a finite target, are needed"
