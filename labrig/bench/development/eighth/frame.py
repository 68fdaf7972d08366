"""Frame of the eighth portion: turned and shifted, its origin off, kicked, clamped anew, and another turning axis."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Rig, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, span, turned


def _angle(rig: Rig, share: float) -> float:
    """The angle in rad that moves the markers by a share of the rig's motion, three degrees at most."""
    return min(share * span(rig) / body_mm(rig)[1], float(np.deg2rad(3.0)))


class FrameShiftedAndTurned(Law):
    """Frame shifted and turned: the cameras' axes are a rigid motion away from the rig's, as when they were set up.

    B. K. P. Horn, Closed-form solution of absolute orientation using unit quaternions, J. Optical Society of America A
    4, 1987.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._turn_rad = _angle(rig, random.uniform(0.1, 0.2)) * direction(random)
        self._shift_mm = random.uniform(0.08, 0.2) * span(rig) * direction(random)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        turn = np.broadcast_to(strength * self._turn_rad, (len(values), 3))
        placed = turned(points, body_mm(self.rig)[0], turn) + strength * self._shift_mm
        return moved(self.rig, values, placed)


class OriginOff(Law):
    """Origin off: the calibration square did not lie where the drawing has it, so that all is shifted by as much.

    R. Hartley, A. Zisserman, Multiple View Geometry in Computer Vision, Cambridge University Press, 2000: the frame of
    a reconstruction is that of its ground truth. Squares lie flat, so that it is off sideways most.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        flat = direction(random) * np.array([1.0, 1.0, random.uniform(0.2, 0.8)])
        self._shift_mm = random.uniform(0.1, 0.25) * span(self.rig) * flat / np.linalg.norm(flat)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return moved(self.rig, values, positions(self.rig, values) + strength * self._shift_mm)


class TripodKicked(Law):
    """Tripod kicked: from one moment on the cameras stand elsewhere, turned a little about a foot of their tripod.

    T. Luhmann, S. Robson, S. Kyle, J. Boehm, Close-Range Photogrammetry and 3D Imaging, De Gruyter, 2014, on stable
    exterior orientation.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig, path = setting.random, self.rig, setting.path
        rows = path.time_s[path.row]
        self._kick_s = rows[int(random.uniform(0.15, 0.7) * len(rows))] - 0.3
        centre, radius = body_mm(rig)
        self._foot_mm = centre + radius * random.uniform(1.0, 4.0) * direction(random)
        self._turn_rad = _angle(rig, random.uniform(0.08, 0.16)) * direction(random)
        self._shift_mm = random.uniform(0.05, 0.12) * span(rig) * direction(random)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        on = strength * (path.time_s >= self._kick_s)[:, None]
        placed = turned(positions(self.rig, values), self._foot_mm, on * self._turn_rad)
        return moved(self.rig, values, placed + on[..., None] * self._shift_mm)


class ClampedAnew(Law):
    """Clamped anew: each session begins with the rig put back into its clamp, never twice in quite the same pose.

    A. H. Slocum, Precision Machine Design, Prentice Hall, 1992, on how repeatable couplings are. It turns most about
    the clamp's axis.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        count = int(setting.path.session.max()) + 1
        loose = np.array([0.4, 0.4, 1.0])  # more about z
        angle = _angle(rig, random.uniform(0.08, 0.16))
        self._turn_rad = angle * random.normal(size=(count, 3)) * loose
        self._shift_mm = random.uniform(0.06, 0.12) * span(rig) * random.normal(size=(count, 3))
        assert rig.rest_mm is not None
        self._clamp_mm = rig.rest_mm.mean(axis=0) * np.array([1.0, 1.0, 0.0])

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        session = np.minimum(path.session, len(self._turn_rad) - 1)
        placed = turned(positions(self.rig, values), self._clamp_mm, strength * self._turn_rad[session])
        return moved(self.rig, values, placed + strength * self._shift_mm[session][:, None])


class TurningAxisElsewhere(Law):
    """Turning axis elsewhere: the base turns about an axis that is not the drawing's, and the markers come back beside.

    B. Mooring, Z. Roth, M. Driels, Fundamentals of Manipulator Calibration, Wiley, 1991. Cameras stand in the room;
    what they see is turned back by the angle that the table reads, about the place where its axis should be.
    """

    effect = "frame"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._off_mm = random.uniform(0.18, 0.35) * span(rig) * direction(random) * np.array([0.2, 1.0, 1.0])
        self._skew_rad = _angle(rig, random.uniform(0.05, 0.12)) * random.normal(size=2)
        self._scale = random.uniform(-0.01, 0.01)  # of the angle

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        tilt = np.deg2rad(path.tilt_deg)[:, None]
        read = np.array([1.0, 0.0, 0.0])
        true = np.array([1.0, *(strength * self._skew_rad)])
        true *= (1 + strength * self._scale) / np.linalg.norm(true)
        points = positions(self.rig, values)
        placed = turned(points, strength * self._off_mm, tilt * true)
        return moved(self.rig, values, turned(placed, np.zeros(3), -tilt * read))
