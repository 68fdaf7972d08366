"""Frames of the fourth portion: seven parameters a little wrong, a pane in the way, a wrong disparity."""

import numpy as np
from scipy.spatial.transform import Rotation

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, span


class SevenParameters(Law):
    """Helmert's transformation: the frame is shifted, turned and scaled at once, each by a little.

    F. R. Helmert, Die mathematischen und physikalischen Theorieen der höheren Geodäsie, Teubner, 1880.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (self._centre_mm, radius) = setting.random, body_mm(self.rig)
        self._shift_mm = span(self.rig) * random.uniform(0.05, 0.15) * direction(random)
        self._turn_rad = span(self.rig) / radius * random.uniform(0.05, 0.15) * direction(random)
        self._scale = span(self.rig) / radius * random.uniform(0.03, 0.1) * random.choice([-1.0, 1.0])

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        turn = Rotation.from_rotvec(strength * self._turn_rad).as_matrix()
        there = np.exp(strength * self._scale) * (points - self._centre_mm) @ turn.T
        return moved(self.rig, values, self._centre_mm + there + strength * self._shift_mm)


class ThroughPane(Law):
    """Flat refraction: seen through a thick pane all is nearer along its normal, the more, the more aslant one looks.

    T. Treibitz, Y. Y. Schechner, C. Kunz, H. Singh, Flat refractive geometry, IEEE Trans. Pattern Analysis and Machine
    Intelligence 34, 2012.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        sight = direction(random)
        self._camera_mm = centre - radius * random.uniform(2.5, 6.0) * sight
        aslant = np.cross(sight, direction(random))
        lean = np.deg2rad(random.uniform(0, 40)) * aslant / np.linalg.norm(aslant)
        self._normal = Rotation.from_rotvec(lean).apply(sight)
        self._index = random.uniform(1.33, 1.6)
        self._thick_mm = span(self.rig) * random.uniform(0.2, 0.7)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        ray = points - self._camera_mm
        aslant = (ray @ self._normal) / np.linalg.norm(ray, axis=2)
        nearer = 1 - aslant / np.sqrt(self._index**2 - 1 + aslant**2)
        change = -strength * self._thick_mm * nearer[..., None] * self._normal
        return moved(self.rig, values, points + change)


class WrongDisparity(Law):
    """Wrong disparity: a pair of cameras was squeezed together, and is wrong about depth by its square, along each ray.

    S. D. Blostein, T. S. Huang, Error analysis in stereo determination of 3-D point positions, IEEE Trans. Pattern
    Analysis and Machine Intelligence 9, 1987.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        self._sight = direction(random)
        self._far_mm = radius * random.uniform(3.0, 10.0)
        self._camera_mm = centre - self._far_mm * self._sight
        self._off = span(self.rig) / self._far_mm * random.uniform(0.1, 0.3) * random.choice([-1.0, 1.0])

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        ray = points - self._camera_mm
        depth = (ray @ self._sight)[..., None] / self._far_mm
        off = 0.8 * np.tanh(strength * self._off / 0.8) * depth
        return moved(self.rig, values, self._camera_mm + ray / np.maximum(1 + off, 0.05))
