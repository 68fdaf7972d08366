"""Marker slip of the eleventh portion: a sticker whose hold shrinks as it slides, and a pin that topples."""

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import (
    alone,
    body_mm,
    columns,
    compliance,
    direction,
    down,
    moved,
    positions,
    span,
)
from labrig.bench.development._story import a_moment_s

_MARKERS = frozenset({"markers"})


def _along(setting: Setting, which: int, way: Floats) -> Floats:
    """A direction (3,) along the skin at a marker, near `way`, as far as it is measured."""
    rig = setting.rig
    assert rig.rest_mm is not None
    out = rig.rest_mm[which] - body_mm(rig)[0]
    out /= max(float(np.linalg.norm(out)), 1e-9)
    way = way + 0.3 * direction(setting.random)
    way = np.where(columns(rig)[which] >= 0, way - 0.85 * (way @ out) * out, 0.0)
    return way / max(float(np.linalg.norm(way)), 1e-9)


class OverlapShrinks(Law):
    """Shear holding power: a sticker slides off its place by its weight, the faster, the less of it still holds.

    D. Satas (editor), Handbook of Pressure Sensitive Adhesive Technology, Van Nostrand Reinhold, 1989: a layer that
    flows as a liquid holds for a time that goes with the square of its length, and its overlap goes as the root of the
    time that is left. It hangs from the first moment on, and is near to falling off at the end.
    """

    effect = "marker_slip"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig, time_s = setting.random, self.rig, setting.path.time_s
        self._which = int(random.integers(len(rig.marker_names)))
        self._from_s = float(time_s[0])
        self._lasts_s = (float(time_s[-1]) - self._from_s) * random.uniform(1.01, 1.4)
        far_mm = random.uniform(0.15, 0.3) * span(rig) * np.sqrt(len(rig.observables))
        at_end = 1 - np.sqrt(1 - (float(time_s[-1]) - self._from_s) / self._lasts_s)
        self._long_mm = far_mm / at_end * _along(setting, self._which, np.array([0.0, 0.0, -1.0]))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        gone = np.clip((path.time_s - self._from_s) / self._lasts_s, 0.0, 1.0)
        points = positions(self.rig, values)
        points[:, self._which] += strength * (1 - np.sqrt(1 - gone))[:, None] * self._long_mm
        return moved(self.rig, values, points)


class TopplesInItsHole(Law):
    """Loose pin: from a moment on a marker's pin leans in its hole, and topples to its other side as the skin tips.

    A. Cappozzo et al., Position and orientation in space of bones during movement: experimental artefacts, Clinical
    Biomechanics 11, 1996, on markers that move against what they are on. Friction in the hole makes it topple later
    than the skin has passed the upright, to either side; a base that is tilted decides for one side.
    """

    effect = "marker_slip"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig, path = setting.random, self.rig, setting.path
        self._from_s = a_moment_s(setting)
        able = np.flatnonzero(compliance(rig) > 0.3)
        self._which = int(random.choice(able))
        self._way = _along(setting, self._which, direction(random))
        self._far_mm = random.uniform(0.1, 0.2) * span(rig) * np.sqrt(len(rig.observables))
        where = columns(rig)[self._which]
        each = np.where(where >= 0, alone(rig)[:, where], 0.0)
        self._tips = each @ self._way + 0.3 * np.linalg.norm(each, axis=1) * random.normal(size=len(each))
        self._tips /= max(float(np.abs(self._tips).sum()), 1e-9)
        level = (rig.deflection(path.kpa) @ self._tips)[path.row]
        self._upright = float(np.quantile(level, random.uniform(0.35, 0.65)))
        self._wide = max(float(np.std(level)), 1e-3)
        self._rubs = random.uniform(0.1, 0.5)  # by how many usual sizes it is late
        self._tilted = random.uniform(0.5, 2.0)
        self._side = int(random.choice([-1, 1]))  # to which it leans at first

    def _leans(self, drive: Floats) -> Ints:
        """To which side (T,) it leans: the last one beyond its friction."""
        side = np.where(np.abs(drive) > self._rubs, np.sign(drive), 0.0)
        last = np.maximum.accumulate(np.where(side != 0, np.arange(len(side)), -1))
        return np.where(last >= 0, side[np.maximum(last, 0)], self._side).astype(np.int64)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        tips = (deflection @ self._tips - self._upright) / self._wide
        by_base = self._tilted * ((down(path.tilt_deg) - np.array([0.0, 0.0, -1.0])) @ self._way)
        loose = path.time_s >= self._from_s
        off_mm = strength * self._far_mm * (loose * self._leans(tips + by_base))
        points = positions(self.rig, values)
        points[:, self._which] += off_mm[:, None] * self._way
        return moved(self.rig, values, points)
