"""Few captures, few markers: every method learns what there is, and claims no error that it has not seen."""

from dataclasses import replace

import numpy as np
import pytest

from labrig import LabrigError
from labrig.surface import grid
from labrig.surrogate import Frames, load_model, save_model, train_forward, train_warp

UV, _ = grid(7, 7)
UP = np.array([0.0, 1.0, 0.0])
SAID = "nothing was left out, so how far it is off is not known: that takes "


@pytest.fixture(scope="module")
def forward(data):
    """A forward model of the simulated sheet."""
    return train_forward(data, samples=6).model


@pytest.fixture(scope="module")
def captured(forward):
    """So many captures of so many markers, each 1 mm higher than simulated."""

    def make(captures, markers):
        pressure = np.random.default_rng(2).random((captures, 3)) * 60.0
        names = tuple(f"m{k + 1:02d}" for k in range(markers))
        position = forward.points(pressure, forward.markers(names)) + UP
        return Frames(names, pressure, position + 0.05 * np.random.default_rng(3).normal(size=position.shape))

    return make


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("method", ["ours", "function", "marker"])
@pytest.mark.parametrize(("captures", "markers"), [(1, 9), (2, 9), (3, 9), (2, 2), (6, 1)])
def test_few_captures_are_learned_from_as_far_as_they_go(
    forward, captured, method, captures, markers, tmp_path
):
    """However few they are, there is a finite model that can be saved, and no error is given that was not measured."""
    if method != "ours":
        pytest.importorskip("torch")
    if method == "marker" and (captures < 2 or markers < 4):
        pytest.skip("it says what it needs")
    trained = train_warp(forward, captured(captures, markers), method=method)
    save_model(trained.model, tmp_path / "few.pt")
    again = load_model(tmp_path / "few.pt")
    pressure = np.array([[10.0, 20.0, 30.0]])
    assert np.isfinite(again.points(pressure, UV)).all()
    assert (again.sd_mm(pressure, UV) > 0).all()
    assert np.isfinite(trained.fixed_mm).all()
    measured = captures > (2 if method == "marker" else 1) and markers > 1
    assert (len(trained.fixed_mm) > 0) == (len(trained.simulated_mm) > 0) == measured
    if not measured:
        needs = (
            "three set-points with every marker" if method == "marker" else "two set-points and two markers"
        )
        assert trained.left_out == SAID + needs


def test_without_an_error_the_deviation_is_how_far_the_simulation_is_off(forward, captured):
    """Where nothing can be left out, the paper's method takes its correction for no surer than the simulation was."""
    pytest.importorskip("torch")
    frames = captured(6, 1)
    far = Frames(frames.marker_names, frames.pressure_kpa, frames.position_mm + 7.0 * UP)
    model = train_warp(forward, far, method="function").model
    assert 1.96 * model.noise_mm == pytest.approx(8.0, abs=0.3)


@pytest.mark.parametrize("markers", [1, 3])
def test_too_few_markers_for_a_warp_are_refused(forward, captured, markers):
    """The paper's method for markers says that it needs four that are not in one plane."""
    pytest.importorskip("torch")
    with pytest.raises(
        LabrigError, match="the method marker needs four markers that are not all in one plane"
    ):
        train_warp(forward, captured(6, markers), method="marker")


def test_a_model_that_is_not_finite_is_not_written(forward, tmp_path):
    """Numbers that are none are refused when a model is saved, not when it is loaded, and no file is left."""
    broken = forward.mean_mm.copy()
    broken[0, 0, 0] = np.nan
    with pytest.raises(
        LabrigError, match=r"bad\.pt: was not written: the model's mean_mm has numbers that are not"
    ):
        save_model(replace(forward, mean_mm=broken), tmp_path / "bad.pt")
    assert list(tmp_path.iterdir()) == []


def test_no_pressures_give_no_points(forward, captured):
    """No set of pressures is a legal question, of a simulated and of a corrected model: the answer has none."""
    model = train_warp(forward, captured(3, 9)).model
    for one in (forward, model):
        assert one.points(np.zeros((0, 3)), UV).shape == (0, len(UV), 3)
        assert one.jacobian(np.zeros((0, 3)), UV).shape == (0, len(UV), 3, 3)
        assert one.sd_mm(np.zeros((0, 3)), UV).shape == (0, len(UV))
