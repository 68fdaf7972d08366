"""Rigid registration of scans, by Open3D (`_align`), and how sure it is."""

from dataclasses import dataclass

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.surface._aside import call
from labrig.surface._mesh import Mesh
from labrig.surface._target import Target

_SIZES = 20.0
"""Two surfaces whose sizes differ by more than this factor are not in the same unit."""


@dataclass(frozen=True)
class Registration:
    """How `source` was brought onto `target`: x -> rotation @ x + translation.

    `rms_mm`: point-to-plane distance of the pairs that count; `share`: how many of the source's points those are;
    `sd_mm`: standard deviation of the position that noise of `rms_mm` leaves, at the worst point of the source;
    `turned`: the source's normals point against the target's, it is inside out (see `Mesh.turned`).
    """

    rotation: Floats
    translation_mm: Floats
    rms_mm: float
    share: float
    iterations: int
    sd_mm: float
    turned: bool = False

    def apply(self, points_mm: Floats) -> Floats:
        """Points (..., 3) of the source in the target's frame."""
        return points_mm @ self.rotation.T + self.translation_mm


def register(source: Mesh, target: Mesh | Target, start: tuple[Floats, Floats] | None = None) -> Registration:
    """Bring `source` onto `target`: robust point-to-plane ICP after a global search, or after `start` (R, t).

    Pairs at the target's border and pairs that are far off for their number (Tukey's biweight) count less or not at
    all, so both may be partial, have holes, and hold points that belong to something else. The same surfaces give the
    same motion. Raises `LabrigError` when the two do not fit each other, and without the extra `scan`.
    """
    goal = target if isinstance(target, Target) else Target(target)
    size_mm = Target(source).size_mm
    if not 1.0 / _SIZES <= size_mm / max(goal.size_mm, 1e-12) <= _SIZES:
        raise LabrigError(
            f"the scan is {size_mm:.3g} mm across, the surface {goal.size_mm:.3g} mm: is the scan's unit right?"
        )
    begin = None
    if start is not None:
        begin = np.eye(4)
        begin[:3, :3], begin[:3, 3] = start
    for mesh in (source, goal.mesh):
        _ = mesh.normals, mesh.border, mesh.spacing_mm  # known there, too, once they are known here
    found = call("place", source, goal.mesh, begin)
    weight, centred = found.weight, found.moved_mm - found.moved_mm.mean(axis=0)
    rms = float(np.sqrt((weight * found.height_mm**2).sum() / weight.sum()))
    A = np.concatenate([np.cross(centred, found.normal), found.normal], axis=1)
    return Registration(
        found.motion[:3, :3],
        found.motion[:3, 3],
        rms,
        float((weight > 0).mean()),
        found.rounds,
        _worst_sd(centred, (A * weight[:, None]).T @ A, rms),
        found.turned,
    )


def _worst_sd(centred: Floats, H: Floats, rms: float) -> float:
    """The largest standard deviation of a point's position, mm, if the pairs' errors are independent."""
    covariance = np.linalg.pinv(H) * rms**2
    lever = np.zeros((len(centred), 3, 6))
    lever[:, 0, 1], lever[:, 0, 2] = centred[:, 2], -centred[:, 1]
    lever[:, 1, 0], lever[:, 1, 2] = -centred[:, 2], centred[:, 0]
    lever[:, 2, 0], lever[:, 2, 1] = centred[:, 1], -centred[:, 0]
    lever[:, :, 3:] = np.eye(3)
    variance = np.einsum("pij,jk,pik->p", lever, covariance, lever)
    return float(np.sqrt(variance.max()))
