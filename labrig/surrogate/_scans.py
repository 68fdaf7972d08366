"""Scans without correspondences: the nearest points of a surface that moves, and how far they can be believed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.surface import Mesh, Registration, distances, register
from labrig.surrogate._captures import Shot

_FAR_SHARE = 4.0
"""Matches further off than this many times the scan's typical distance are not believed."""
_LEAST_REACH_MM = 2.0
_STEEP = 0.5
"""Cosine between the scan's normal and the way to it, below which a match is to something else."""
_REGISTERED, _GOOD_SHARE = 5, 0.8
_TURNED, _SHIFTED_MM = 0.07, 15.0
"""Scans are taken to lie in another frame beyond these (of the rotation matrix; 3 degrees)."""
_AGREED_MM = 0.5
"""A scan that disagrees with the others by this much is worth half."""
SLIDES = (
    "the scans can slide or turn on the surface and fit as well, so how they lie along it is not known: scan a shape "
    "that holds them too, such as one with several chambers filled"
)


@dataclass(frozen=True)
class Matched:
    """For S scans and Q places: `foot_mm`, `normal` (S, Q, 3), and whether there is one, `found` (S, Q)."""

    foot_mm: Floats
    normal: Floats
    found: NDArray[np.bool_]


def match(shots: list[Shot], points_mm: Floats) -> Matched:
    """The nearest points of each scan to points (S, Q, 3), without those at its border or too far off."""
    feet, normals, found = [], [], []
    for shot, points in zip(shots, points_mm, strict=True):
        near = distances(points, shot.mesh)
        off = points - near.feet_mm
        length = np.linalg.norm(off, axis=1)
        normal = _normals(shot, near.feet_mm)
        reach = max(_FAR_SHARE * float(np.median(np.abs(near.signed_mm))), _LEAST_REACH_MM)
        square = length < 0.3  # on the surface, where the way to it has no direction
        square |= np.abs((off * normal).sum(axis=1)) > _STEEP * length
        feet.append(near.feet_mm)
        normals.append(normal)
        found.append(~near.beyond & (length < reach) & square)
    return Matched(np.array(feet), np.array(normals), np.array(found))


def _normals(shot: Shot, feet: Floats) -> Floats:
    """The scan's normals at points on it: the mean of the nearest vertices', which noise moves less."""
    from labrig.surface import Nearest

    near = Nearest(shot.mesh.vertices_mm).several(feet, 8)
    normal = shot.mesh.normals[near].mean(axis=1)
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)


def confidence_map(matched: Matched, distance: Floats) -> Floats:
    """How far scans stand behind each place, (n, n), u first: the share of scans that show it, times their agreement.

    `distance` (J, Q): by how much each scan's place is missed by what the others say; NaN where it is not known.
    """
    seen = matched.found.mean(axis=0)
    count = np.maximum(np.isfinite(distance).sum(axis=0), 1)
    square = np.nansum(distance**2, axis=0) / count
    agreement = 1.0 / (1.0 + square / _AGREED_MM**2)
    side = round(len(seen) ** 0.5)
    return (seen * agreement).reshape(side, side).T


def frame_of(shots: list[Shot], predicted: list[Mesh]) -> tuple[Floats, Floats, tuple[str, ...]]:
    """The motion that takes the scans to the predicted surfaces, one for all: none if they lie there already.

    From the first scans, each registered as it lies, and if that does not fit well, from anywhere; of these from those
    that cannot slide on their surface, if there are some. And what is not known.
    """
    found = [_registered(shot, mesh) for shot, mesh in list(zip(shots, predicted, strict=True))[:_REGISTERED]]
    held = [r for r in found if np.isfinite(r.sd_mm)]
    notes = () if held else (SLIDES,)
    found = held or found
    best = min(found, key=lambda r: r.rms_mm)
    left, _, right = np.linalg.svd(np.mean([r.rotation for r in found], axis=0))
    rotation = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    if np.linalg.norm(rotation - best.rotation) > _TURNED:  # some went elsewhere
        rotation, translation = best.rotation, best.translation_mm
    else:
        translation = np.median([r.translation_mm for r in found], axis=0)
    middle = shots[0].mesh.vertices_mm.mean(axis=0)
    shift = np.linalg.norm(rotation @ middle + translation - middle)
    if np.linalg.norm(rotation - np.eye(3)) < _TURNED and shift < _SHIFTED_MM:
        return np.eye(3), np.zeros(3), notes
    return rotation, translation, notes


def _registered(shot: Shot, predicted: Mesh) -> Registration:
    try:
        here = register(shot.mesh, predicted, start=(np.eye(3), np.zeros(3)))
    except LabrigError:
        return register(shot.mesh, predicted)
    if here.share > _GOOD_SHARE:
        return here
    anywhere = register(shot.mesh, predicted)
    return anywhere if anywhere.share > here.share else here
