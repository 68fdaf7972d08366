"""Marker slip of the eighth portion: one moves, a few do, one slides downhill, some are wiped, one half peels."""

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.bench._nature import Law, Path, Rig, Setting
from labrig.bench.development._places import body_mm, columns, direction, down, moved, positions, span

_MARKERS = frozenset({"markers"})


def _moment(setting: Setting) -> float:
    """When it happens, in s: some time in the middle part of the campaign, just before a row."""
    rows = setting.path.time_s[setting.path.row]
    return float(rows[int(setting.random.uniform(0.15, 0.7) * len(rows))] - 0.3)


def _one(setting: Setting) -> int:
    """A marker that is seen along two axes or more."""
    seen = np.sum(columns(setting.rig) >= 0, axis=1)
    return int(setting.random.choice(np.flatnonzero(seen >= 2)))


def _near(rig: Rig, marker: int, count: int) -> Ints:
    """A marker and those next to it, `count` in all."""
    assert rig.rest_mm is not None
    return np.argsort(np.linalg.norm(rig.rest_mm - rig.rest_mm[marker], axis=1), kind="stable")[:count]


def _within(rig: Rig, marker: int, vector: Floats) -> Floats:
    """A direction like `vector`, within the axes along which a marker is seen."""
    out = np.where(columns(rig)[marker] >= 0, vector, 0.0)
    return out / max(float(np.linalg.norm(out)), 1e-9)


def _skin(rig: Rig, marker: int, vector: Floats) -> Floats:
    """What of a vector lies in the skin at a marker, which faces away from the body's centre."""
    assert rig.rest_mm is not None
    normal = rig.rest_mm[marker] - body_mm(rig)[0]
    normal = normal / max(float(np.linalg.norm(normal)), 1e-9)
    return vector - 0.9 * (vector @ normal) * normal


def _far(setting: Setting, low: float, high: float) -> float:
    """How far a marker goes, in mm: so that all observables together change by a share of the rig's motion."""
    return setting.random.uniform(low, high) * span(setting.rig) * np.sqrt(len(setting.rig.observables))


class MarkerMoves(Law):
    """A marker moves: at one moment one of them jumps to another place on the skin, and stays there.

    A. Cappozzo, F. Catani, A. Leardini, M. G. Benedetti, U. Della Croce, Position and orientation in space of bones
    during movement: experimental artefacts, Clinical Biomechanics 11, 1996.
    """

    effect = "marker_slip"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._at_s, self._which = _moment(setting), _one(setting)
        way = _within(self.rig, self._which, direction(setting.random))
        self._to_mm = _far(setting, 0.06, 0.14) * way

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        points[:, self._which] += strength * (path.time_s >= self._at_s)[:, None] * self._to_mm
        return moved(self.rig, values, points)


class FewMarkersMove(Law):
    """A few markers move: at one moment two or three are knocked from their places, each its own way.

    L. Chiari, U. Della Croce, A. Leardini, A. Cappozzo, Human movement analysis using stereophotogrammetry, part 2:
    instrumental errors, Gait and Posture 21, 2005, on where markers end up.
    """

    effect = "marker_slip"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._at_s = _moment(setting)
        count = min(int(random.integers(2, 4)), max(1, len(rig.marker_names) // 3))
        first = _one(setting)
        others = random.permutation(np.delete(np.arange(len(rig.marker_names)), first))
        self._which = np.array([first, *others[: count - 1]])
        ways = [_within(rig, int(m), direction(random)) for m in self._which]
        self._to_mm = _far(setting, 0.06, 0.1) * random.uniform(0.6, 1.0, (count, 1)) * np.array(ways)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        points[:, self._which] += strength * (path.time_s >= self._at_s)[:, None, None] * self._to_mm
        return moved(self.rig, values, points)


class SlidesDownhill(Law):
    """Slides downhill: the glue of one marker gives up, and the ball slides down the skin until it holds again.

    A. J. Kinloch, Adhesion and Adhesives: Science and Technology, Chapman and Hall, 1987. It takes some seconds, and
    goes where down is at that moment.
    """

    effect = "marker_slip"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig, path = setting.random, self.rig, setting.path
        self._at_s, self._which = _moment(setting), _one(setting)
        self._tau_s = random.uniform(0.5, 3.0)
        now = min(int(np.searchsorted(path.time_s, self._at_s)), len(path.time_s) - 1)
        way = _skin(rig, self._which, down(path.tilt_deg[now : now + 1])[0])
        seen = columns(rig)[self._which] >= 0
        aside = 0.1 * direction(random) + (0.0 if np.any(np.abs(way[seen]) > 0.05) else direction(random))
        self._to_mm = _far(setting, 0.06, 0.14) * _within(rig, self._which, way + aside)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        slid = -np.expm1(-np.maximum(path.time_s - self._at_s, 0.0) / self._tau_s)
        points = positions(self.rig, values)
        points[:, self._which] += strength * slid[:, None] * self._to_mm
        return moved(self.rig, values, points)


class WipedByACloth(Law):
    """Wiped by a cloth: someone cleans the skin, and drags a few neighbouring markers along, the middle one furthest.

    A. Leardini, L. Chiari, U. Della Croce, A. Cappozzo, Human movement analysis using stereophotogrammetry, part 3:
    soft tissue artifact assessment and compensation, Gait and Posture 21, 2005, for markers that move on skin.
    """

    effect = "marker_slip"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._at_s = _moment(setting)
        middle = _one(setting)
        count = min(int(random.integers(2, 5)), max(1, len(rig.marker_names) // 3))
        self._which = _near(rig, middle, count)
        wipe = _within(rig, middle, _skin(rig, middle, direction(random)))
        less = np.linspace(1.0, random.uniform(0.3, 0.7), count)
        self._to_mm = _far(setting, 0.06, 0.12) * less[:, None] * wipe

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        points[:, self._which] += strength * (path.time_s >= self._at_s)[:, None, None] * self._to_mm
        return moved(self.rig, values, points)


class HalfPeeledDot(Law):
    """Half peeled dot: at one moment a sticker comes off on one side; it stands out, and further where the skin moves.

    K. Kendall, Thin-film peeling: the elastic term, Journal of Physics D 8, 1975.
    """

    effect = "marker_slip"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._at_s, self._which = _moment(setting), _one(setting)
        assert rig.rest_mm is not None
        outwards = rig.rest_mm[self._which] - body_mm(rig)[0]
        outwards = outwards / max(float(np.linalg.norm(outwards)), 1e-9) + 0.5 * direction(random)
        self._to_mm = _far(setting, 0.05, 0.1) * _within(rig, self._which, outwards)
        self._flaps = random.uniform(0.2, 0.6)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        rig = self.rig
        points = positions(rig, values)
        assert rig.rest_mm is not None
        gone = np.linalg.norm(points[:, self._which] - rig.rest_mm[self._which], axis=1) / span(rig)
        stands = (path.time_s >= self._at_s) * (1 + self._flaps * np.tanh(gone))
        points[:, self._which] += strength * stands[:, None] * self._to_mm
        return moved(rig, values, points)
