"""Contact: beyond a limit the motion is stopped; below it nothing is changed.

Limits close in as a law grows stronger: at strength 0 they lie at the farthest point that the campaign reaches.
"""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import alone, body_mm, moved, positions, reached


class HardStop(Law):
    """Signorini's contact: one or two walls meet something rigid, and go no further.

    A. Signorini, Questioni di elasticità non linearizzata e semilinearizzata, Rendiconti di Matematica 18, 1959.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._which = setting.random.permutation(count)[: int(setting.random.integers(1, 3))]
        self._top = reached(self.rig, setting.path)[self._which]
        self._nearer = setting.random.uniform(0.2, 0.45, len(self._which))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        out = deflection.copy()
        out[:, self._which] = np.minimum(out[:, self._which], self._top * np.exp(-strength * self._nearer))
        return out


class FoamStop(Law):
    """Foam pad: some walls meet a pad whose stiffness grows as it is crushed.

    L. J. Gibson, M. F. Ashby, Cellular Solids, 2nd ed., Cambridge University Press, 1997.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._which = setting.random.permutation(count)[: int(setting.random.integers(1, min(count, 4) + 1))]
        self._top = reached(self.rig, setting.path)[self._which]
        self._nearer = setting.random.uniform(0.4, 0.8, len(self._which))
        self._soft = setting.random.uniform(0.03, 0.15)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        past = np.maximum(deflection[:, self._which] - self._top * np.exp(-strength * self._nearer), 0.0)
        out = deflection.copy()
        out[:, self._which] += self._soft * np.log1p(past / self._soft) - past
        return out


class Plane(Law):
    """Rigid plane: markers that would be behind a tilted plane lie on it instead (closest-point projection).

    P. Wriggers, Computational Contact Mechanics, 2nd ed., Springer, 2006.
    """

    effect = "contact"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig = self.rig
        assert rig.rest_mm is not None
        way = positions(rig, alone(rig) + rig.at_rest) - rig.rest_mm
        far = way[np.unravel_index(np.argmax(np.sum(way**2, axis=2)), way.shape[:2])]
        normal = far / np.linalg.norm(far) + np.tan(np.deg2rad(20)) * setting.random.normal(0, 0.6, 3)
        self._normal = normal / np.linalg.norm(normal)
        met = positions(rig, rig.settled(setting.path.kpa[setting.path.row])) @ self._normal
        self._rest_mm = float((rig.rest_mm @ self._normal).max())
        self._gap_mm = max(float(met.max()) - self._rest_mm, 0.1 * float(np.linalg.norm(far)))
        self._nearer = setting.random.uniform(0.25, 0.6)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        points = positions(self.rig, values)
        limit_mm = self._rest_mm + self._gap_mm * np.exp(-strength * self._nearer)
        behind = np.maximum(points @ self._normal - limit_mm, 0.0)
        return moved(self.rig, values, points - behind[..., None] * self._normal)


class Post(Law):
    """A post with a round tip stands in the way of one part of the surface, and stops what meets it.

    N. Kikuchi, J. T. Oden, Contact Problems in Elasticity, SIAM, 1988.
    """

    effect = "contact"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig = self.rig
        assert rig.rest_mm is not None
        way = positions(rig, rig.settled(setting.path.kpa[setting.path.row])) - rig.rest_mm
        length = np.linalg.norm(way, axis=2)
        mobile = np.flatnonzero(length.max(axis=0) >= np.median(length.max(axis=0)))
        marker = int(setting.random.choice(mobile))
        far = way[np.argmax(length[:, marker]), marker]
        self._ahead = far / np.linalg.norm(far)
        self._from_mm = rig.rest_mm @ self._ahead
        beside = (
            rig.rest_mm - rig.rest_mm[marker] - np.outer(self._from_mm - self._from_mm[marker], self._ahead)
        )
        radius_mm = body_mm(rig)[1] * setting.random.uniform(0.3, 1.2)
        self._curved_mm = np.sum(beside**2, axis=1) / (2 * radius_mm)  # how far the tip has curved away, (M,)
        self._top_mm = float((way @ self._ahead - self._curved_mm).max())
        self._nearer = setting.random.uniform(0.35, 0.8)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        points = positions(self.rig, values)
        out_mm = points @ self._ahead - self._from_mm
        tip_mm = self._top_mm * np.exp(-strength * self._nearer) + self._curved_mm
        past_mm = np.maximum(out_mm - tip_mm, 0.0)
        return moved(self.rig, values, points - past_mm[..., None] * self._ahead)
