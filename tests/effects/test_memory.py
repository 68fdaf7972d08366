"""What a chamber remembers of where it turned, told from a list of set-points by hand."""

import numpy as np
import pytest

from labrig.effects._memory import turns
from tests.effects.test_family import context_of

HIGH_KPA = 60.0


def told(make_lab, shares: list[float]) -> tuple[list[float], list[float], list[float]]:
    """Last turn, the one before, and the way, of a rig with one chamber that goes to these shares of its range."""
    lab = make_lab(captures=len(shares), chambers=1, repeats=False)
    lab.commanded[:] = HIGH_KPA * np.array(shares)[:, None]
    last, before, way = (values[:, 0].tolist() for values in turns(context_of(lab)))
    return last, before, way


def test_each_turn_is_remembered_with_the_one_before(make_lab) -> None:
    """Up from vented, down and up again: the turns are the ends of the strokes, not the set-points on the way."""
    last, before, way = told(make_lab, [0.2, 0.6, 0.9, 0.5, 0.3, 0.7, 0.7])
    assert last == pytest.approx([0, 0, 0, 0.9, 0.9, 0.3, 0.3])
    assert before == pytest.approx([0, 0, 0, 0, 0, 0.9, 0.9])
    assert way == [1, 1, 1, -1, -1, 1, 1]


def test_a_tremble_is_no_turn(make_lab) -> None:
    """Ways back of less than a hundredth of the range leave the turns alone; in small steps a long way back is one."""
    last, _, way = told(make_lab, [0.5, 0.496, 0.503, 0.499, 0.6, 0.594, 0.588])
    assert last == pytest.approx([0, 0, 0, 0, 0, 0, 0.6])
    assert way == [1, 1, 1, 1, 1, 1, -1]
