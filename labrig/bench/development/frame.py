"""Frame: the measuring frame is shifted, turned or scaled against the model's, the same for all markers."""

import numpy as np
from scipy.spatial.transform import Rotation

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, shift, span


class Shifted(Law):
    """Shifted frame: its origin is not where it is thought to be.

    B. K. P. Horn, Closed-form solution of absolute orientation using unit quaternions, J. Optical Society of America A
    4, 1987.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        size_mm = span(self.rig) * setting.random.uniform(0.1, 0.3)
        self._shift_mm = shift(self.rig, size_mm * direction(setting.random))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._shift_mm


class Turned(Law):
    """Turned frame: it is rotated about an axis somewhere near the body.

    I. Söderkvist, P.-Å. Wedin, Determining the movements of the skeleton using well-configured markers, J.
    Biomechanics 26, 1993.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        centre, radius = body_mm(self.rig)
        self._centre_mm = centre + radius * setting.random.uniform(0, 0.5) * direction(setting.random)
        self._turn_rad = np.deg2rad(setting.random.uniform(0.8, 3.0)) * direction(setting.random)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        turn = Rotation.from_rotvec(strength * self._turn_rad).as_matrix() - np.eye(3)
        points = positions(self.rig, values)
        return moved(self.rig, values, points + (points - self._centre_mm) @ turn.T)


class Scaled(Law):
    """Wrong scale: a bad calibration bar makes everything too long or too short, seen from the frame's origin.

    S. Umeyama, Least-squares estimation of transformation parameters between two point patterns, IEEE Trans. Pattern
    Analysis and Machine Intelligence 13, 1991.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        centre, radius = body_mm(self.rig)
        self._origin_mm = centre + radius * setting.random.uniform(0, 1.5) * direction(setting.random)
        self._scale = setting.random.uniform(0.01, 0.04) * float(setting.random.choice([-1.0, 1.0]))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        return moved(self.rig, values, points + strength * self._scale * (points - self._origin_mm))


class MovedBetweenSessions(Law):
    """Knocked camera: from the start of a session on (of the only one, if there is one) the frame is moved and turned.

    T. Luhmann, S. Robson, S. Kyle, J. Boehm, Close-Range Photogrammetry and 3D Imaging, 2nd ed., De Gruyter, 2014.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        sessions = np.unique(setting.path.session[setting.path.row])
        self._since = int(setting.random.choice(sessions[1:] if len(sessions) > 1 else sessions))
        self._centre_mm = body_mm(self.rig)[0]
        self._shift_mm = span(self.rig) * setting.random.uniform(0.05, 0.25) * direction(setting.random)
        self._turn_rad = np.deg2rad(setting.random.uniform(0.5, 2.0)) * direction(setting.random)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        since = (path.session >= self._since)[:, None, None]
        turn = Rotation.from_rotvec(strength * self._turn_rad).as_matrix() - np.eye(3)
        points = positions(self.rig, values)
        change = (points - self._centre_mm) @ turn.T + strength * self._shift_mm
        return moved(self.rig, values, points + since * change)
