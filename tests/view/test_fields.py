"""What is taken out of a result's fields for drawing."""

import numpy as np

from labrig.view._fields import capture_numbers, cloud, skin, worst_captures


def test_cloud_has_every_marker_in_place(fields):
    """Markers come back as (captures, markers, axes), measured and predicted, at rest where they rest."""
    markers = cloud(fields)
    assert markers is not None
    assert markers.names[16] == "m17"
    k = list(fields["observable"].values).index("m17.z")
    np.testing.assert_array_equal(markers.measured_mm[:, 16, 2], fields["measured"].values[:, k])
    np.testing.assert_array_equal(markers.rest_mm, fields["rest_mm"].values)


def test_no_geometry_is_no_cloud(fields):
    """A result without resting positions, or whose markers lack an axis, has no surface to draw."""
    assert cloud(fields.drop_vars("rest_mm")) is None
    assert cloud(fields.isel(observable=slice(0, 1))) is None


def test_skin_passes_through_the_markers(fields):
    """The surface goes through every marker, and values on it are the markers' own there."""
    rest = fields["rest_mm"].values
    surface = skin(rest)
    assert surface is not None
    np.testing.assert_allclose(surface.vertices(rest)[: len(rest)], rest, atol=1e-6)
    assert surface.triangles.max() == len(surface.weight) - 1
    assert len(surface.triangles) > 16 * len(rest)


def test_markers_on_a_line_have_no_skin():
    """Markers along an arm, or too few of them, span no surface."""
    along = np.linspace(0, 100, 12)[:, None] * np.array([[1.0, 0.5, 0.0]])
    assert skin(along) is None
    assert skin(np.eye(3)) is None


def test_worst_captures_are_the_worst(fields):
    """The worst capture is named with its set-points and the marker where it is worst."""
    spoiled = fields.copy(deep=True)
    k = list(spoiled["observable"].values).index("m05.y")
    spoiled["measured"].values[7, k] += 500.0
    spoiled["commanded"].values[7] = [0, 41, 0, 0, 0, 0, 0, 0, 12.5]
    worst = worst_captures(spoiled)[0]
    assert (worst.capture, worst.where, worst.commanded) == ("7", "m05", "c2 41, c9 12.5 kPa")
    assert worst.base > 40


def test_a_vented_capture_is_called_vented(fields):
    """Set-points that are all zero have a word of their own, unless nothing was ever commanded."""
    vented = fields.copy(deep=True)
    vented["commanded"].values[1:] = 0
    assert {capture.commanded for capture in worst_captures(vented) if capture.capture != "0"} == {"vented"}
    vented["commanded"].values[:] = 0
    assert {capture.commanded for capture in worst_captures(vented)} == {""}


def test_capture_numbers_are_those_of_the_run(fields):
    """Captures keep the numbers of their run, also where only some of them are shown."""
    np.testing.assert_array_equal(capture_numbers(fields.isel(capture=[3, 8, 20])), [3, 8, 20])
    named = fields.isel(capture=[3, 8]).assign_coords(capture=["a", "b"])
    np.testing.assert_array_equal(capture_numbers(named), [0, 1])
