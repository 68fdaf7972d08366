"""Further frames: skew axes, a hinge that was left loose, a camera moved off its calibration, a sagging tripod."""

import numpy as np
from scipy.spatial.transform import Rotation

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, long_axis, moved, positions, shift, span


class SkewAxes(Law):
    """Affine camera: the axes have scales of their own and are not quite square.

    R. Hartley, A. Zisserman, Multiple View Geometry in Computer Vision, 2nd ed., Cambridge University Press, 2003.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._centre_mm = body_mm(self.rig)[0]
        self._stretch = np.diag(random.normal(0, 0.025, 3)) + np.triu(random.normal(0, 0.015, (3, 3)), 1)
        self._shift_mm = span(self.rig) * random.uniform(0.0, 0.1) * direction(random)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        change = (points - self._centre_mm) @ self._stretch.T + self._shift_mm
        return moved(self.rig, values, points + strength * change)


class LooseHinge(Law):
    """Loose hinge: the whole body is swung about an axis at one of its ends, square to its length.

    R. M. Murray, Z. Li, S. S. Sastry, A Mathematical Introduction to Robotic Manipulation, CRC Press, 1994.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        axis, along = long_axis(rig)
        end = float(random.choice([0.0, 1.0]))
        self._pin_mm = rig.rest_mm[int(np.argmin(np.abs(along - end)))]
        square = np.cross(axis, random.normal(size=3))
        self._turn_rad = np.deg2rad(random.uniform(0.5, 2.5)) * square / np.linalg.norm(square)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        turn = Rotation.from_rotvec(strength * self._turn_rad).as_matrix() - np.eye(3)
        points = positions(self.rig, values)
        return moved(self.rig, values, points + (points - self._pin_mm) @ turn.T)


class MovedCamera(Law):
    """Moved camera: all is shifted, and its lens, now looking elsewhere, bends straight lines a little (radially).

    D. C. Brown, Decentering distortion of lenses, Photogrammetric Engineering 32, 1966.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, self._radius_mm) = setting.random, body_mm(self.rig)
        self._looks = direction(random)
        self._at_mm = centre + self._radius_mm * random.uniform(0.0, 0.6) * direction(random)
        self._shift_mm = span(self.rig) * random.uniform(0.1, 0.3) * direction(random)
        self._bends = span(self.rig) * random.uniform(0.01, 0.03) * float(random.choice([-1.0, 1.0]))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        off = points - self._at_mm
        off = (off - (off @ self._looks)[..., None] * self._looks) / self._radius_mm
        bent = self._bends * np.sum(off**2, axis=2, keepdims=True) * off
        return moved(self.rig, values, points + strength * (self._shift_mm + bent))


class SaggingTripod(Law):
    """Sagging tripod: from session to session the camera is a little lower and more inclined, and less so each time.

    W. Förstner, B. P. Wrobel, Photogrammetric Computer Vision, Springer, 2016.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        self._centre_mm = centre + radius * random.uniform(0.5, 2.0) * direction(random)
        self._sinks_mm = np.array([0.0, 0.0, 1.0]) * span(self.rig) * random.uniform(0.05, 0.2)
        level = np.append(random.normal(size=2), 0.0)
        self._turn_rad = np.deg2rad(random.uniform(0.3, 1.2)) * level / np.linalg.norm(level)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        sunk = strength * np.sqrt(1.0 + path.session)[:, None, None]
        points = positions(self.rig, values)
        change = self._sinks_mm + np.cross(self._turn_rad, points - self._centre_mm)
        return moved(self.rig, values, points + sunk * change)


class WrongDepth(Law):
    """Wrong focal length: along the line of sight everything is too long or too short, and too near or too far.

    Z. Zhang, A flexible new technique for camera calibration, IEEE Trans. Pattern Analysis and Machine Intelligence 22,
    2000.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        self._sight = direction(random)
        self._from_mm = centre - radius * random.uniform(0.5, 2.0) * self._sight
        self._scale = random.uniform(0.02, 0.06) * float(random.choice([-1.0, 1.0]))
        self._aside_mm = shift(self.rig, span(self.rig) * random.uniform(0.0, 0.08) * direction(random))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        depth = (points - self._from_mm) @ self._sight
        out = moved(self.rig, values, points + strength * self._scale * depth[..., None] * self._sight)
        return out + strength * self._aside_mm
