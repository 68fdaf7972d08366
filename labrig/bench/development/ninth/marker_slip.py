"""Marker slip of the ninth portion: one is knocked, peels, dangles, is stuck elsewhere, or is bent."""

from abc import ABC, abstractmethod

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.bench._nature import Law, Path, Rig, Setting
from labrig.bench.development._places import body_mm, columns, direction, down, moved, positions, span
from labrig.bench.development._story import a_moment_s

_MARKERS = frozenset({"markers"})


class _Slip(Law, ABC):
    """What all of them have: one marker, the moment just before a capture, and how far it goes."""

    effect = "marker_slip"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._from_s = a_moment_s(setting)
        axes = np.sum(columns(rig) >= 0, axis=1)
        self._which = int(random.choice(np.flatnonzero(axes == axes.max())))
        self._far_mm = float(random.uniform(0.07, 0.15) * span(rig) * np.sqrt(len(rig.observables)))

    @abstractmethod
    def off_mm(self, path: Path, points_mm: Floats) -> Floats:
        """Where the marker is, (T, 3) or (3,), as seen from where it was, once it is off."""

    def gone(self, path: Path) -> Floats:
        """How much of the way (T,) it has gone."""
        return (path.time_s >= self._from_s).astype(float)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        off = strength * self.gone(path)[:, None] * self.off_mm(path, points)
        points[:, self._which] += off
        return moved(self.rig, values, points)


def _visible(rig: Rig, marker: int, vector: Floats) -> Floats:
    """A direction like `vector`, in the axes along which a marker is seen."""
    out = np.where(columns(rig)[marker] >= 0, vector, 0.0)
    return out / max(float(np.linalg.norm(out)), 1e-9)


def _outwards(rig: Rig, marker: int) -> Floats:
    """The direction away from the body's centre at a marker."""
    assert rig.rest_mm is not None
    out = rig.rest_mm[marker] - body_mm(rig)[0]
    return out / max(float(np.linalg.norm(out)), 1e-9)


def _nearest(rig: Rig, marker: int) -> Ints:
    """The other markers, the nearest first."""
    assert rig.rest_mm is not None
    order = np.argsort(np.linalg.norm(rig.rest_mm - rig.rest_mm[marker], axis=1), kind="stable")
    return order[order != marker]


class KnockedAside(_Slip):
    """Knocked aside: a hand brushes one marker, and from then on it is beside its place, always by as much.

    L. Chiari, U. Della Croce, A. Leardini, A. Cappozzo, Human movement analysis using stereophotogrammetry,
    part 2: instrumental errors, Gait and Posture 21, 2005.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        out, way = _outwards(self.rig, self._which), direction(setting.random)
        way = way - 0.7 * (way @ out) * out  # along the skin more than off it
        self._off_mm = self._far_mm * _visible(self.rig, self._which, way)

    def off_mm(self, path: Path, points_mm: Floats) -> Floats:
        return self._off_mm


class PeelsSteadily(_Slip):
    """Peels steadily: a sticker's edge lifts, and it comes off at a constant rate until it stands out.

    R. S. Rivlin, The effective work of adhesion, Paint Technology 9, 1944: under a steady pull the front of a
    peel advances at a steady pace. It begins with a jerk.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        left_s = float(setting.path.session_s.max())
        self._takes_s = min(random.uniform(20, 300), random.uniform(0.02, 0.2) * max(left_s, 1.0))
        self._jerk = random.uniform(0.2, 0.5)
        way = _outwards(self.rig, self._which) + random.uniform(0.3, 1.0) * direction(random)
        self._off_mm = self._far_mm * _visible(self.rig, self._which, way)

    def gone(self, path: Path) -> Floats:
        peeled = np.clip((path.time_s - self._from_s) / self._takes_s, 0.0, 1.0)
        return super().gone(path) * (self._jerk + (1 - self._jerk) * peeled)

    def off_mm(self, path: Path, points_mm: Floats) -> Floats:
        return self._off_mm


class Dangles(_Slip):
    """Dangles: the glue is gone but for a thread, on which the marker hangs straight down.

    C. Huygens, Horologium Oscillatorium, 1673, on what hangs by a thread. It does so whichever way the base
    leans, but rests a little on the skin beside it.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        aside = setting.random.uniform(0.2, 0.6) * direction(setting.random)
        self._aside = np.where(columns(self.rig)[self._which] >= 0, aside, 0.0)

    def off_mm(self, path: Path, points_mm: Floats) -> Floats:
        return self._far_mm * (down(path.tilt_deg) + self._aside)


class StuckOnElsewhere(_Slip):
    """Stuck on elsewhere: somebody picks the fallen marker up and sticks it back, towards another.

    U. Della Croce, A. Leardini, L. Chiari, A. Cappozzo, Human movement analysis using stereophotogrammetry,
    part 4: assessment of anatomical landmark misplacement, Gait and Posture 21, 2005. It now follows the skin
    at its new place.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        others = _nearest(rig, self._which)
        apart_mm = np.linalg.norm(rig.rest_mm[others] - rig.rest_mm[self._which], axis=1)
        first = min(int(np.sum(apart_mm < self._far_mm)) + int(random.integers(3)), len(others) - 1)
        self._other = int(others[first])
        self._share = min(self._far_mm / max(float(apart_mm[first]), 1e-9), 1.0)

    def off_mm(self, path: Path, points_mm: Floats) -> Floats:
        return self._share * (points_mm[:, self._other] - points_mm[:, self._which])


class StemBent(_Slip):
    """Stem bent: a ball on a stem is hit, and sits aside by a vector that turns with the skin.

    A. Cappozzo, F. Catani, U. Della Croce, A. Leardini, Position and orientation in space of bones during
    movement, Clinical Biomechanics 10, 1995, on markers fixed to plates. The turn is the neighbours' best one
    (W. Kabsch, Acta Crystallographica A 32, 1976), held a little to none where they leave it open.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig = self.rig
        assert rig.rest_mm is not None
        self._plate = np.append(_nearest(rig, self._which)[:4], self._which)
        at_rest = positions(rig, rig.at_rest[None])[0, self._plate]
        self._arms_mm = at_rest - at_rest.mean(axis=0)
        self._hold = 0.05 * float(np.sum(self._arms_mm**2)) * np.eye(3)
        self._off_mm = self._far_mm * _visible(rig, self._which, direction(setting.random))

    def off_mm(self, path: Path, points_mm: Floats) -> Floats:
        plate = points_mm[:, self._plate]
        arms = plate - plate.mean(axis=1, keepdims=True)
        left, _, right = np.linalg.svd(np.einsum("tnx,ny->txy", arms, self._arms_mm) + self._hold)
        left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
        return left @ right @ self._off_mm
