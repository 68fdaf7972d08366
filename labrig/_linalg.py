"""Singular vectors that are found always."""

import numpy as np
import scipy.linalg

from labrig.arrays import Floats


def svd(matrix: Floats) -> tuple[Floats, Floats, Floats]:
    """U (m, k), s (k,) and V' (k, n) of a matrix (m, n) without gaps, k the smaller of m and n.

    Divide and conquer, LAPACK's fast way, gives up on some matrices of low rank ("SVD did not converge"). QR iteration,
    which takes up to three times as long, finds them, too.
    """
    try:
        U, s, Vt = np.linalg.svd(matrix, full_matrices=False)
    except np.linalg.LinAlgError:
        U, s, Vt = scipy.linalg.svd(matrix, full_matrices=False, lapack_driver="gesvd")
    return U, s, Vt
