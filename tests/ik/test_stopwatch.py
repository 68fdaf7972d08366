"""What a search took is told apart from what numba took to compile it."""

import numpy as np
from numba import njit

from labrig.ik._solve import Solver
from labrig.ik._stopwatch import stopwatch


def test_compiling_is_counted_apart():
    """The first call of a compiled function is compiling, not work; the second call compiles nothing."""

    @njit
    def twice(x):
        return 2.0 * x

    with stopwatch() as so_far:
        twice(np.ones(3))
        first = so_far()
        twice(np.ones(3))
        second = so_far()
    assert first[1] > 0.0
    assert second[1] == first[1]


def test_a_result_says_what_was_compiled(mannequin):
    """A search of which everything is compiled already says so; its times are those of the search alone."""
    solver = Solver(mannequin)
    solver.solve(solver.half_shape)
    result = solver.solve(solver.half_shape)
    assert result.compile_s == 0.0
    assert result.time_s > 0.0
    assert result.to_dict()["compile_ms"] == 0.0
