"""Frame of the ninth portion: a datum off, a bumped camera, a bad wand, a bad registration, new ones."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Rig, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, span, turned
from labrig.bench.development._story import a_moment_s

_MARKERS = frozenset({"markers"})


def _some_angle(rig: Rig, share: float, arm_mm: float) -> float:
    """The angle in rad that moves what is so far off by a share of the rig's motion, at most two degrees."""
    return min(share * span(rig) / arm_mm, float(np.deg2rad(2.0)))


class DatumOff(Law):
    """Datum off: the cameras' coordinates and the model's differ by a turn, a shift and a scale, always.

    F. R. Helmert, Die mathematischen und physikalischen Theorieen der höheren Geodäsie, Teubner, 1880, the
    transformation by seven parameters.
    """

    effect = "frame"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._centre_mm, radius = body_mm(rig)
        self._turn_rad = _some_angle(rig, random.uniform(0.1, 0.25), radius) * direction(random)
        self._shift_mm = random.uniform(0.1, 0.2) * span(rig) * direction(random)
        self._scale = min(random.uniform(0.02, 0.08) * span(rig) / radius, 0.01) * random.choice([-1.0, 1.0])

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        placed = turned(points, self._centre_mm, strength * self._turn_rad)
        placed += strength * (self._scale * (placed - self._centre_mm) + self._shift_mm)
        return moved(self.rig, values, placed)


class CameraBumped(Law):
    """Camera bumped: somebody runs into the camera, and from then on it looks another way.

    T. Luhmann, S. Robson, S. Kyle, J. Boehm, Close-Range Photogrammetry and 3D Imaging, De Gruyter, 2014, on
    changes of the exterior orientation. Seen from there, the whole scene is turned about the camera.
    """

    effect = "frame"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._from_s = a_moment_s(setting)
        centre, radius = body_mm(rig)
        far_mm = random.uniform(3, 10) * radius
        self._camera_mm = centre + far_mm * direction(random)
        self._turn_rad = _some_angle(rig, random.uniform(0.15, 0.35), far_mm) * direction(random)
        self._shift_mm = random.uniform(0.03, 0.1) * span(rig) * direction(random)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        placed = turned(points, self._camera_mm, strength * self._turn_rad) + strength * self._shift_mm
        since = (path.time_s >= self._from_s)[:, None, None]
        return moved(self.rig, values, np.where(since, placed, points))


class WandTooLong(Law):
    """Wand too long: the bar that gave the scale is not as long as typed in, and all is larger or smaller.

    N. A. Borghese, P. Cerveri, Calibrating a video camera pair with a rigid bar, Pattern Recognition 33,
    2000. All points go away from the origin of the cameras' frame, which is beside the rig.
    """

    effect = "frame"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        centre, radius = body_mm(rig)
        far_mm = random.uniform(1.0, 4.0) * radius
        self._origin_mm = centre + far_mm * direction(random)
        longer = random.uniform(0.12, 0.3) * span(rig) / np.hypot(far_mm, radius)
        self._longer = min(longer, 0.04) * random.choice([-1.0, 1.0])

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        return moved(self.rig, values, points + strength * self._longer * (points - self._origin_mm))


class BadRegistration(Law):
    """Bad registration: a few fixed targets tie the cameras to the rig, and were measured badly.

    J. M. Fitzpatrick, J. B. West, C. R. Maurer, Predicting error in rigid-body point-based registration, IEEE
    Transactions on Medical Imaging 17, 1998. All markers get the best rigid motion from the targets to what
    was read of them; far from the targets it is worse.
    """

    effect = "frame"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        centre, radius = body_mm(rig)
        count = int(random.integers(3, 7))
        around = random.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(count) / count
        ring = np.column_stack([np.cos(around), np.sin(around), random.uniform(-0.3, 0.3, count)])
        wide_mm = random.uniform(0.8, 1.6) * radius
        self._targets_mm = centre + wide_mm * (ring + random.normal(0, 0.1, ring.shape))
        self._targets_mm += radius * random.uniform(0.0, 1.0) * direction(random)
        wrong_mm = min(random.uniform(0.25, 0.5) * span(rig), 0.1 * wide_mm)
        self._wrong_mm = wrong_mm * random.normal(size=ring.shape)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        read_mm = self._targets_mm + strength * self._wrong_mm
        middle, read_middle = self._targets_mm.mean(axis=0), read_mm.mean(axis=0)
        left, _, right = np.linalg.svd((self._targets_mm - middle).T @ (read_mm - read_middle))
        mirror = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
        points = positions(self.rig, values)
        return moved(self.rig, values, (points - middle) @ (left @ mirror @ right) + read_middle)


class CalibratedAnew(Law):
    """Calibrated anew: before each later session the wand is waved again, and the frame is another.

    R. Hartley, A. Zisserman, Multiple View Geometry in Computer Vision, Cambridge University Press, 2000: a
    calibration leaves a similarity free, a turn, a shift and a scale. In a campaign of one session it happens
    in a break.
    """

    effect = "frame"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig, path = setting.random, self.rig, setting.path
        rows_s = path.time_s[path.row]
        later = [path.time_s[path.session == k][0] for k in np.unique(path.session)[1:]]
        if not later:
            later = [rows_s[int(random.uniform(0.3, 0.6) * len(rows_s))]]
        self._from_s = np.array(later) - 0.3
        centre, radius = body_mm(rig)
        self._origin_mm = centre + radius * random.uniform(0.5, 2.0) * direction(random)
        angle = _some_angle(rig, random.uniform(0.1, 0.25), radius)
        shift_mm, scale = random.uniform(0.1, 0.25) * span(rig), random.uniform(0.0005, 0.004)
        self._turns_rad = [angle * random.uniform(0.7, 1.3) * direction(random) for _ in later]
        self._shifts_mm = [shift_mm * random.uniform(0.7, 1.3) * direction(random) for _ in later]
        self._scales = scale * random.normal(size=len(later))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        placed = points.copy()
        frame = np.searchsorted(self._from_s, path.time_s, side="right") - 1
        for k, (turn_rad, shift_mm) in enumerate(zip(self._turns_rad, self._shifts_mm, strict=True)):
            now = points[frame == k]
            there = turned(now, self._origin_mm, strength * turn_rad)
            larger = strength * self._scales[k] * (there - self._origin_mm)
            placed[frame == k] = there + larger + strength * shift_mm
        return moved(self.rig, values, placed)
