"""What set-points alone seldom make sure."""

from labrig.effects import library
from labrig.experiment._propose import _seldom_sure


def test_a_name_that_is_seldom_sure_is_said() -> None:
    """A body that leans is as good a frame that was moved: the line says how sure it can be, and what confirms it."""
    (line,) = _seldom_sure(["frame", "leak", "my_own"], library())
    assert line.startswith("frame is sure only where its formula predicts better than all others (")
    assert line.endswith(
        " % at most where another does as well); to confirm it: the vented surface, registered again by three fixed "
        "markers"
    )
