"""Frames of the third portion: a screw, a decentred lens, a keystone, a wand that calibrates otherwise each time."""

import numpy as np
from scipy.spatial.transform import Rotation

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, span


class Screw(Law):
    """Chasles' screw: the frame is turned about an axis beside the body and shifted along it by its pitch.

    R. S. Ball, A Treatise on the Theory of Screws, Cambridge University Press, 1900.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        self._axis = direction(random)
        beside = np.cross(self._axis, direction(random))
        self._on_mm = centre + radius * random.uniform(1.0, 3.0) * beside / np.linalg.norm(beside)
        self._turn_rad = np.deg2rad(random.uniform(0.5, 2.0)) * random.choice([-1.0, 1.0])
        self._pitch_mm = radius * random.uniform(0.3, 2.0) * random.choice([-1.0, 1.0])  # for each rad

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        angle = strength * self._turn_rad
        turn = Rotation.from_rotvec(angle * self._axis).as_matrix()
        points = positions(self.rig, values)
        there = self._on_mm + (points - self._on_mm) @ turn.T + angle * self._pitch_mm * self._axis
        return moved(self.rig, values, there)


class DecentredLens(Law):
    """Decentred lens: all is shifted, and square to the line of sight bent a little to one side (tangentially).

    A. E. Conrady, Decentred lens-systems, Monthly Notices of the Royal Astronomical Society 79, 1919.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (self._at_mm, self._radius_mm) = setting.random, body_mm(self.rig)
        axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
        self._square = axes[:, :2]
        angle = random.uniform(0, 2 * np.pi)
        self._to = np.array([np.cos(angle), np.sin(angle)])
        self._bends_mm = span(self.rig) * random.uniform(0.01, 0.04)
        self._shift_mm = span(self.rig) * random.uniform(0.08, 0.25) * direction(random)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        flat = (points - self._at_mm) @ self._square / self._radius_mm
        bent = np.sum(flat**2, axis=2, keepdims=True) * self._to + 2 * (flat @ self._to)[..., None] * flat
        change = self._shift_mm + self._bends_mm * bent @ self._square.T
        return moved(self.rig, values, points + strength * change)


class Keystone(Law):
    """Keystone: the camera was turned a little after its calibration; what is farther off on one side looks smaller.

    C. C. Slama (ed.), Manual of Photogrammetry, 4th ed., American Society of Photogrammetry, 1980.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (self._at_mm, radius) = setting.random, body_mm(self.rig)
        sight = direction(random)
        square = np.cross(sight, direction(random))
        self._turn_rad = np.deg2rad(random.uniform(0.8, 2.5)) * square / np.linalg.norm(square)
        self._far_mm = radius * random.uniform(5, 12)  # of the camera from the body
        self._sight = sight

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        turn = Rotation.from_rotvec(strength * self._turn_rad).as_matrix()
        off = (points - self._at_mm) @ turn.T
        depth = ((points - self._at_mm) @ self._sight)[..., None] + self._far_mm
        turned = (off @ self._sight)[..., None] + self._far_mm
        return moved(self.rig, values, self._at_mm + off * depth / turned)


class NewWandEachTime(Law):
    """Calibrated anew: before each session a wand gives the frame another place and turn, each a little wrong.

    L. Chiari, U. Della Croce, A. Leardini, A. Cappozzo, Human movement analysis using stereophotogrammetry, Part 2:
    instrumental errors, Gait and Posture 21, 2005.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._centre_mm = body_mm(self.rig)[0]
        self._shifts_mm = span(self.rig) * random.uniform(0.08, 0.2) * random.normal(size=(16, 3))
        self._turns_rad = np.deg2rad(random.uniform(0.2, 1.0)) * random.normal(size=(16, 3))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points, of = positions(self.rig, values), path.session % 16
        turn = self._turns_rad[of][:, None]
        change = self._shifts_mm[of][:, None] + np.cross(turn, points - self._centre_mm)
        return moved(self.rig, values, points + strength * change)
