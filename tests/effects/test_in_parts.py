"""What is another in each session, and in each pose: one and the same where each session has a pose of its own."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from labrig.diagnosis._names import different
from labrig.effects import Context, library, rows_of
from labrig.effects._in_parts import poses_of
from labrig.model import base_context, build_base
from tests.naming import verdict_of

OWN, AGAIN = (0.0, 60.0, -45.0, 30.0), (0.0, 60.0, -45.0, 60.0)
"""Tilts of four sessions, deg: each has its own, or the last has that of the second again."""


def down(lab: Any, tilts: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """The vertical (n, 3) in the frame of the tilted rig, and the tilt (n,) of each capture, deg."""
    tilt_deg = np.array(tilts)[lab.session]
    tilt = np.deg2rad(tilt_deg)
    return np.stack([np.sin(tilt), np.zeros(len(tilt)), -np.cos(tilt)], axis=1), tilt_deg


def squeezed(lab: Any, vertical: np.ndarray, softer: float = 0.3) -> np.ndarray:
    """A body (n, rows, M, 3) is squeezed along the vertical and gets as much wider, in some places more."""
    arm = lab.predict(lab.u).reshape(*lab.u.shape[:2], -1, 3) - lab.rest_mm.mean(axis=0)
    low = np.einsum("nrmx,nx->nrm", arm, vertical)[..., None]
    gives = 0.02 * (1 + softer * np.sin(lab.rest_mm[:, :1] / 20))
    return gives * (arm / 2 - 1.5 * low * vertical[:, None, None])


def stretched(lab: Any, vertical: np.ndarray) -> np.ndarray:
    """The same alike everywhere."""
    return squeezed(lab, vertical, softer=0.0)


def measured(lab: Any, tilts: tuple[float, ...], law: Callable[[Any, np.ndarray], np.ndarray]) -> Any:
    """A campaign on which a weight does that."""
    vertical, tilt_deg = down(lab, tilts)
    values = lab.predict(lab.u) + lab.noise() + law(lab, vertical).reshape(*lab.u.shape[:2], -1)
    return lab.dataset(values, covariates={"tilt": ("deg", tilt_deg)})


def context_of(lab: Any, tilts: tuple[float, ...]) -> Context:
    """What the effects are given of that campaign."""
    model, rows = lab.model(), rows_of(measured(lab, tilts, squeezed))
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


def test_what_two_effects_have_counts_once(make_lab) -> None:
    """The directions that are looked at follow each space once, however many effects have it."""
    context = context_of(make_lab(captures=48, sessions=4), OWN)
    frame, gravity = (list(library()[effect].family(context)) for effect in ("frame", "gravity"))
    left = [space.key for space in different([*frame, *gravity])]
    assert left.count("in each part") == 1
    assert len(left) == len(frame) + len(gravity) - 1


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


@pytest.mark.parametrize(("law", "tilts"), [(stretched, AGAIN), (squeezed, OWN)])
def test_a_weight_is_not_taken_for_a_frame_that_was_moved_with_the_rig(
    make_lab, law: Callable[[Any, np.ndarray], np.ndarray], tilts: tuple[float, ...]
) -> None:
    """A weight that deforms the body by another law than those of labrig is named, and hardly a frame."""
    lab = make_lab(chambers=2, captures=48, sessions=4)
    found = verdict_of(measured(lab, tilts, law), lab.model())
    each = {c.effect: c.probability for c in found.considered}
    assert found.effects == ("gravity",)
    assert each["frame"] < 0.15
