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
_FACETS = 1e-3
"""The normals of a mesh are not exact to more than this, rad: its triangles are flat."""
_SURE = 3.0
"""Standard deviations by which a change of distances must differ from none."""


@dataclass(frozen=True)
class Registration:
    """How `source` was brought onto `target`: x -> rotation @ x + translation.

    `rms_mm`: point-to-plane distance of the pairs that count; `share`: how many of the source's points those are;
    `sd_mm`: standard deviation of the position that noise of `rms_mm` leaves, at the worst point of the source;
    infinite where the source may slide along the target, as on a plane, a cylinder or a round dome: how far it is off
    is not known then. `turned`: the source's normals point against the target's, it is inside out (see `Mesh.turned`).
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
    used = found.weight > 0
    weight = found.weight[used]
    centred = found.moved_mm - found.moved_mm.mean(axis=0)
    rms = float(np.sqrt((weight * found.height_mm[used] ** 2).sum() / weight.sum()))
    normal = found.normal[used]
    A = np.concatenate([np.cross(centred[used], normal), normal], axis=1)
    slides = _slides(centred[used], found.height_mm[used], normal, found.own_normal[used], weight, rms)
    return Registration(
        found.motion[:3, :3],
        found.motion[:3, 3],
        rms,
        float(used.mean()),
        found.rounds,
        np.inf if slides else _worst_sd(centred, (A * weight[:, None]).T @ A, rms),
        found.turned,
    )


def _slides(
    centred: Floats, height: Floats, normal: Floats, own_normal: Floats, weight: Floats, rms: float
) -> bool:
    """Whether a small motion leaves pairs (n, 3) on each other, as far as the normals of both surfaces can tell.

    A motion whose mean square change of the pairs' distances is nothing is slippage (Gelfand, Guibas, Shape
    segmentation using local slippage analysis, 2004). The square is taken as a product, one change by the target's
    normals and one by the source's, so that noise in the normals of either is not taken for shape. It is nothing if it
    is less than noise of the pairs would hide on a way as long as the surface, than facets may show, or than chance.
    """
    size = float(np.sqrt((weight * (centred**2).sum(axis=1)).sum() / weight.sum()))
    feet = centred - height[:, None] * normal
    facing = np.sign((own_normal * normal).sum(axis=1))[:, None]
    by_target = np.concatenate([np.cross(feet, normal) / size, normal], axis=1)
    by_source = np.concatenate([np.cross(centred, own_normal) / size, own_normal], axis=1) * facing
    share = weight[:, None] / weight.sum()
    product = (share * by_target).T @ by_source
    _, motions = np.linalg.eigh(0.5 * (product + product.T))
    each = (by_target @ motions) * (by_source @ motions)
    found = (share * each).sum(axis=0)
    chance = np.sqrt((share**2 * (each - found) ** 2).sum(axis=0))
    return bool((found < np.maximum(max(_FACETS, rms / size) ** 2, _SURE * chance)).any())


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
