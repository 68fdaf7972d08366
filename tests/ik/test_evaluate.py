"""Compiled evaluation gives what the model itself gives, and its derivatives are true."""

import numpy as np
import pytest

from labrig.ik import evaluator
from labrig.ik._evaluate import Plain
from labrig.ik._gaussian import compiles
from labrig.ik._reduced import Reduced
from labrig.ik._warped import Warped
from labrig.surface._pose import rotation_of
from labrig.surface._warp import identity_coefficients
from labrig.surrogate import ForwardModel
from labrig.surrogate._corrected import CorrectedHead
from labrig.surrogate._gaussian import fit_gaussian
from labrig.surrogate._kernel import Kernel
from labrig.surrogate._warp_heads import FieldHead
from labrig.surrogate._warped import WarpedModel

PRESSURE = np.array([12.0, 45.0, 30.0, 5.0])


def differences(model, uv, step=0.02):
    def at(pressure):
        return model.points(pressure[None], uv)[0]

    return np.stack(
        [(at(PRESSURE + step * e) - at(PRESSURE - step * e)) / (2 * step) for e in np.eye(4)], axis=-1
    )


@pytest.mark.parametrize("name", ["net", "warped"])
def test_compiled_equals_the_model(request, name):
    """Points agree to 1e-3 mm with the model's own, derivatives with central differences to 1e-4 of the largest."""
    model = request.getfixturevalue(name)
    uv = np.random.default_rng(0).uniform(0, 1, (300, 2))
    points, slope = evaluator(model, uv)(PRESSURE)
    expected = differences(model, uv)
    assert np.abs(points - model.points(PRESSURE[None], uv)[0]).max() < 1e-3
    assert np.abs(slope - expected).max() < 1e-4 * np.abs(expected).max()


def test_a_grid_is_evaluated_line_by_line_to_the_same_points(net):
    """Where many points share a u the net is brought to these u first; nothing else changes."""
    from labrig.surface import grid

    uv, _ = grid(20, 40)
    points, slope = evaluator(net, uv)(PRESSURE)
    assert np.abs(points - net.points(PRESSURE[None], uv)[0]).max() < 1e-3
    exact = net.jacobian(PRESSURE[None], uv)[0]
    assert np.abs(slope - exact).max() < 1e-4 * np.abs(exact).max()


def test_chunks_do_not_show(warped):
    """More points than fit into one chunk are evaluated like few."""
    uv = np.random.default_rng(1).uniform(0, 1, (2500, 2))
    every, some = evaluator(warped, uv), evaluator(warped, uv[2000:2010])
    for whole, part in zip(every(PRESSURE), some(PRESSURE), strict=True):
        assert np.abs(whole[2000:2010] - part).max() < 1e-3


def test_choice(net, warped, mannequin):
    """What can be compiled is; anything else is asked itself."""
    uv = np.array([[0.5, 0.5]])
    kinds = [type(evaluator(model, uv)) for model in (net, warped, mannequin)]
    assert kinds == [Reduced, Warped, Plain]


def test_quick_surface_derivatives(mannequin):
    """The quick surface as a model: its derivatives are its differences."""
    uv, p = np.random.default_rng(2).uniform(0, 1, (50, 2)), np.full((1, 9), 20.0)
    slope = mannequin.jacobian(p, uv)[0]
    for c, e in enumerate(np.eye(9)):
        change = (mannequin.points(p + 0.01 * e, uv) - mannequin.points(p - 0.01 * e, uv))[0] / 0.02
        np.testing.assert_allclose(slope[:, :, c], change, atol=1e-6)


def forward_of(net, head):
    """A forward model with the net's surface and a head of its own."""
    return ForwardModel(
        chamber_names=net.chamber_names,
        low_kpa=net.low_kpa,
        high_kpa=net.high_kpa,
        spline=net.spline,
        mean_mm=net.mean_mm,
        modes_mm=net.modes_mm,
        head=head,
        spread=np.zeros((6, 1)),
        factor=1.0,
    )


def gaussian(net, with_slopes):
    """A Gaussian head that learned the net's coordinates."""
    x = np.random.default_rng(3).uniform(0, 1, (60, 4))
    both = [net.latent(60.0 * row) for row in x]
    values, slopes = np.array([z for z, _ in both]), 60.0 * np.array([dz for _, dz in both])
    return fit_gaussian(x, values, slopes if with_slopes else None, iterations=5)[0]


@pytest.mark.parametrize("with_slopes", [False, True])
def test_a_gaussian_forward_model(net, with_slopes):
    """The compiled Gaussian process gives the model's points and derivatives, up to the modes that do not matter."""
    model = forward_of(net, gaussian(net, with_slopes))
    uv = np.random.default_rng(4).uniform(0, 1, (200, 2))
    points, slope = evaluator(model, uv)(PRESSURE)
    assert np.abs(points - model.points(PRESSURE[None], uv)[0]).max() < 0.1
    exact = model.jacobian(PRESSURE[None], uv)[0]
    assert np.abs(slope - exact).max() < 0.01 * np.abs(exact).max()
    assert np.abs(points - net.points(PRESSURE[None], uv)[0]).max() < 1.0


def corrected(net):
    """A forward model whose coordinates a rig corrected, by gains and by a process of its own."""
    rng = np.random.default_rng(5)
    kernel = Kernel(np.full(4, 0.7), np.full(4, 0.5), np.full(4, 0.3))
    constant, weights = 0.05 * rng.normal(size=6), 0.1 * rng.normal(size=(20, 6))
    points, gain = rng.uniform(0, 1, (20, 4)), np.array([1.02, 0.97, 1.0, 0.95])
    return forward_of(net, CorrectedHead(gaussian(net, True), gain, kernel, points, constant, weights))


def test_a_corrected_forward_model_is_compiled(net):
    """What a rig corrected is compiled like the rest, and gives the model's points and derivatives."""
    model = corrected(net)
    assert compiles(model)
    uv = np.random.default_rng(4).uniform(0, 1, (200, 2))
    points, slope = evaluator(model, uv)(PRESSURE)
    assert np.abs(points - model.points(PRESSURE[None], uv)[0]).max() < 0.05
    exact = model.jacobian(PRESSURE[None], uv)[0]
    assert np.abs(slope - exact).max() < 0.005 * np.abs(exact).max()


@pytest.mark.parametrize("count", [40, 400])
def test_a_warp_in_a_frame_of_its_own(net, count):
    """A learned warp with the rig's frame in it: few points or many, the model's own points and derivatives."""
    rng = np.random.default_rng(6)
    kernel = Kernel(np.full(4, 0.7), np.full(4, 0.5), np.full(4, 0.3))
    head = FieldHead(
        kernel,
        rng.uniform(0, 1, (15, 4)),
        identity_coefficients(9) + 0.01 * rng.normal(size=(13, 3)),
        0.02 * rng.normal(size=(15, 13, 3)),
    )
    turn, shift = rotation_of(np.array([0.3, -0.2, 0.5])), np.array([40.0, -20.0, 7.0])
    places = rng.uniform(0.1, 0.9, (9, 2))
    model = WarpedModel(corrected(net), places, 3e-5, head, rotation=turn, translation_mm=shift)
    uv = rng.uniform(0, 1, (count, 2))
    evaluate = evaluator(model, uv)
    points, slope = evaluate(PRESSURE)
    exact = model.points(PRESSURE[None], uv)[0]
    assert np.abs(points - exact).max() < 0.1
    assert np.abs(evaluate.points(PRESSURE) - exact).max() < 0.1
    exact = model.jacobian(PRESSURE[None], uv)[0]
    assert np.abs(slope - exact).max() < 0.01 * np.abs(exact).max()
