"""B-spline surfaces: what they meet, their derivatives, their fits and the grid of the unit square."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from labrig._errors import LabrigError
from labrig.surface import Spline, grid


def wavy(u, v):
    """A curved surface in mm."""
    return np.stack([100 * u, 20 * np.sin(3 * u) * np.cos(2 * v), 120 * v + 5 * u * v], axis=-1)


def points(count, seed=0):
    """Random places in the unit square, corners among them."""
    corners = np.array([[0, 0], [0, 1], [1, 0], [1, 1.0]])
    return np.concatenate([corners, np.random.default_rng(seed).random((count, 2))])


@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize(("du", "dv"), [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)])
def test_basis_matches_scipy(degree, du, dv):
    """Values and derivatives are those of scipy's B-splines on the same knots."""
    spline = Spline((9, 7), degree)
    uv = points(50)
    inside = np.clip(uv, 0, 1 - 1e-13)

    def along(axis, derivative):
        columns = []
        for i in range(spline.count[axis]):
            unit = np.eye(spline.count[axis])[i]
            curve = BSpline(spline.knots[axis], unit, degree)
            if derivative > degree:
                columns.append(np.zeros(len(uv)))
            else:
                columns.append(
                    curve.derivative(derivative)(inside[:, axis]) if derivative else curve(inside[:, axis])
                )
        return np.stack(columns, axis=1)

    expected = (along(0, du)[:, :, None] * along(1, dv)[:, None, :]).reshape(len(uv), -1)
    np.testing.assert_allclose(spline.basis(uv, du, dv).toarray(), expected, atol=1e-8)


def test_a_function_of_the_basis_is_interpolated_exactly():
    """Interpolation reproduces what lies in the spline's space, and meets anything else at Greville points."""
    spline = Spline((8, 11))

    def bilinear(u, v):
        return np.stack([3 * u, 2 * v - u * v, u * u + v], axis=-1)

    uv = points(40)
    control = spline.interpolate(bilinear)
    np.testing.assert_allclose(spline.evaluate(control, uv), bilinear(uv[:, 0], uv[:, 1]), atol=1e-10)
    u, v = np.meshgrid(*spline.greville, indexing="ij")
    met = spline.evaluate(spline.interpolate(wavy), np.stack([u.ravel(), v.ravel()], 1))
    np.testing.assert_allclose(met, wavy(u.ravel(), v.ravel()), atol=1e-9)


def test_many_surfaces_at_once_equal_one_after_another():
    """Leading axes of the control points are kept."""
    spline = Spline((6, 5))
    control = np.random.default_rng(1).normal(size=(2, 3, 6, 5, 3))
    uv = points(10)
    together = spline.evaluate(control, uv, du=1)
    assert together.shape == (2, 3, len(uv), 3)
    np.testing.assert_allclose(together[1, 2], spline.evaluate(control[1, 2], uv, du=1), atol=1e-12)


def test_fit_finds_the_surface_that_made_the_points():
    """With enough points, least squares returns the control points themselves."""
    spline = Spline((9, 9))
    control = spline.interpolate(wavy)
    uv = points(2000)
    np.testing.assert_allclose(spline.fit(spline.evaluate(control, uv), uv), control, atol=1e-4)


def test_fit_with_few_points_meets_them_and_stays_smooth():
    """Where no data is, the control net carries on smoothly instead of being undefined."""
    spline = Spline((12, 12))
    uv = points(30, seed=3)
    fitted = spline.fit(wavy(uv[:, 0], uv[:, 1]), uv)
    np.testing.assert_allclose(spline.evaluate(fitted, uv), wavy(uv[:, 0], uv[:, 1]), atol=0.05)
    assert np.abs(fitted).max() < 200


def test_grid_winds_outwards():
    """Triangle normals of the grid point along d/dv x d/du, and every vertex is used."""
    uv, triangles = grid(4, 3)
    assert uv.shape == (12, 2)
    assert triangles.shape == (12, 3)
    assert set(triangles.ravel()) == set(range(12))
    a, b, c = (uv[triangles[:, k]] for k in range(3))
    assert (((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) < 0).all()


def test_refusals_are_one_line():
    """What does not fit is refused with the numbers that do not fit."""
    with pytest.raises(LabrigError, match=r"^spline: 2 x 9 control points of degree 2: more control points"):
        Spline((2, 9))
    spline = Spline((4, 5))
    with pytest.raises(LabrigError, match=r"^spline: \(u, v\) must be finite and lie between 0 and 1$"):
        spline.basis([[0.5, np.nan]])
    with pytest.raises(
        LabrigError, match=r"^spline: control points of shape \(4, 4, 3\) given, \(\.\.\., 4, 5, 3\)"
    ):
        spline.evaluate(np.zeros((4, 4, 3)), [[0.5, 0.5]])
    with pytest.raises(LabrigError, match="at least three finite points"):
        spline.fit(np.full((5, 3), np.nan), np.full((5, 2), 0.5))
