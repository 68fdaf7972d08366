"""Marker slip of the tenth portion: a slide by the logarithm of time, and a sticker that buckles off and lies down."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import (
    body_mm,
    columns,
    compliance,
    direction,
    moved,
    positions,
    span,
)
from labrig.bench.development._story import a_moment_s

_MARKERS = frozenset({"markers"})


class SlidesByTheLogarithm(Law):
    """Sticky tape: from a moment on a marker slides along the skin by the logarithm of the time since then.

    C. A. Dahlquist, Pressure-sensitive adhesives, in R. L. Patrick (editor), Treatise on Adhesion and Adhesives 2,
    Dekker, 1969. Most of it comes within the first minutes; the later ones add ever less, but it never ends.
    """

    effect = "marker_slip"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        self._from_s = a_moment_s(setting)
        self._scale_s = np.exp(random.uniform(np.log(2.0), np.log(60.0)))
        self._which = int(random.integers(len(rig.marker_names)))
        centre, _ = body_mm(rig)
        out = rig.rest_mm[self._which] - centre
        out /= max(float(np.linalg.norm(out)), 1e-9)
        way = direction(random)
        way = way - 0.8 * (way @ out) * out  # along the skin
        way = np.where(columns(rig)[self._which] >= 0, way, 0.0)
        left_s = max(float(setting.path.time_s[-1]) - self._from_s, 10.0)
        far_mm = random.uniform(0.1, 0.2) * span(rig) * np.sqrt(len(rig.observables))
        self._per_unit_mm = far_mm * way / np.linalg.norm(way) / np.log1p(left_s / self._scale_s)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        since_s = np.maximum(path.time_s - self._from_s, 0.0)
        points = positions(self.rig, values)
        points[:, self._which] += strength * np.log1p(since_s / self._scale_s)[:, None] * self._per_unit_mm
        return moved(self.rig, values, points)


class BucklesOff(Law):
    """Buckled sticker: from a moment on, where the skin moves far a sticker springs off by a root, and lies down after.

    J. W. Hutchinson, Z. Suo, Mixed mode cracking in layered materials, Advances in Applied Mechanics 29, 1992: beyond a
    critical strain a film without hold buckles, as high as the root of what is beyond. One sticker, or
    two nearby; how far the skin there has moved stands for its strain.
    """

    effect = "marker_slip"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        self._from_s = a_moment_s(setting)
        able = np.flatnonzero(compliance(rig) > 0.4)
        first = int(random.choice(able))
        apart = np.linalg.norm(rig.rest_mm - rig.rest_mm[first], axis=1)
        self._which = np.argsort(apart, kind="stable")[: int(random.integers(1, 3))]
        gone = np.linalg.norm(positions(rig, rig.settled(setting.path.kpa)) - rig.rest_mm, axis=2)
        self._most_mm = np.maximum(gone[:, self._which].max(axis=0), 1e-6)
        self._critical = random.uniform(0.05, 0.3)
        centre, _ = body_mm(rig)
        out = rig.rest_mm[self._which] - centre
        out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-9)
        out = out + random.uniform(0.3, 0.7) * direction(random)
        out = np.where(columns(rig)[self._which] >= 0, out, 0.0)
        out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-9)
        far_mm = random.uniform(0.12, 0.25) * span(rig) * np.sqrt(len(rig.observables) / len(self._which))
        self._off_mm = far_mm * out
        self._stays = random.uniform(0.1, 0.4)  # how much of it is lost for good

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        assert self.rig.rest_mm is not None
        points = positions(self.rig, values)
        gone = np.linalg.norm(points - self.rig.rest_mm, axis=2)[:, self._which] / self._most_mm
        high = np.sqrt(np.maximum(gone - self._critical, 0.0))
        since = (path.time_s >= self._from_s)[:, None]
        high = since * (self._stays + (1 - self._stays) * high)
        points[:, self._which] += strength * high[..., None] * self._off_mm
        return moved(self.rig, values, points)
