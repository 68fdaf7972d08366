"""The paper's method is what it should be: its gradient is true, it goes down, and it is left behind."""

import numpy as np
import pytest

from labrig.ik import GradientDescent, Solver
from labrig.surface import Target
from labrig.surface._pose import rotation_of

TRUTH = np.array([10.0, 50.0, 35.0, 20.0])


@pytest.mark.parametrize("name", ["net", "warped"])
def test_gradient_against_differences(request, make_target, name):
    """With the pairs held, the gradient equals central differences of the cost to a ten-thousandth."""
    model = request.getfixturevalue(name)
    search = GradientDescent(model, 20)
    goal = Target(make_target(model, TRUTH))
    pressure, R, t = np.array([25.0, 30.0, 20.0, 40.0]), rotation_of(np.array([0.1, 0.0, 0.05])), np.ones(3)
    feet = goal.nearest.one((model.points(pressure[None], search.uv)[0] - t) @ R)[0]
    partner = goal.mesh.vertices_mm[feet] @ R.T + t

    def cost(p):
        return ((model.points(p[None], search.uv)[0] - partner) ** 2).sum(axis=1).mean()

    expected = [(cost(pressure + 0.05 * e) - cost(pressure - 0.05 * e)) / 0.1 for e in np.eye(4)]
    found = search.gradient(pressure, goal, feet, R, t, np.ones(len(feet)))
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-4 * np.abs(expected).max())


def test_it_goes_down_and_is_left_behind(net, make_target):
    """Every round of the paper's method lowers the cost; labrig's search needs far fewer and ends closer."""
    target = Target(
        make_target(net, TRUTH, rotation_of(np.array([0.05, 0.03, 0.0])), np.array([6.0, -4.0, 3.0]))
    )
    slow = GradientDescent(net, 40).solve(target)
    fast = Solver(net).solve(target)
    assert (np.diff([cost for _, cost in slow.history]) <= 1e-12).all()
    assert fast.iterations < 0.5 * slow.iterations
    assert np.abs(fast.pressure_kpa - TRUTH).max() < 0.5 * np.abs(slow.pressure_kpa - TRUTH).max() + 0.5


def test_points_alone_are_the_same_points(net, warped):
    """Without derivatives a compiled model gives the same points."""
    for model in (net, warped):
        search = GradientDescent(model, 15)
        points, _ = search.evaluate(TRUTH)
        assert np.abs(search.evaluate.points(TRUTH) - points).max() < 1e-3
