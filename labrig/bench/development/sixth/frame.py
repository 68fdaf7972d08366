"""Frames of the sixth portion: a fisheye read as a pinhole, a dome of poor views, an encoder off its axis."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, span


class FisheyeAsPinhole(Law):
    """Fisheye: its image goes with the angle, and is read as if with the tangent: what is far aside seems less far.

    J. Kannala, S. S. Brandt, A generic camera model and calibration method for conventional, wide-angle, and fish-eye
    lenses, IEEE Trans. Pattern Analysis and Machine Intelligence 28, 2006. The axis is beside the body.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        self._looks = direction(random)
        aside = np.cross(self._looks, direction(random))
        aside = aside / np.linalg.norm(aside) * radius * random.uniform(0.8, 2.0)
        self._far_mm = radius * random.uniform(1.5, 4.0)
        self._camera_mm = centre - self._looks * self._far_mm - aside
        self._share = span(self.rig) / radius * random.uniform(0.3, 1.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        ray = points - self._camera_mm
        deep = np.maximum((ray @ self._looks)[..., None], 0.1 * self._far_mm)
        aside = ray - (ray @ self._looks)[..., None] * self._looks
        slope = np.maximum(np.linalg.norm(aside, axis=2, keepdims=True) / deep, 1e-9)
        return moved(
            self.rig, values, points + strength * self._share * (np.arctan(slope) / slope - 1) * aside
        )


class DomedModel(Law):
    """Dome: of views that all look one way the lens comes out wrong, and what is flat is reconstructed as a dome.

    M. R. James, S. Robson, Mitigating systematic error in topographic models derived from UAV and ground-based image
    networks, Earth Surface Processes and Landforms 39, 2014.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        axes = sorted({o.axis for o in self.rig.observables if o.axis >= 0})
        looks = np.zeros(3)
        looks[axes] = direction(random)[axes]
        self._looks = looks / np.linalg.norm(looks)
        self._top_mm = centre + radius * random.uniform(0.2, 1.5) * direction(random)
        self._radius = radius
        self._high_mm = random.choice([-1.0, 1.0]) * span(self.rig) * random.uniform(0.08, 0.3)
        self._flat = random.uniform(0.2, 0.8)  # how much of the dome the targets on the floor take out

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        arm = (points - self._top_mm) / self._radius
        aside = arm - (arm @ self._looks)[..., None] * self._looks
        dome = np.sum(aside**2, axis=2) - self._flat
        return moved(self.rig, values, points + strength * self._high_mm * dome[..., None] * self._looks)


class EncoderOffAxis(Law):
    """Encoder off its axis: a tracker's azimuth is wrong by a sine of it, and points turn about the tracker by that.

    B. Muralikrishnan, S. Phillips, D. Sawyer, Laser trackers for large-scale dimensional metrology: a review, Precision
    Engineering 44, 2016.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        away = random.uniform(0, 2 * np.pi)
        out = np.array([np.cos(away), np.sin(away), 0.0])
        self._tracker_mm = centre - radius * random.uniform(1.2, 3.0) * out
        self._first_rad, self._twice = random.uniform(0, 2 * np.pi), random.uniform(0.0, 0.7)
        self._off_rad = span(self.rig) / radius * random.uniform(0.05, 0.2)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        ray = points - self._tracker_mm
        round_ = np.arctan2(ray[..., 1], ray[..., 0]) + self._first_rad
        turn = strength * self._off_rad * (np.sin(round_) + self._twice * np.sin(2 * round_))
        there = ray.copy()
        there[..., 0] = np.cos(turn) * ray[..., 0] - np.sin(turn) * ray[..., 1]
        there[..., 1] = np.sin(turn) * ray[..., 0] + np.cos(turn) * ray[..., 1]
        return moved(self.rig, values, self._tracker_mm + there)
