"""What no programme of set-points can make sure."""

from labrig.effects import library
from labrig.experiment._told import _never_sure


def test_a_name_that_set_points_never_make_sure_is_said() -> None:
    """A body that leans is as good a frame that was moved: the line says how sure it can be, and what confirms it."""
    (line,) = _never_sure(["frame", "leak", "my_own"], library())
    assert line.startswith("frame is never called sure from set-points alone (57 % at most): ")
    assert line.endswith("to confirm it: register the measuring frame by three fixed markers right before")
