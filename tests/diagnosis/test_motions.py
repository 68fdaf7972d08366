"""A base that is wrong in form in few numbers: what else is there keeps its name, and no name goes with the base."""

from typing import Any

import numpy as np
import pytest

from tests.naming import verdict_of


def gone(lab: Any) -> np.ndarray:
    """How far the base says that each marker has gone, (n, T, M, 3)."""
    return (lab.predict(lab.u) - lab.rest).reshape(*lab.hold_s.shape, -1, 3)


def another_way(lab: Any) -> np.ndarray:
    """All markers go 8 degrees beside the way of the base, turned exactly (Rodrigues), each by as much as it goes."""
    axis, turn = np.array([0.6, 0.0, 0.8]), np.deg2rad(8.0)
    way = gone(lab)
    along = (way @ axis)[..., None] * axis
    return along + np.cos(turn) * (way - along) + np.sin(turn) * np.cross(axis, way) - way


def as_the_next_one(lab: Any) -> np.ndarray:
    """Each marker goes a fifth of the way towards what its neighbour in the row does, as if it sat nearer to it."""
    way = gone(lab)
    return 0.2 * (np.roll(way, -1, axis=2) - way) * (np.arange(lab.markers) < lab.markers - 1)[:, None]


def other_walls(lab: Any) -> np.ndarray:
    """Each chamber's wall gives way by an arctangent of its pressure, and not as the base has it."""
    x = lab.u / 60.0
    curve = np.arctan(3 * x) / np.arctan(3.0) - x
    return 0.15 * np.einsum("ntc,kc->ntk", curve, lab.reach).reshape(*lab.hold_s.shape, -1, 3)


@pytest.mark.parametrize("wrong", [another_way, as_the_next_one, other_walls])
def test_what_else_is_there_keeps_its_name(make_lab, wrong) -> None:
    """Beside a base that is wrong in form a loop (Bouc-Wen) is named, and nothing else."""
    lab = make_lab(captures=80, markers=12)
    values = lab.predict(lab.looped(4.0)) + wrong(lab).reshape(*lab.hold_s.shape, -1)
    found = verdict_of(lab.dataset(values + lab.noise()), lab.model())
    assert (found.verdict, found.effects) == ("identified", ("hysteresis",))
    if wrong is another_way:
        assert found.carried_by == "how the base itself moves"
