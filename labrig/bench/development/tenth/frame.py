"""Frames of the tenth portion: cameras that were moved for a while, and two volumes that were stitched badly."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, span, turned

_MARKERS = frozenset({"markers"})


class MovedForAWhile(Law):
    """Moved for a while: somebody pushes the cameras aside, and later back to their marks on the floor, nearly.

    M. Windolf, N. Götzen, M. Morlock, Systematic accuracy and precision analysis of video motion capturing systems,
    J. Biomechanics 41, 2008, on set-up. In between the frame is shifted and turned, and afterwards by a rest of it.
    """

    effect = "frame"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        rows_s = path.time_s[path.row]
        begin, last = random.uniform(0.1, 0.45), random.uniform(0.2, 0.45)
        at = np.array([begin, begin + last]) * (len(rows_s) - 1)
        self._from_s, self._to_s = rows_s[at.astype(int)] - 0.3
        self._centre_mm, radius_mm = body_mm(self.rig)
        far_mm = random.uniform(0.2, 0.35) * span(self.rig) * np.sqrt(3.0)
        share = random.uniform(0.3, 0.8)
        self._shift_mm = far_mm * share * direction(random)
        self._turn = min(far_mm * (1 - share) / radius_mm, 0.1) * direction(random)
        self._rest = random.uniform(-0.25, 0.25)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength == 0:
            return values
        during = (path.time_s >= self._from_s) & (path.time_s < self._to_s)
        off = strength * (during + self._rest * (path.time_s >= self._to_s))[:, None]
        points = turned(positions(self.rig, values), self._centre_mm, off * self._turn)
        return moved(self.rig, values, points + (off * self._shift_mm)[:, None])


class StitchedVolumes(Law):
    """Stitched volumes: two sets of cameras see a half each, and on one side of a plane the frame is another one.

    P. J. Besl, N. D. McKay, A method for registration of 3-D shapes, IEEE Transactions on Pattern Analysis and Machine
    Intelligence 14(2), 1992: the two were laid over each other by what both saw, and a turn about there is left, and a
    shift. Near the plane both views are blended; what moves across it changes from one to the other.
    """

    effect = "frame"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        centre, radius_mm = body_mm(self.rig)
        self._normal = direction(random)
        self._on_mm = centre + random.uniform(-0.3, 0.3) * radius_mm * self._normal
        self._blends_mm = random.uniform(0.05, 0.25) * radius_mm
        far_mm = random.uniform(0.25, 0.4) * span(self.rig) * np.sqrt(3.0)
        share = random.uniform(0.3, 0.7)
        self._shift_mm = far_mm * share * direction(random)
        self._turn = min(far_mm * (1 - share) / radius_mm, 0.1) * direction(random)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength == 0:
            return values
        points = positions(self.rig, values)
        beyond = (points - self._on_mm) @ self._normal / self._blends_mm
        other = turned(points, self._on_mm, strength * self._turn) + strength * self._shift_mm
        blend = 0.5 * (1 + np.tanh(beyond))[..., None]
        return moved(self.rig, values, points + blend * (other - points))
