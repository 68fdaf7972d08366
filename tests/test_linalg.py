"""Singular vectors, also of a matrix on which LAPACK's fast way gives up."""

import numpy as np
import pytest

from labrig._linalg import svd


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
