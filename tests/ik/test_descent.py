"""The search itself: its gradient is that of the mean distance, borders included, and where it ends nothing is left."""

import numpy as np
import pytest

from labrig.ik import GradientDescent, Pose, Solver, _kernels
from labrig.surface import Mesh, Target, distances, grid
from labrig.surface._pose import rotation_of

WIDTH_MM, MOST_MM = 1.0, 60.0


def flared(net, seed, count=(71, 81), reach=0.05):
    """A part of a shape with waves that no chamber can make, and a border that flares."""
    uv, triangles = grid(*count)
    rng = np.random.default_rng(seed)
    points = net.points(rng.uniform(5, 55, (1, 4)), 0.2 + 0.6 * uv)[0]
    out = points - [0.0, 0.0, points[:, 2].mean()]
    out[:, 2] = 0.0
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    height = 12.0 * np.exp(-np.minimum(uv, 1 - uv).min(axis=1) / reach)
    height *= np.sin(5.0 * uv[:, 1] + rng.uniform(0, 6))
    for _ in range(4):
        along, across = rng.integers(1, 4, 2)
        height += (
            1.5 * rng.normal() * np.sin(2 * np.pi * (along * uv[:, 0] + rng.uniform()) + across * uv[:, 1])
        )
    return Mesh(points + out * height[:, None], triangles)


def test_the_gradient_is_that_of_the_mean(net):
    """By every pressure and motion, with pairs that come and go at the border: differences, to a tenth."""
    search = Solver(net, samples=150).descent
    goal = Target(flared(net, 3, (131, 151), 0.06))
    pressure, rotation, shift = (
        np.array([25.0, 30.0, 20.0, 40.0]),
        rotation_of(np.array([0.02, 0.0, 0.01])),
        np.ones(3),
    )
    here = search.look(goal, pressure, rotation, shift)
    given = here.points, here.slope, here.offset, here.plane, here.normal, here.usable
    _, found = _kernels.mean_equations(*given, here.drift, WIDTH_MM, MOST_MM, search.middle)
    _, held = _kernels.mean_equations(*given, 0 * here.drift, WIDTH_MM, MOST_MM, search.middle)

    def mean(step):
        turn = rotation_of(step[4:7])
        moved = turn @ (shift - search.middle) + search.middle + step[7:]
        there = search.look(goal, pressure + step[:4], turn @ rotation, moved)
        return _kernels.mean_size(there.plane, there.usable, WIDTH_MM, MOST_MM)

    sizes = np.array([1.0] * 4 + [0.004] * 3 + [1.0] * 3)
    expected = [(mean(size * e) - mean(-size * e)) / 2 for size, e in zip(sizes, np.eye(10), strict=True)]
    largest = np.abs(expected).max()
    off, off_held = (np.abs(gradient * sizes - expected).max() / largest for gradient in (found, held))
    assert off < 0.1
    assert off_held > 0.15  # it is the border that makes the difference


@pytest.mark.parametrize("seed", [0, 3, 6, 13])
def test_it_ends_closer_than_the_papers_method(net, seed):
    """Also on parts that cannot be reached, where what lies opposite changes with every step."""
    goal = Target(flared(net, seed))
    uv, _ = grid(100, 100)

    def mean_mm(found):
        placed = (net.points(found.pressure_kpa[None], uv)[0] - found.translation_mm) @ found.rotation
        return distances(placed, goal.mesh, goal.nearest).summary()["mean_mm"]

    paper = mean_mm(GradientDescent(net, 60, borders=False).solve(goal))
    assert mean_mm(Solver(net).solve(goal)) < 1.005 * paper


def test_limits_that_are_near_are_tried(net, make_target):
    """Chambers that end close to a limit are put there, all at once, where that is closer to the target."""
    search = Solver(net).descent
    pose, nearly = (np.eye(3), np.zeros(3)), np.array([4.0, 56.0, 4.0, 45.0])
    goal = Target(make_target(net, np.array([0.0, 60.0, 0.0, 45.0])))
    found = search._at_limits(goal, search.look(goal, nearly, *pose), 0.0)
    assert found is not None
    np.testing.assert_allclose(found.pressure, [0.0, 60.0, 0.0, 45.0], atol=0.5)
    assert found.mean_mm() < 0.12
    goal = Target(make_target(net, nearly))
    there, _ = search.run(goal, nearly, Pose.identity(), 20)
    assert search._at_limits(goal, there, 0.0) is None
    assert search._at_limits(goal, search.look(goal, np.full(4, 30.0), *pose), 0.0) is None
