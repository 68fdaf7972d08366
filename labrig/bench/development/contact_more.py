"""Further contact: round tips, elastic beds, corners, planes that hold what they touch, a stop of the whole body."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import moved, pattern, positions, reached
from labrig.bench.development.contact import Plane


class HertzTip(Law):
    """Hertz: one wall meets a round soft body, which resists with the power 1.5 of its indentation.

    H. Hertz, Über die Berührung fester elastischer Körper, J. für die reine und angewandte Mathematik 92, 1882.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._chamber = int(random.integers(len(self.rig.chambers)))
        self._top = reached(self.rig, setting.path)[self._chamber]
        self._nearer = random.uniform(0.6, 1.2)
        self._stiff = random.uniform(4.0, 15.0)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        past = np.maximum(deflection[:, self._chamber] - self._top * np.exp(-strength * self._nearer), 0.0)
        root = np.zeros_like(past)  # r, of r^2 + stiff r^3 = past
        high = np.sqrt(past)
        for _ in range(30):
            middle = 0.5 * (root + high)
            less = middle**2 * (1 + self._stiff * middle) < past
            root, high = np.where(less, middle, root), np.where(less, high, middle)
        out = deflection.copy()
        out[:, self._chamber] += np.where(past > 0, high**2 - past, 0.0)
        return out


class ElasticBed(Plane):
    """Winkler's bed: markers sink into a tilted plane of springs, by a share of how far they would go behind it.

    E. Winkler, Die Lehre von der Elasticität und Festigkeit, Dominicus, Prag, 1867.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._nearer = setting.random.uniform(0.5, 1.0)
        self._sinks = setting.random.uniform(0.15, 0.5)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        rigid = super().seen(path, deflection, values, strength)
        return values + (1 - self._sinks) * (rigid - values)


class Corner(Plane):
    """Corner: two rigid planes meet at an angle, and markers stay in front of both (nearest admissible point).

    A. Klarbring, A mathematical programming approach to three-dimensional contact problems with friction, Computer
    Methods in Applied Mechanics and Engineering 58, 1986.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, random = self.rig, setting.random
        assert rig.rest_mm is not None
        aside = np.cross(self._normal, random.normal(size=3))
        turn = np.deg2rad(random.uniform(25, 60))
        self._other = np.cos(turn) * self._normal + np.sin(turn) * aside / np.linalg.norm(aside)
        met = positions(rig, rig.settled(setting.path.kpa[setting.path.row])) @ self._other
        self._other_rest_mm = float((rig.rest_mm @ self._other).max())
        self._other_gap_mm = max(float(met.max()) - self._other_rest_mm, 0.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        near = np.exp(-strength * self._nearer)
        planes = (
            (self._normal, self._rest_mm + self._gap_mm * near),
            (self._other, self._other_rest_mm + self._other_gap_mm * near),
        )
        points = positions(self.rig, values)
        for _ in range(8):
            for normal, limit_mm in planes:
                behind = np.maximum(points @ normal - limit_mm, 0.0)
                points = points - behind[..., None] * normal
        return moved(self.rig, values, points)


class StickingPlane(Plane):
    """Stick: markers that meet a plane are held where they touched it, for as long as they press against it.

    J. T. Oden, J. A. C. Martins, Models and computational methods for dynamic friction phenomena, Computer Methods in
    Applied Mechanics and Engineering 52, 1985.
    """

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        points = positions(self.rig, values)
        limit_mm = self._rest_mm + self._gap_mm * np.exp(-strength * self._nearer)
        behind = points @ self._normal - limit_mm
        touches = behind > 0
        held, before, was = points[0], points[0], np.full(points.shape[1], -1.0)
        out = points.copy()
        for t in range(len(points)):
            share = np.clip(-was / np.maximum(behind[t] - was, 1e-9), 0.0, 1.0)[
                :, None
            ]  # of the way to touching
            met = before + share * (points[t] - before)
            held = np.where((touches[t] & (was <= 0))[:, None], met, held)
            out[t] = np.where(touches[t][:, None], held, points[t])
            before, was = points[t], behind[t]
        return moved(self.rig, values, out)


class EndStop(Law):
    """End stop: the body as a whole, moving along its main way, runs against a rigid stop and stays there.

    B. Brogliato, Nonsmooth Mechanics, 3rd ed., Springer, 2016.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, path = self.rig, setting.path
        self._way = pattern(rig)
        along = (rig.settled(path.kpa[path.row]) - rig.at_rest) @ self._way
        if along.max() < -along.min():
            self._way, along = -self._way, -along
        self._top = float(along.max())
        self._nearer = setting.random.uniform(0.3, 0.7)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        past = (values - self.rig.at_rest) @ self._way - self._top * np.exp(-strength * self._nearer)
        return values - np.maximum(past, 0.0)[:, None] * self._way
