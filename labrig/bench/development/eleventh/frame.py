"""Frames of the eleventh portion: a direct linear transform from poor points, and a reference that rides along."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, compliance, direction, moved, positions, span

_MARKERS = frozenset({"markers"})


class DirectLinearTransform(Law):
    """Direct linear transform: space is reconstructed from control points, and comes out as a projection of itself.

    Y. I. Abdel-Aziz, H. M. Karara, Direct linear transformation from comparator coordinates into object space
    coordinates in close-range photogrammetry, ASP Symposium on Close-Range Photogrammetry, 1971. Control points that
    are wrong, or on one side only, leave all straight lines straight, but shifted, sheared, stretched and converging.
    """

    effect = "frame"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._centre_mm, radius_mm = body_mm(self.rig)
        far_mm = random.uniform(0.25, 0.5) * span(self.rig) * np.sqrt(3.0)
        shift, affine, converges = random.dirichlet([1.0, 3.0, 3.0])
        self._shift_mm = far_mm * shift * direction(random)
        self._affine = random.normal(0, 1, (3, 3)) / np.sqrt(3.0) * far_mm * affine / radius_mm
        poses = positions(self.rig, self.rig.settled(setting.path.kpa[setting.path.row]))
        reach_mm = float(np.linalg.norm(poses - self._centre_mm, axis=2).max())
        self._converges = min(2 * far_mm * converges / radius_mm**2, 0.15 / reach_mm) * direction(random)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points_mm = positions(self.rig, values)
        arm = points_mm - self._centre_mm
        above = arm @ (strength * self._affine).T + strength * self._shift_mm
        below = np.maximum(1 + strength * arm @ self._converges, 0.25)[..., None]
        return moved(self.rig, values, points_mm + (arm + above) / below - arm)


class ReferenceRides(Law):
    """Reference rides along: of three markers that define the frame one sits where the body still moves a little.

    H. D. Black, A passive system for determining the attitude of a satellite, AIAA Journal 2, 1964, on a frame from
    three points: origin, first axis, plane. Whatever moves one of them shifts and turns all that is seen.
    """

    effect = "frame"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        centre, radius_mm = body_mm(rig)
        corners = np.linalg.qr(random.normal(size=(3, 3)))[0][:2]  # a right angle, anywhere
        first = centre + random.uniform(0.5, 1.2) * radius_mm * direction(random)
        sides_mm = random.uniform(0.9, 1.8, (2, 1)) * radius_mm
        self._three_mm = np.concatenate([first[None], first + sides_mm * corners])
        self._which = int(random.choice(3, p=[0.2, 0.4, 0.4]))
        yields = compliance(rig)
        able = np.flatnonzero(yields >= np.median(yields))
        self._beside = int(random.choice(able))  # the marker whose motion it shares
        self._share = random.uniform(0.1, 0.25)

    @staticmethod
    def _axes(three_mm: Floats) -> Floats:
        """The axes (T, 3, 3), as rows, of frames from three points (T, 3, 3)."""
        first = three_mm[:, 1] - three_mm[:, 0]
        first = first / np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-9)
        last = np.cross(first, three_mm[:, 2] - three_mm[:, 0])
        last = last / np.maximum(np.linalg.norm(last, axis=1, keepdims=True), 1e-9)
        return np.stack([first, np.cross(last, first), last], axis=1)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        assert self.rig.rest_mm is not None
        points_mm = positions(self.rig, values)
        three_mm = np.repeat(self._three_mm[None], len(values), axis=0)
        gone_mm = points_mm[:, self._beside] - self.rig.rest_mm[self._beside]
        three_mm[:, self._which] += strength * self._share * gone_mm
        told = (points_mm - three_mm[:, :1]) @ np.swapaxes(self._axes(three_mm), 1, 2)
        seen_mm = self._three_mm[0] + told @ self._axes(self._three_mm[None])[0]
        return moved(self.rig, values, seen_mm)
