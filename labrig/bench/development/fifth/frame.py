"""Frames of the fifth portion: a square laid askew, a bad level, a stretched print, metal near a magnetic tracker."""

import numpy as np
from scipy.spatial.transform import Rotation

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, span


class SquareLaidAskew(Law):
    """Square laid askew: the frame's floor is right, but its square lay turned and beside its mark on it.

    T. A. Clarke, J. G. Fryer, The development of camera calibration methods and models, Photogrammetric Record 16,
    1998; from laboratory experience. All turns about the square's corner, some way from the body, and shifts level.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        away = random.uniform(0, 2 * np.pi)
        out = np.array([np.cos(away), np.sin(away), 0.0])
        self._corner_mm = centre + radius * random.uniform(0.8, 3.0) * out
        size = span(self.rig) * random.uniform(0.06, 0.2)
        self._turn_rad = random.choice([-1.0, 1.0]) * size / radius * random.uniform(0.2, 1.0)
        aside = random.uniform(0, 2 * np.pi)
        self._shift_mm = size * random.uniform(0.3, 1.0) * np.array([np.cos(aside), np.sin(aside), 0.0])

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        turn = Rotation.from_rotvec([0.0, 0.0, strength * self._turn_rad]).as_matrix()
        there = self._corner_mm + (points - self._corner_mm) @ turn.T + strength * self._shift_mm
        return moved(self.rig, values, there)


class BadlyLevelled(Law):
    """Bad level: the frame leans about a level line on the floor far below, and its floor is too high or too low.

    J. Uren, W. F. Price, Surveying for Engineers, Macmillan, 1978; from laboratory experience.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        self._foot_mm = centre - radius * random.uniform(0.5, 3.0) * np.array([0.0, 0.0, 1.0])
        away, size = random.uniform(0, 2 * np.pi), span(self.rig) * random.uniform(0.06, 0.2)
        self._lean_rad = size / radius * np.array([np.cos(away), np.sin(away), 0.0])
        self._lift_mm = size * random.uniform(-0.5, 0.5)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        turn = Rotation.from_rotvec(strength * self._lean_rad).as_matrix()
        there = self._foot_mm + (points - self._foot_mm) @ turn.T
        there[..., 2] += strength * self._lift_mm
        return moved(self.rig, values, there)


class StretchedPrint(Law):
    """Stretched print: the printer fed the calibration sheet too fast or too slowly; one way of it has a wrong scale.

    Z. Zhang, A flexible new technique for camera calibration, IEEE Trans. Pattern Analysis and Machine Intelligence 22,
    2000; from laboratory experience. Lengths count from the sheet's corner, and across it all is right.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        axes = sorted({o.axis for o in self.rig.observables if o.axis >= 0})
        self._along = np.zeros(3)
        if random.random() < 0.6:
            self._along[int(random.choice(axes))] = 1.0
        else:
            self._along[axes] = direction(random)[axes]
        self._along /= np.linalg.norm(self._along)
        self._corner_mm = centre - radius * random.uniform(0.5, 2.0) * self._along
        self._scale = random.choice([-1.0, 1.0]) * span(self.rig) / radius * random.uniform(0.05, 0.15)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        far = (points - self._corner_mm) @ self._along
        change = np.expm1(strength * self._scale) * far[..., None] * self._along
        return moved(self.rig, values, points + change)


class MetalNearTracker(Law):
    """Metal near a magnetic tracker: all seems pushed one way, by the fourth power of its distance from the source.

    M. A. Nixon, B. C. McCallum, W. R. Fright, N. B. Price, The effects of metals and interfering fields on
    electromagnetic trackers, Presence 7, 1998.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        self._far_mm = radius * random.uniform(2.0, 5.0)
        self._source_mm = centre - self._far_mm * direction(random)
        self._away = random.uniform(0.0, 1.0)  # how much of it is along the line from the source
        self._push_mm = span(self.rig) * random.uniform(0.08, 0.25)
        self._aside = direction(random)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        ray = points - self._source_mm
        far = np.linalg.norm(ray, axis=2, keepdims=True)
        way = self._away * ray / np.maximum(far, 1e-9) + (1 - self._away) * self._aside
        change = strength * self._push_mm * (far / self._far_mm) ** 4 * way
        return moved(self.rig, values, points + change)
