"""A frame that is turned by much: solved exactly, and what the model says of motions is turned with it."""

import numpy as np
import pytest
import xarray as xr
from scipy.spatial.transform import Rotation

from labrig.diagnosis import compare, diagnose, improve
from labrig.effects import rows_of
from tests.naming import verdict_of

AXIS = np.array([0.3, -0.5, 0.81])
PLACE_MM = np.array([240.0, -60.0, 900.0])


def seen_from(data: xr.Dataset, angle_deg: float) -> xr.Dataset:
    """The same campaign as a camera sees it whose frame lies elsewhere and is turned."""
    turn = Rotation.from_rotvec(np.deg2rad(angle_deg) * AXIS / np.linalg.norm(AXIS))
    out = data.copy(deep=True)
    place = out["position_mm"].values
    out["position_mm"].values[...] = turn.apply(place.reshape(-1, 3)).reshape(place.shape) + PLACE_MM
    return out


def test_a_frame_turned_by_much_is_solved_exactly(make_lab) -> None:
    """Frame is the only name, the error falls to the floor, and on another programme of the same rig too."""
    lab, other = make_lab(chambers=2, captures=40), make_lab(chambers=2, captures=30, seed=1)
    found = diagnose(seen_from(lab.dataset(lab.predict(lab.u) + lab.noise()), 178.0), lab.model())
    assert [*found.summary["effects"], *found.summary["rivals"]] == ["frame"]
    assert found.summary["error"]["model"] < 1.3 * found.summary["error"]["floor"]
    assert found.improved is not None
    later = seen_from(other.dataset(other.predict(other.u) + other.noise()), 178.0)
    left = compare(later, found.improved).summary["error"]
    assert left["model"] < 1.3 * left["floor"]


@pytest.mark.parametrize("seed", [0, 13])
def test_what_is_small_beside_the_turn_is_named_after_it(make_lab, seed: int) -> None:
    """A leak behind a turn of many floors waits, is announced, and is named once the frame is in the model, which turns
    it exactly: what a small rotation would leave, little beside the turn, is more than the leak.
    """
    lab = make_lab(chambers=2, captures=40, long_s=(3.0, 4.0, 6.0, 10.0, 20.0, 40.0), seed=seed)
    left = np.maximum(np.sqrt(lab.u) - 0.04 * lab.hold_s[:, :, None], 0.0) ** 2
    turned = seen_from(lab.dataset(lab.predict(left) + lab.noise()), 25.0)
    first = diagnose(turned, lab.model())
    assert [*first.summary["effects"], *first.summary["rivals"]] == ["frame"]
    assert any("beside frame, nothing that is smaller than" in line for line in first.summary["warnings"])
    assert first.improved is not None
    assert [effect.form for effect in first.improved.file.effects] == ["turned"]
    then = verdict_of(turned, first.improved)
    assert (*then.effects, *then.rivals) == ("leak",)


def test_a_model_with_a_frame_says_what_the_base_moves_and_not_where_it_is(make_lab) -> None:
    """A frame in the model leaves displacements as they were, and turns them and their slopes."""
    lab = make_lab(chambers=2, captures=40)
    plain, measured = lab.model(), lab.dataset(lab.predict(lab.u) + lab.noise())
    turned = seen_from(measured, 40.0)
    better = improve(turned, plain, ["frame"]).improved
    assert better is not None
    before, after = plain.context(rows_of(measured)), better.context(rows_of(turned))
    turn = Rotation.from_rotvec(np.deg2rad(40.0) * AXIS / np.linalg.norm(AXIS))
    moved = turn.apply(before.displacement.reshape(-1, 3)).reshape(before.displacement.shape)
    assert np.abs(after.displacement - moved).max() < 0.01 * np.abs(moved).max()
    slope = np.moveaxis(before.jacobian, 1, 2)
    slope = np.moveaxis(turn.apply(slope.reshape(-1, 3)).reshape(slope.shape), 2, 1)
    assert np.abs(after.jacobian - slope).max() < 0.01 * np.abs(slope).max()


def test_a_saved_small_rotation_acts_wherever_it_is_asked(make_lab) -> None:
    """A model that has a frame moved by little is used as it is on a run that is seen from elsewhere altogether."""
    lab = make_lab(chambers=2, captures=40)
    measured = lab.dataset(lab.predict(lab.u) + 1.0 + lab.noise())
    better = improve(measured, lab.model(), ["frame"]).improved
    assert better is not None
    assert [effect.form for effect in better.file.effects] == ["rigid"]
    assert compare(seen_from(measured, 40.0), better).summary["error"]["model"] > 10
