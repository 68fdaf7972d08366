"""Forward models: what they promise of errors, derivatives and doubt, whichever way they were trained."""

import numpy as np
import pytest

from labrig import LabrigError
from labrig.surface import grid
from labrig.surrogate import TrainingSet, load_forward, train_forward
from labrig.surrogate._likelihood import _Objective
from labrig.surrogate._torch_training import Recipe

SMALL = Recipe((24, 24), "gelu", epochs=60, batch=16, rate=5e-3, one_cycle=True)
SMALL_PAPER = Recipe((16, 16), "relu", batch_norm=True, epochs=30, batch=16, rate=5e-3)
RECIPES = {"gaussian": None, "network": SMALL, "paper": SMALL_PAPER}


@pytest.fixture(scope="module", params=RECIPES)
def trained(request, data):
    """A model of each method."""
    own = data if request.param != "paper" else data.without_slopes()
    return request.param, train_forward(own, request.param, recipe=RECIPES[request.param], samples=12)


def test_errors_are_on_shapes_that_were_not_seen(trained, data):
    """The error is far below what the shapes differ by, and the split covers all shapes once."""
    _, result = trained
    spread = np.linalg.norm(data.control_mm - data.control_mm.mean(axis=0), axis=-1).mean()
    assert result.errors["mean_mm"] < 0.5 * spread
    split = result.model.provenance["split"]
    assert sorted(split["learn"] + split["test"]) == list(range(100))
    assert len(split["test"]) == 30


def test_what_was_trained_is_shown_in_short_and_saved(trained, tmp_path):
    """A notebook shows its ranges and its errors in a few lines, and one call keeps the model."""
    _, result = trained
    text = repr(result)
    assert len(text) < 600
    assert f"mean {result.errors['mean_mm']:.3g} mm" in text
    for name, low, high in zip(
        result.model.chamber_names, result.model.low_kpa, result.model.high_kpa, strict=True
    ):
        assert f"{name} {low:g} to {high:g} kPa" in text
    result.save(tmp_path / "forward.pt")
    back = load_forward(tmp_path / "forward.pt")
    a, (uv, _) = [[13.0, 41.0, 27.0]], grid(4, 4)
    assert np.allclose(back.points(a, uv), result.model.points(a, uv))


def test_jacobian(trained):
    """The derivative by the pressures is that of central differences."""
    _, result = trained
    uv, _ = grid(4, 4)
    a = np.array([[13.0, 41.0, 27.0]])
    J = result.model.jacobian(a, uv)
    for c in range(3):
        step = 1e-4 * np.eye(3)[c]
        numeric = (result.model.points(a + step, uv) - result.model.points(a - step, uv)) / 2e-4
        assert np.allclose(J[..., c], numeric, atol=2e-6)


def test_points_are_modes_and_mean(trained):
    """Control points are the mean and the modes weighted by the latent coordinates, and points lie on their spline."""
    _, result = trained
    model, a = result.model, np.array([5.0, 50.0, 20.0])
    z, slope = model.latent(a)
    control = model.mean_mm + np.tensordot(z, model.modes_mm, axes=1)
    uv, _ = grid(6, 6)
    assert np.allclose(model.spline.evaluate(control, uv), model.points(a, uv)[0], atol=1e-9)
    assert slope.shape == (len(z), 3)


def test_doubt_is_positive(trained):
    """Standard deviations are positive everywhere."""
    _, result = trained
    uv, _ = grid(6, 6)
    assert (result.model.sd_mm(np.full((2, 3), 30.0), uv) > 0).all()


def test_same_seed_same_model(data):
    """The same seed gives the same model, bit by bit."""
    a, b = (train_forward(data, "paper", seed=3, recipe=SMALL_PAPER, samples=6).model for _ in range(2))
    assert np.array_equal(a.modes_mm, b.modes_mm)
    assert a.factor == b.factor


def test_gaussian_is_better_with_slopes(data):
    """Slopes, where there are any, make the Gaussian process more exact."""
    few = data.take(np.arange(8, 28))
    with_slopes = train_forward(few, samples=12).errors["mean_mm"]
    without = train_forward(few.without_slopes(), samples=12).errors["mean_mm"]
    assert with_slopes < 0.7 * without


def test_gaussian_covers_what_it_says(data):
    """About 95 % of the surface of shapes that were not seen lies within 1.96 standard deviations."""
    covered = [train_forward(data, seed=s, samples=12).errors["coverage_95"] for s in range(4)]
    assert 0.88 < np.mean(covered) < 0.99


def test_likelihood_gradient():
    """The gradient of the marginal likelihood is that of central differences."""
    rng = np.random.default_rng(0)
    objective = _Objective(rng.random((30, 3)), rng.normal(size=(30, 4)))
    theta = np.append(rng.normal(scale=0.3, size=9), -3.0)
    gradient = objective(theta)[1]
    for i in range(len(theta)):
        step = 1e-5 * np.eye(len(theta))[i]
        numeric = (objective(theta + step)[0] - objective(theta - step)[0]) / 2e-5
        assert gradient[i] == pytest.approx(numeric, rel=1e-4, abs=1e-5)


def test_wrong_pressures_and_markers_are_named(trained):
    """Pressures of another number of chambers, and markers that do not exist, are refused by name."""
    _, result = trained
    with pytest.raises(LabrigError) as caught:
        result.model.control(np.zeros((2, 4)))
    assert str(caught.value) == "forward model: pressures of shape (2, 4) given, (captures, 3) needed"
    with pytest.raises(LabrigError) as caught:
        result.model.markers(("m01", "m99"))
    assert str(caught.value) == "forward model: it has no marker 'm99' (it has m01 to m09)"


def test_too_few_shapes(data):
    """A handful of simulations is refused with the numbers that are needed."""
    with pytest.raises(LabrigError) as caught:
        train_forward(data.take(np.arange(10)))
    assert str(caught.value) == (
        "forward: 10 simulations with a share of 0.7 leave 7 to learn from and 3 to test on; "
        "at least 12 and 1 are needed"
    )
    assert isinstance(data, TrainingSet)
