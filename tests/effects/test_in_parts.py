"""What is another in each session, and in each pose: one and the same where each session has a pose of its own."""

from typing import Any

import numpy as np
import pytest

from labrig.effects import Context, library
from labrig.effects._in_parts import poses_of
from labrig.effects._rows import rows_of
from labrig.model import base_context, build_base
from tests.naming import calls_of

OWN, AGAIN = (0.0, 60.0, -45.0, 30.0), (0.0, 60.0, -45.0, 60.0)
"""Tilts of four sessions, deg: each has its own, or the last has that of the second again."""


def squeezed(lab: Any, tilts: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Values of a body that is squeezed along the vertical and gets as much wider, and the tilt of each capture."""
    tilt_deg = np.array(tilts)[lab.session]
    down = np.stack(
        [np.sin(np.deg2rad(tilt_deg)), np.zeros(len(tilt_deg)), -np.cos(np.deg2rad(tilt_deg))], axis=1
    )
    arm = lab.rest_mm - lab.rest_mm.mean(axis=0)
    low = np.einsum("mx,nx->nm", arm, down)
    change = 0.02 * (arm[None] / 2 - 1.5 * low[..., None] * down[:, None])
    return lab.predict(lab.u) + lab.noise() + change.reshape(len(tilt_deg), 1, -1), tilt_deg


def context_of(lab: Any, tilts: tuple[float, ...]) -> Context:
    """What the effects are given of that campaign."""
    values, tilt_deg = squeezed(lab, tilts)
    model = lab.model()
    rows = rows_of(lab.dataset(values, covariates={"tilt": ("deg", tilt_deg)}))
    return base_context(build_base(model.file, model.folder, rows), rows)


def in_each_part(context: Context, effect: str) -> dict[str, np.ndarray]:
    """The functions of an effect's space of what is another in each part."""
    (space,) = (s for s in library()[effect].family(context) if s.key == "in each part")
    return {f.name: f.values for f in space.features}


def test_a_pose_for_each_session_is_one_space_of_both(make_lab) -> None:
    """Where each session has a pose of its own, a frame that was moved and a weight have the same functions."""
    context = context_of(make_lab(captures=48, sessions=4), OWN)
    frame, gravity = (in_each_part(context, effect) for effect in ("frame", "gravity"))
    assert list(frame) == list(gravity)
    for name, values in frame.items():
        np.testing.assert_array_equal(values, gravity[name])


def test_a_pose_that_comes_again_is_one_part(make_lab) -> None:
    """Sessions with the same pose are one part for a weight, and two for a frame."""
    context = context_of(make_lab(captures=48, sessions=4), AGAIN)
    frame, gravity = (in_each_part(context, effect) for effect in ("frame", "gravity"))
    assert len(frame) == 4 * 12
    assert len(gravity) == 3 * 12


@pytest.mark.parametrize(
    ("pulls", "parts"),
    [
        ([], None),
        ([np.zeros(30)], None),
        ([np.repeat([0.0, 1.0, 0.0], 10)], 2),
        ([np.repeat([0.0, 1.0, 0.0], 10), np.repeat([0.0, 0.0, 2.0], 10)], 3),
        ([np.arange(30.0)], None),
    ],
)
def test_poses(pulls: list[np.ndarray], parts: int | None) -> None:
    """Rows with the same weights and directions have one pose; one for all says nothing, one for each too much."""
    pose = poses_of(pulls)
    assert (None if pose is None else len(set(pose.tolist()))) == parts


def test_a_weight_is_not_taken_for_a_frame_that_was_moved_with_the_rig(make_lab) -> None:
    """A sag by a law that no family has, where each session has its own tilt: frame and gravity are both possible."""
    lab = make_lab(captures=48, sessions=4)
    values, tilt_deg = squeezed(lab, OWN)
    calls = calls_of(lab.dataset(values, covariates={"tilt": ("deg", tilt_deg)}), lab.model())
    assert {n for n, call in calls.items() if call != "not it"} >= {"gravity"}
    assert calls["frame"] != "sure"


def test_a_pose_that_comes_again_settles_it(make_lab) -> None:
    """The same sag, where one tilt comes again in another session: it is gravity, surely, and no frame."""
    lab = make_lab(captures=48, sessions=4)
    values, tilt_deg = squeezed(lab, AGAIN)
    calls = calls_of(lab.dataset(values, covariates={"tilt": ("deg", tilt_deg)}), lab.model())
    assert (calls["gravity"], calls["frame"]) == ("sure", "not it")
