"""Contacts of the ninth portion: end stops, Hertz's pads, a spring before the whole, a wall, and a bed."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import (
    columns,
    direction,
    moved,
    pattern,
    positions,
    reached,
    some,
)


class AdjustableEndStop(Law):
    """An end stop: it lets nothing pass, and presses only; some chambers have one.

    A. Signorini, Questioni di elasticità non linearizzata e semilinearizzata, Rendiconti di Matematica 18,
    1959: gap and force are never negative, and one of them is zero. Strength brings the stop nearer from the
    farthest reach.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._reach = reached(self.rig, setting.path)
        self._nearer = some(random, len(self._reach), 0.12, 0.2, 0.7)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        gap = self._reach * np.maximum(1 - strength * self._nearer, 0.05)
        has = (self._nearer > 0) & (strength > 0)
        return np.where(has, np.minimum(deflection, gap), deflection)


class HertzPad(Law):
    """Hertz's pads: each chamber's round top is pressed flat on a pad, with the power 3/2 of the approach.

    H. Hertz, Über die Berührung fester elastischer Körper, J. reine und angewandte Mathematik 92, 1882: F =
    4/3 E* sqrt(R) d^(3/2). The wall as a spring of its own balances it; strength multiplies E*.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._reach = reached(self.rig, setting.path)
        self._gap = random.uniform(0.35, 0.6) * random.uniform(0.85, 1.15, count)
        self._stiff = random.uniform(0.8, 1.6) * random.uniform(0.8, 1.2, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        free = np.maximum(deflection / self._reach - self._gap, 0.0)  # beyond the pad, were it not there
        stiff = strength * self._stiff
        into = free.copy()
        for _ in range(12):  # Newton's method for into + stiff into^1.5 = free
            root = np.sqrt(into)
            into = np.maximum((free + 0.5 * stiff * into * root) / (1 + 1.5 * stiff * root), 0.0)
        return deflection - self._reach * (free - into)


class SpringBeforeTheWhole(Law):
    """A spring before the whole: once the body has come so far, a penalty spring holds it back as one.

    P. Wriggers, Computational Contact Mechanics, Wiley, 2002: the force is the penalty times the penetration,
    shared between spring and body by their stiffness; strength multiplies that of the spring.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._way = pattern(rig)
        far = (rig.settled(setting.path.kpa) - rig.at_rest) @ self._way
        if far.max() < -far.min():  # it draws in more than it is let out
            self._way, far = -self._way, -far
        self._gap = random.uniform(0.4, 0.65) * far.max()
        self._penalty = random.uniform(0.25, 0.5)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        over = np.maximum((values - self.rig.at_rest) @ self._way - self._gap, 0.0)
        stiff = strength * self._penalty
        return values - (stiff / (1 + stiff) * over)[:, None] * self._way


class WallInSpace(Law):
    """A wall in space: places that reach it slide along it and do not go through, all others are free.

    N. Kikuchi, J. T. Oden, Contact Problems in Elasticity, SIAM, 1988, on rigid foundations without friction.
    It stands where the body comes out farthest; strength brings it nearer from the farthest reach.
    """

    effect = "contact"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        measured = (columns(rig) >= 0).any(axis=0)
        points = positions(rig, rig.settled(setting.path.kpa))
        best = -np.inf
        for _ in range(24):
            way = direction(random) * measured
            way = way / max(float(np.linalg.norm(way)), 1e-9)
            top = float((points @ way).max())
            out = top - float((rig.rest_mm @ way).max())
            if out > best:
                best, self._normal, self._top = out, way, top
        self._nearer_mm = random.uniform(0.12, 0.2) * best
        self._least_mm = self._top - 0.95 * best

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        points = positions(self.rig, values)
        wall = max(self._top - strength * self._nearer_mm, self._least_mm)
        over = np.maximum(points @ self._normal - wall, 0.0)
        return moved(self.rig, values, points - over[..., None] * self._normal)


class BedOfSprings(Law):
    """A bed of springs: each place that comes down on it has a spring of its own.

    E. Winkler, Die Lehre von der Elasticität und Festigkeit, Dominicus, Prag, 1867. It lies across the axis
    along which the body moves most, uneven, under some of the places.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        count = len(rig.observables)
        far = rig.settled(setting.path.kpa) - rig.at_rest
        up, down = far.max(axis=0), -far.min(axis=0)
        axis = np.array([observable.axis for observable in rig.observables])
        side = np.where(up >= down, 1.0, -1.0)
        under = random.random(count) < random.uniform(0.5, 0.9)
        if axis.max() >= 0:
            size = [np.sum(far[:, axis == a] ** 2) for a in range(3)]
            most = int(np.argmax(size))
            side[:] = 1.0 if up[axis == most].sum() >= down[axis == most].sum() else -1.0
            under &= axis == most
            under[random.choice(np.flatnonzero(axis == most))] = True
        under[np.argmax(np.where(under, np.maximum(up, down), -1.0))] = True
        self._side = side
        self._gap = random.uniform(0.4, 0.6) * random.uniform(0.85, 1.15, count) * np.maximum(up, down)
        self._stiff = np.where(under, random.uniform(0.4, 0.9) * random.uniform(0.7, 1.3, count), 0.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        over = np.maximum(self._side * (values - self.rig.at_rest) - self._gap, 0.0)
        stiff = strength * self._stiff
        return values - self._side * stiff / (1 + stiff) * over
