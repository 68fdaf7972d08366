"""Halton's sequence: the numbers of SciPy's, without SciPy (tests/test_lazy.py)."""

import numpy as np
import pytest
from scipy.stats import qmc

from labrig._halton import halton


@pytest.mark.parametrize("dimensions", [1, 4, 30])
def test_its_numbers_are_those_of_scipy(dimensions: int) -> None:
    """From the first one or a later one on, and permuted by chance, to the last digit."""
    plain = qmc.Halton(dimensions, scramble=False)
    np.testing.assert_array_equal(halton(40, dimensions), plain.random(40))
    plain.fast_forward(60)
    np.testing.assert_array_equal(halton(40, dimensions, first=100), plain.random(40))
    ours, theirs = (np.random.default_rng(7) for _ in range(2))
    for points in (500, 3):  # the second time permuted otherwise, as the generator has gone on
        wanted = qmc.Halton(dimensions, scramble=True, rng=theirs).random(points)
        np.testing.assert_array_equal(halton(points, dimensions, rng=ours), wanted)
