"""Singular vectors, also of a matrix on which LAPACK's fast way gives up; and sums of groups."""

import numpy as np
import pytest

from labrig._linalg import sums_of, svd


@pytest.mark.parametrize("gives_up", [False, True])
@pytest.mark.parametrize("shape", [(40, 7), (7, 40)])
def test_a_matrix_is_the_product_of_its_parts(gives_up, shape, monkeypatch):
    """Orthonormal vectors and falling values whose product is the matrix, whichever way finds them."""

    def fails(*_, **__):
        raise np.linalg.LinAlgError("SVD did not converge")

    random = np.random.default_rng(0)
    matrix = random.normal(size=(shape[0], 3)) @ random.normal(size=(3, shape[1]))
    if gives_up:
        monkeypatch.setattr(np.linalg, "svd", fails)
    U, s, Vt = svd(matrix)
    assert U.shape == (shape[0], 7)
    assert Vt.shape == (7, shape[1])
    assert (np.diff(s) <= 0).all()
    np.testing.assert_allclose(U.T @ U, np.eye(7), atol=1e-12)
    np.testing.assert_allclose(Vt @ Vt.T, np.eye(7), atol=1e-12)
    np.testing.assert_allclose((U * s) @ Vt, matrix, atol=1e-12)


def test_sums_of_groups() -> None:
    """Each group has the sum of its own values, whatever their shape and order; one without any has nothing."""
    values = np.arange(12.0).reshape(4, 3)
    sums = sums_of(np.array([2, 0, 2, 0]), values, 4)
    assert sums.tolist() == [[12.0, 14.0, 16.0], [0.0] * 3, [6.0, 8.0, 10.0], [0.0] * 3]
    assert sums_of(np.array([1, 1, 0]), np.ones((3, 2, 2)), 2).tolist() == [[[1.0] * 2] * 2, [[2.0] * 2] * 2]
