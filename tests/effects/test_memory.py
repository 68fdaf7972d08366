"""What a chamber remembers of where it turned, told from a list of set-points by hand."""

from itertools import pairwise

import numpy as np
import pytest

from labrig.effects import rows_of
from labrig.effects._memory import memory, trail, turns
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


def test_a_chamber_that_pulls_too_has_turned_as_far_from_its_turn(make_lab) -> None:
    """Shares are of the range from its lower limit on: with vacuum, zero is half way."""
    lab = make_lab(captures=5, chambers=1, repeats=False)
    lab.commanded[:] = np.array([30.0, -30.0, -60.0, 0.0, 60.0])[:, None]
    data = lab.dataset(lab.predict(lab.u))
    data["chamber_min"][:] = -60.0
    context = lab.model().context(rows_of(data))
    last, before, _ = (values[:, 0].tolist() for values in turns(context))
    assert last == pytest.approx([0.5, 0.75, 0.75, 0, 0])
    assert before == pytest.approx([0.5, 0.5, 0.5, 0.75, 0.75])
    way = next(f for f in memory(context) if f.name == "way 0.1 load0").values[:, 0]
    gone = np.array([0.25, 0.5, 0.75, 0.5, 1.0])[context.rows.event]
    assert np.abs(way) == pytest.approx(1 - np.exp(-gone / 0.1))


def test_a_session_begins_vented_or_where_it_is(make_lab) -> None:
    """Between sessions chambers are vented: the turns before are forgotten. At rest they are where they are."""
    lab = make_lab(captures=6, chambers=1, repeats=False)
    lab.commanded[:] = HIGH_KPA * np.array([0.8, 0.4, 0.6, 0.5, 0.7, 0.2])[:, None]
    data = lab.dataset(lab.predict(lab.u))
    data["session"], data["event_session"] = ((dim, np.repeat([0, 1], 3)) for dim in ("capture", "event"))
    for between, begins in (("vented", 0.0), ("rest", 0.5)):
        data.attrs["between_sessions"] = between
        last = turns(lab.model().context(rows_of(data)))[0][:, 0]
        assert last[3:] == pytest.approx([begins, begins, 0.7])


@pytest.mark.parametrize("power", [1, 2])
@pytest.mark.parametrize("loading", [False, True])
def test_what_trails_follows_its_law_step_by_step(make_lab, power: int, loading: bool) -> None:
    """Its own differential equation in a thousand small steps from set-point to set-point says the same."""
    shares = [0.2, 0.9, 0.5, 0.6, 0.0, 0.7, 0.7]
    lab = make_lab(captures=len(shares), chambers=1, repeats=False)
    lab.commanded[:] = HIGH_KPA * np.array(shares)[:, None]
    context = context_of(lab)
    x, z, expected = 0.0, 0.0, []
    for share in shares:
        way = np.linspace(x, share, 4001)
        for a, b in pairwise(way):
            if not loading or b > a:
                z += (((a + b) / 2) ** power - z) * abs(b - a) / 0.35
        x = share
        expected.append(z - x**power)
    first = np.unique(context.rows.event, return_index=True)[1]
    assert trail(context, 0.35, power, loading)[first, 0] == pytest.approx(expected, abs=1e-3)


def test_what_trails_begins_where_a_record_begins(make_lab) -> None:
    """A record that began at rest has nothing behind it at its first sample."""
    lab = make_lab(captures=4, chambers=1, repeats=False)
    lab.commanded[:] = HIGH_KPA * np.array([0.8, 0.8, 0.8, 0.4])[:, None]
    data = lab.dataset(lab.predict(lab.u))
    data.attrs["between_sessions"] = "rest"
    context = lab.model().context(rows_of(data))
    behind = trail(context, 1.0)[np.unique(context.rows.event, return_index=True)[1], 0]
    assert behind[:3] == pytest.approx([0, 0, 0])
    assert behind[3] > 0.1
