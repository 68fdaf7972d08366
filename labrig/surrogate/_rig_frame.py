"""The motion from the simulator's frame to the rig's, as far as markers fix it."""

import numpy as np

from labrig.arrays import Floats
from labrig.surrogate._captures import Frames
from labrig.surrogate._field_settings import Settings
from labrig.surrogate._forward import ForwardModel
from labrig.surrogate._same_markers import check_markers

TURNED_RAD, _SHIFTED_MM = 0.05, 15.0
"""The rig's frame is taken for another one than the simulator's beyond these."""
_SURE = 3.0
"""A turn that markers can hardly fix counts where it explains so many standard deviations of what is left over."""
_OF_A_MOTION = 6
"""Numbers that describe a rigid motion; so many coordinates fit whatever they are."""
_NEAR_OPPOSITE = 1e-6
"""One more than the cosine between two directions, below which no axis turns one into the other better than another."""

ONE = "one marker does not say how the rig is turned: it is taken to lie as simulated; capture another marker to know"
SPOT = (
    "the markers lie too near together to say how the rig is turned: it is taken to lie as simulated; capture some "
    "further apart, not all on one line, to know"
)
LINE = (
    "the markers lie too near to one line to say how the rig is turned about it: that is taken to be as simulated; "
    "capture a marker beside the line to know"
)


def frame_of_markers(forward: ForwardModel, frames: Frames | None) -> tuple[Floats, Floats, tuple[str, ...]]:
    """The rotation (3, 3) and translation (3,), mm, from the simulator's frame to the rig's, and what is not known.

    None unless the markers say that the frames differ, and only what they fix: all of the rotation (Kabsch 1976), or
    the least one that brings their line to where it is, or none. The rest stays as it was simulated, and is said.
    Raises `LabrigError` for markers that cannot be the model's.
    """
    still = np.eye(3), np.zeros(3)
    if frames is None:
        return *still, ()
    seen = frames.captured
    predicted = forward.points(frames.pressure_kpa, forward.markers(frames.marker_names))
    check_markers(frames.marker_names, predicted, frames.position_mm, seen)
    there, here = frames.position_mm[seen], predicted[seen]
    rotation, notes = np.eye(3), (ONE,)
    if seen.any(axis=0).sum() > 1:
        different = int(frames.merged().captured.sum())
        rotation, notes = _fixed(here - here.mean(axis=0), there - there.mean(axis=0), different)
    shift = np.linalg.norm(there.mean(axis=0) - here.mean(axis=0))
    if _angle(rotation) < TURNED_RAD and shift < _SHIFTED_MM:
        return *still, notes
    return rotation, there.mean(axis=0) - rotation @ here.mean(axis=0), notes


def _fixed(a: Floats, b: Floats, different: int) -> tuple[Floats, tuple[str, ...]]:
    """As much of the rotation from points `a` to `b` (n, 3), around their means, as they fix, and what they leave open.

    `different` of them are no repeats. What the fit leaves over is what a turn could be mistaken by; what the motion
    itself has taken away of it is as large as is expected of the field before anything is seen (`Settings.usual`).
    """
    left, _, right = np.linalg.svd(b.T @ a)
    full = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    count = 3 * len(a)
    hidden = _OF_A_MOTION * Settings.usual().variance / (3 * different)
    sd_mm = float(np.sqrt(((b - a @ full.T) ** 2).sum() / count + hidden))
    square, axes = np.linalg.eigh(a.T @ a / len(a))  # the last axis is that of the line
    along_mm, beside_mm = np.sqrt(square[2]), np.sqrt(max(square[0] + square[1], 0.0))
    line = _least_turn(axes[:, 2], full @ axes[:, 2], axes[:, 1])

    def counts(turn: Floats, arm_mm: float) -> bool:
        known = sd_mm < TURNED_RAD * arm_mm
        return bool(known or 2.0 * np.sin(0.5 * _angle(turn)) * arm_mm > _SURE * sd_mm)

    if counts(full @ line.T, beside_mm):
        return full, ()
    return (line, (LINE,)) if counts(line, along_mm) else (np.eye(3), (SPOT,))


def _least_turn(start: Floats, end: Floats, aside: Floats) -> Floats:
    """The rotation (3, 3) by the least angle from one unit vector (3,) to another.

    Opposite ones: about `aside`, a unit vector at right angles to the first.
    """
    cosine = float(start @ end)
    if 1.0 + cosine < _NEAR_OPPOSITE:
        return 2.0 * np.outer(aside, aside) - np.eye(3)
    x, y, z = np.cross(start, end)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + K + K @ K / (1.0 + cosine)


def _angle(rotation: Floats) -> float:
    """By how much a rotation turns, rad."""
    return float(np.arccos(np.clip((np.trace(rotation) - 1.0) / 2.0, -1.0, 1.0)))
