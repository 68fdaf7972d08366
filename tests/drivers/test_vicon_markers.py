"""Markers in labrig's order, axes and unit, and why one is not there."""

import numpy as np
import pytest

from labrig_drivers import MarkerStatus
from labrig_drivers._cgstream_objects import LABELED_DTYPE, Subject
from labrig_drivers._cgstream_session import CgFrame, Statics
from labrig_drivers._vicon_markers import MarkerTable

SEEN, OCCLUDED, NOT_SUBSCRIBED = MarkerStatus.SEEN, MarkerStatus.OCCLUDED, MarkerStatus.NOT_SUBSCRIBED


def frame_of(rows, subjects, y_up=False, types=(5, 6)):
    """A frame with `rows` of (subject, marker, position)."""
    labeled = np.zeros(len(rows), LABELED_DTYPE)
    for index, (subject, marker, position) in enumerate(rows):
        labeled[index]["subject"], labeled[index]["marker"] = subject, marker
        labeled[index]["position"] = position
    statics = Statics(100.0, {s.id: s for s in subjects}, y_up)
    return CgFrame(1, statics, frozenset(types), labeled, np.zeros(0, LABELED_DTYPE))


TORSO = Subject(1, "torso", {1: "a", 2: "b"}, {}, {})
OTHER = Subject(9, "other", {1: "b", 7: "c"}, {}, {})


def test_absent_is_occluded_and_unknown_is_not_subscribed():
    """A marker that the server knows and leaves out is occluded; one that it does not know, not subscribed."""
    position, status = MarkerTable(["b", "a", "x"]).place(frame_of([(1, 1, (1, 2, 3))], [TORSO]))
    assert status.tolist() == [OCCLUDED, SEEN, NOT_SUBSCRIBED]
    assert position[1].tolist() == [1, 2, 3]
    assert np.isnan(position[[0, 2]]).all()


def test_no_marker_data_is_not_subscribed():
    """In a frame without the labelled markers' block nothing is occluded: it was not subscribed."""
    _, status = MarkerTable(["a"]).place(frame_of([], [TORSO], types=(5,)))
    assert status.tolist() == [NOT_SUBSCRIBED]


def test_coordinates_that_are_no_numbers_are_occluded():
    """A position with NaN or infinity in it is no position."""
    rows = [(1, 1, (np.nan, 2, 3)), (1, 2, (1, np.inf, 3))]
    position, status = MarkerTable(["a", "b"]).place(frame_of(rows, [TORSO]))
    assert status.tolist() == [OCCLUDED, OCCLUDED]
    assert np.isnan(position).all()


def test_subject_decides_between_equal_names():
    """With a subject named, another subject's marker of the same name does not count."""
    rows = [(1, 2, (1, 1, 1)), (9, 1, (2, 2, 2))]
    for subject, expected in (("torso", 1.0), ("other", 2.0), (None, 1.0)):
        position, _ = MarkerTable(["b"], subject).place(frame_of(rows, [TORSO, OTHER]))
        assert position[0, 0] == expected
    _, status = MarkerTable(["b"], "nobody").place(frame_of(rows, [TORSO, OTHER]))
    assert status.tolist() == [NOT_SUBSCRIBED]


@pytest.mark.parametrize(
    ("y_up", "up", "expected"),
    [(False, "z", (1, 2, 3)), (True, "z", (1, -3, 2)), (True, "y", (1, 2, 3)), (False, "y", (1, 3, -2))],
)
def test_axes_are_turned_to_what_the_rig_asks_for(y_up, up, expected):
    """Y-up and Z-up servers give the same right-handed positions in the rig's frame."""
    position, _ = MarkerTable(["a"], up=up).place(frame_of([(1, 1, (1, 2, 3))], [TORSO], y_up))
    assert position[0].tolist() == list(expected)


def test_metres_and_other_names():
    """A server that speaks metres and calls the markers otherwise is read in mm under the rig's names."""
    table = MarkerTable(["m01"], rename={"m01": "a"}, mm_per_unit=1000.0)
    position, status = table.place(frame_of([(1, 1, (0.1, 0.2, 0.3))], [TORSO]))
    np.testing.assert_allclose(position, [[100, 200, 300]])
    assert status.tolist() == [SEEN]


def test_new_subjects_are_learned():
    """When the server's subjects change, markers are found under their new numbers."""
    table = MarkerTable(["b"])
    table.place(frame_of([(1, 2, (1, 1, 1))], [TORSO]))
    position, _ = table.place(frame_of([(1, 2, (1, 1, 1)), (9, 1, (2, 2, 2))], [OTHER]))
    assert position[0].tolist() == [2, 2, 2]


def test_a_marker_sent_twice_takes_its_last_position():
    """Of two entries for one marker the last counts."""
    position, _ = MarkerTable(["a"]).place(frame_of([(1, 1, (1, 1, 1)), (1, 1, (2, 2, 2))], [TORSO]))
    assert position[0].tolist() == [2, 2, 2]


def test_an_empty_frame_after_new_subjects():
    """A frame without any marker right after the subjects changed has all of them occluded."""
    table = MarkerTable(["b"])
    table.place(frame_of([(1, 2, (1, 1, 1))], [TORSO]))
    position, status = table.place(frame_of([], [OTHER]))
    assert status.tolist() == [OCCLUDED]
    assert np.isnan(position).all()
