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


@pytest.mark.parametrize("chambers", [1, 4, 9])
def test_a_step_stays_within_the_limits(chambers):
    """Chambers end at a limit or a reach away, and for all that are free the damped equations hold."""
    random = np.random.default_rng(chambers)
    held = 0
    for _ in range(50):
        slopes = random.normal(size=(chambers + 9, chambers + 6))
        H, g = slopes.T @ slopes, 30.0 * random.normal(size=chambers + 6)
        low, high = np.zeros(chambers), random.uniform(20.0, 60.0, chambers)
        value = np.clip(random.uniform(-0.3, 1.3, chambers), 0.0, 1.0) * high
        step = _kernels.bounded_step(H, g, 1e-3, value, low, high)
        reach = _kernels.REACH * high
        least, most = np.maximum(-value, -reach), np.minimum(high - value, reach)
        assert (step[:chambers] >= least - 1e-9).all()
        assert (step[:chambers] <= most + 1e-9).all()
        free = np.r_[(step[:chambers] > least) & (step[:chambers] < most), np.ones(6, bool)]
        own = np.diag(H).copy()
        own[:chambers] = (own[:chambers] * high**2).max() / high**2
        at_rest = free & (step != 0)  # a chamber at its limit that is pushed outwards stays, and is not free
        np.testing.assert_allclose(((H + np.diag(1e-3 * own)) @ step)[at_rest], -g[at_rest], rtol=1e-6)
        held += int((~free).sum())
    assert held > 0


def test_a_step_where_two_chambers_do_the_same():
    """Equations that do not tell two chambers apart give a finite step, whichever way they are rounded."""
    for seed in range(60):
        random = np.random.default_rng(seed)
        slope = 1e4 * random.normal(
            size=(6, 8)
        )  # so large that rounding outweighs what is added to the diagonal
        slope[:, 1] = slope[:, 0]
        step = _kernels.bounded_step(
            slope.T @ slope, random.normal(size=8), 1e-18, np.full(2, 20.0), np.zeros(2), np.full(2, 40.0)
        )
        assert np.isfinite(step).all()
        assert (np.abs(step[:2]) <= 16.0 + 1e-9).all()


@pytest.mark.parametrize("count", [0, 1, 2, 7, 40])
def test_the_median_of_the_usable(count):
    """The median is that of the pairs that count, by their size; without any it is zero."""
    plane = np.random.default_rng(count).normal(size=count + 3)
    usable = np.r_[np.ones(count), np.zeros(3)]
    wanted = np.median(np.abs(plane[:count])) if count else 0.0
    assert _kernels.median_of(plane, usable) == wanted
