"""What no programme of set-points can make sure."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from labrig.contents import Expected
from labrig.effects import library
from labrig.experiment._told import _expected, _never_sure, _not_settled


def test_a_name_that_set_points_never_make_sure_is_said() -> None:
    """A body that leans is as good a frame that was moved: the line says how sure it can be, and what confirms it."""
    (line,) = _never_sure(["frame", "leak", "my_own"], library())
    assert line.startswith("frame is never called sure from set-points alone (57 % at most): ")
    assert line.endswith("to confirm it: register the measuring frame by three fixed markers right before")


def test_what_set_points_hardly_tell_apart_is_not_put_off_to_more_time() -> None:
    """A pair that ten times the minutes would not settle is said once, apart from one for which more time may do."""

    def pair(true: str, other: str, outlook: str) -> Expected:
        return {
            "true": true, "other": other, "apart": 0.0, "floors": 0.0, "settles": outlook == "yes", "outlook": outlook,
        }  # fmt: skip

    expected = [
        pair("tension", "stiffening", "no"),
        pair("stiffening", "tension", "no"),
        pair("tension", "regulator", "perhaps"),
        pair("tension", "contact", "yes"),
    ]
    assert _not_settled(expected, 10) == [
        "may not be enough to tell tension from regulator within 10 min: allow more, or repeat it",
        "set-points hardly tell tension from stiffening, not in 10 times as long: what is done by hand can",
    ]
    assert _not_settled(expected[-1:], 10) == []


def test_what_a_programme_promises_of_a_pair() -> None:
    """Yes where it settles it, no where one of ten times the minutes would not, else perhaps."""
    problem: Any = SimpleNamespace(
        rivals=[SimpleNamespace(title="a"), SimpleNamespace(title="b")],
        pairs=[(0, 1)] * 3,
        goals=[2.0] * 3,
        unit_size=1.0,
        log_bayes=lambda _: np.array([2.0, 0.2, 0.19]),
    )
    choice: Any = SimpleNamespace(together=SimpleNamespace(worth=1.0, numbers=10))
    assert [each.get("outlook") for each in _expected(problem, choice)] == ["yes", "perhaps", "no"]
