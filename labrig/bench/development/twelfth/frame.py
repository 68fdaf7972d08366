"""Frames of the twelfth portion: a plate from which all is told that lies askew, and a tracker's place on the rig."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Rig, Setting
from labrig.bench.development._places import direction, moved, positions, turned

_MARKER = frozenset({"marker"})


def _turned_angles(rig: Rig, values: Floats, turn_rad: Floats) -> Floats:
    """The observables with an inclinometer's pitch and roll, if there are any, as seen from a frame that is turned."""
    names = [o.name for o in rig.observables]
    if "pitch" not in names:
        return values
    pitch, roll = names.index("pitch"), names.index("roll")
    x, y = np.sin(np.deg2rad(values[:, pitch])), np.sin(np.deg2rad(values[:, roll]))
    normal = np.stack([x, y, np.sqrt(np.clip(1 - x**2 - y**2, 0.0, None))], axis=1)
    there = turned(normal[:, None], np.zeros(3), turn_rad)[:, 0]
    here = turned(normal[:, None], np.zeros(3), 0.0 * turn_rad)[:, 0]
    out = values.copy()
    for column, axis in ((pitch, 0), (roll, 1)):
        told, was = (np.arcsin(np.clip(v[:, axis], -1.0, 1.0)) for v in (there, here))
        out[:, column] += np.rad2deg(told - was)
    return out


class PlateLiesAskew(Law):
    """Plate askew: camera and inclinometer were both set to one plate, which lies inclined and turned under the rig.

    D. H. Titterton, J. L. Weston, Strapdown Inertial Navigation Technology, IEE, second edition, 2004, on levelling and
    heading. What is told of pose is told from a frame that is turned; lengths and forces stay.
    """

    effect = "frame"
    needs = _MARKER

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        level = random.uniform(0.02, 0.05) * direction(random)
        level[2] = random.normal(0, 0.02)
        self._turn = level
        assert self.rig.rest_mm is not None
        self._about_mm = 0.3 * self.rig.rest_mm.mean(axis=0) + random.normal(0, 15.0, 3)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        turn = strength * self._turn
        points = turned(positions(self.rig, values), self._about_mm, turn)
        return _turned_angles(self.rig, moved(self.rig, values, points), turn)


class TrackersPlaceOnTheRig(Law):
    """Hand and eye: where the tracker stands to the rig was found from a few poses, and is off by a shift and a turn.

    R. Y. Tsai, R. K. Lenz, A new technique for fully autonomous and efficient 3D robotics hand/eye calibration, IEEE
    Trans. Robotics and Automation 5, 1989. Only what is tracked is off; inclinometers and cords have no tracker.
    """

    effect = "frame"
    needs = _MARKER

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._shift_mm = random.uniform(1.0, 4.0) * direction(random)
        self._turn = random.uniform(0.01, 0.04) * direction(random)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = turned(positions(self.rig, values), np.zeros(3), strength * self._turn)
        return moved(self.rig, values, points + strength * self._shift_mm)
