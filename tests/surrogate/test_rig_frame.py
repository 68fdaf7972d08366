"""The rig's frame from markers: what they fix of its rotation is taken, what they leave open stays as simulated."""

import numpy as np
import pytest

from labrig.surface import grid
from labrig.surface._pose import rotation_of
from labrig.surrogate import Frames, train_forward, train_warp
from labrig.surrogate._rig_frame import LINE, ONE, SPOT, frame_of_markers

UV, _ = grid(11, 11)
QUARTER = 0.5 * np.pi


@pytest.fixture(scope="module")
def forward(data):
    """A forward model of the simulated sheet."""
    return train_forward(data, samples=6).model


@pytest.fixture(scope="module")
def captured(forward):
    """What some markers show at some pressures, with noise, of a rig that is turned."""

    def make(names, pressure_kpa, turn=(0.0, 0.0, 0.0), noise_mm=0.1, seed=0):
        pressure = np.atleast_2d(np.asarray(pressure_kpa, dtype=float))
        position = forward.points(pressure, forward.markers(names)) @ rotation_of(np.array(turn)).T
        position += noise_mm * np.random.default_rng(seed).normal(size=position.shape)
        return Frames(names, pressure, position)

    return make


@pytest.mark.parametrize(
    "names", [("m01", "m02"), ("m05", "m06"), ("m01", "m04", "m07"), ("m04", "m05", "m06")]
)
@pytest.mark.parametrize("pressure", [[0, 0, 0], [40, 10, 30]])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_line_of_markers_turns_nothing(forward, captured, names, pressure, seed):
    """Markers on one line, in one shape, do not turn the model about it by their noise, and what is open is said."""
    rotation, translation, notes = frame_of_markers(forward, captured(names, pressure, seed=seed))
    assert np.array_equal(rotation, np.eye(3))
    assert np.array_equal(translation, np.zeros(3))
    assert notes in ((SPOT,), (LINE,))


def test_what_is_open_is_said_and_the_rest_of_the_surface_stays(forward, captured):
    """Two markers at one set-point leave the far end of the surface where it was simulated, and the result says so."""
    trained = train_warp(forward, captured(("m01", "m02"), [30, 30, 30]))
    full = [[60.0, 60.0, 60.0]]
    assert np.linalg.norm(trained.model.points(full, UV) - forward.points(full, UV), axis=-1).max() < 3.0
    assert trained.notes == (SPOT,)
    assert SPOT in repr(trained)
    assert trained.model.provenance["notes"] == [SPOT]


def test_a_line_that_lies_elsewhere_is_followed(forward, captured):
    """A row of markers, turned by a quarter, turns the model as far as the row says, and by no more than that."""
    rotation, _, notes = frame_of_markers(
        forward, captured(("m04", "m05", "m06"), [0, 0, 0], (0, 0, QUARTER))
    )
    along = np.ptp(forward.points([[0, 0, 0]], forward.markers(("m04", "m06")))[0], axis=0)
    along /= np.linalg.norm(along)
    assert rotation @ along == pytest.approx(rotation_of(np.array([0, 0, QUARTER])) @ along, abs=0.02)
    assert np.arccos((np.trace(rotation) - 1) / 2) == pytest.approx(QUARTER, abs=0.05)
    assert notes == (LINE,)


@pytest.mark.parametrize("turn", [(0, 0, QUARTER), (0, 0.1, 0), (2.0, -1.0, 0.5)])
@pytest.mark.parametrize(
    "names", [("m01", "m03", "m07"), tuple(f"m{k}" for k in ("01", "02", "04", "05", "09"))]
)
def test_markers_that_fix_a_turn_are_followed(forward, captured, names, turn):
    """Markers beside one line give the rotation of a turned rig, small or large, and nothing is left to say."""
    frames = captured(names, np.random.default_rng(1).random((6, 3)) * 60.0, turn)
    rotation, _, notes = frame_of_markers(forward, frames)
    assert rotation == pytest.approx(rotation_of(np.array(turn, dtype=float)), abs=0.005)
    assert notes == ()


def test_the_way_of_two_markers_tells_a_large_turn_about_their_line(forward, captured):
    """A rig turned by a quarter about its two markers is known by how they move, once they have moved far."""
    names = ("m04", "m06")
    line = np.ptp(forward.points([[0, 0, 0]], forward.markers(names))[0], axis=0)
    turn = QUARTER * line / np.linalg.norm(line)
    pressure = np.random.default_rng(1).random((20, 3)) * 60.0
    rotation, _, notes = frame_of_markers(forward, captured(names, pressure, turn))
    assert rotation == pytest.approx(rotation_of(turn), abs=0.05)
    assert notes == ()


def test_one_marker_says_that_it_does_not_tell(forward, captured):
    """One marker leaves the rotation as simulated, and the result says that it does not know it."""
    frames = captured(("m05",), np.random.default_rng(1).random((6, 3)) * 60.0)
    rotation, _, notes = frame_of_markers(forward, frames)
    assert np.array_equal(rotation, np.eye(3))
    assert notes == (ONE,)
