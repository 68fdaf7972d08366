"""Singular vectors that are found always, sums of groups, root mean squares."""

from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from labrig.arrays import Floats, Ints


def sums_of(group: Ints, values: NDArray[Any], groups: int) -> Floats:
    """The sum over each of so many groups, numbered from 0, of values (n, ...): (groups, ...). `group` (n,) says to
    which each belongs.
    """
    n = len(group)
    to = csr_matrix((np.ones(n), (group, np.arange(n))), shape=(groups, n))
    return np.asarray(to @ values.reshape(n, -1)).reshape(groups, *values.shape[1:])


def rms(values: Floats) -> float:
    """Root mean square of all values."""
    return float(np.sqrt(np.mean(values**2)))


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
