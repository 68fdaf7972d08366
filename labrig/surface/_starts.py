"""Starts of a search from nowhere: rough poses of few points, quick enough for inverse kinematics to try many.

Scans are registered by Open3D (`_align`); what is here takes a tenth of its time and needs no process of its own.
"""

from typing import TYPE_CHECKING

import numpy as np

from labrig.arrays import Floats
from labrig.surface._pose import angle_deg, cube_rotations, spread_rotations, upright_frames
from labrig.surface._target import FEW, Target

if TYPE_CHECKING:
    from labrig.surface._coarse import Rough

COARSE = FEW // 2
"""Points on which starts are tried, against twice as many of the target."""
_SPREAD = 240
_KEPT = 8
_GOOD_SCORE = 0.04
_SAME_DEG = 12.0


def global_starts(
    points: Floats, normals: Floats, target: Target, oriented: bool = True
) -> list[tuple[Floats, Floats, float]]:
    """Motions (rotation, translation, score) that bring points (P, 3) near to a surface, from nowhere; best first.

    The principal axes of both, in every order and sign, are tried first; where none of them fits, rotations spread
    over all there are. `normals` (P, 3) tell inside from outside where both surfaces have them (`oriented`). The
    score is the mean distance as a share of the target's size, with normals that disagree counted in.
    """
    frame = upright_frames(target.mesh.vertices_mm) @ cube_rotations() @ upright_frames(points).T
    found = _improved(points, normals, target, frame, oriented)
    if found[0][2] > _GOOD_SCORE:
        found += _improved(points, normals, target, spread_rotations(_SPREAD), oriented)
        found.sort(key=lambda motion: motion[2])
    different: list[tuple[Floats, Floats, float]] = []
    for motion in found:
        if all(angle_deg(motion[0] @ other[0].T) > _SAME_DEG for other in different):
            different.append(motion)
    return different


def _improved(
    points: Floats, normals: Floats, target: Target, rotations: Floats, oriented: bool
) -> list[tuple[Floats, Floats, float]]:
    shifts = target.middle_mm - rotations @ points.mean(axis=0)
    R, t, cost = _rough(points, normals, target, oriented).try_starts(rotations, shifts, _KEPT)
    return [(R[k], t[k], float(cost[k])) for k in range(len(cost))]


def start_score(points: Floats, normals: Floats, target: Target, oriented: bool = True) -> float:
    """The score, as of `global_starts`, of the better half of the points as they lie."""
    rough = _rough(points, normals, target, oriented)
    return float(rough.score(np.eye(3)[None], np.zeros((1, 3)), 0.5)[0])


def _rough(points: Floats, normals: Floats, target: Target, oriented: bool) -> "Rough":
    from labrig.surface._coarse import Rough

    return Rough(points, normals, *target.few, target.size_mm, oriented)
