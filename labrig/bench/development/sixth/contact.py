"""Contact of the sixth portion: a cone, a bulge that flattens, plates one behind the other, a round bar.

The stronger the law, the sooner the body meets what is in its way.
"""

from abc import abstractmethod

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, reached


class _Before(Law):
    """What the laws of walls share: which walls something is before, and how far past it they would be."""

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._which = random.permutation(count)[: int(random.integers(1, min(count, 3) + 1))]
        self._top = reached(self.rig, setting.path)[self._which]
        self._sooner = random.uniform(0.25, 0.8, len(self._which))

    @abstractmethod
    def _goes(self, past: Floats) -> Floats:
        """How far walls go that would be as far as `past` (T, W) beyond, without what is there."""

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        out = deflection.copy()
        past = np.maximum(out[:, self._which] - self._top * np.exp(-strength * self._sooner), 0.0)
        out[:, self._which] -= past - self._goes(past)
        return out


class ConeTip(_Before):
    """Cone: a wall is dented by a pointed tip, or dents what is soft by its own: the force goes with the square.

    I. N. Sneddon, The relation between load and penetration in the axisymmetric Boussinesq problem for a punch of
    arbitrary profile, Int. J. Engineering Science 3, 1965.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._sharp = setting.random.uniform(3.0, 20.0, len(self._which))

    def _goes(self, past: Floats) -> Floats:
        return 2 * past / (1 + np.sqrt(1 + 4 * self._sharp * past))


class FlattenedBulge(_Before):
    """Flattened bulge: the skin lies down on what it meets, over an ever larger area, and soon goes no higher.

    W. W. Feng, W.-H. Yang, On the contact problem of an inflated spherical nonlinear membrane, J. Applied Mechanics 40,
    1973.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._dent = self._top * setting.random.uniform(0.05, 0.3, len(self._which))

    def _goes(self, past: Floats) -> Floats:
        return -self._dent * np.expm1(-past / self._dent)


class PlatesInTurn(_Before):
    """Plates on springs: a wall runs against one after another, and each adds its spring to those before it.

    V. I. Babitsky, Theory of Vibro-Impact Systems and Applications, Springer, 1998.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        plates = int(random.integers(2, 5))
        gap = random.uniform(0.04, 0.15, (plates, len(self._which)))
        self._at = np.cumsum(gap, axis=0) - gap[0]  # how far a wall has gone when it meets each
        self._stiff = random.uniform(0.5, 2.5, gap.shape)

    def _goes(self, past: Floats) -> Floats:
        low, high = np.zeros_like(past), past
        for _ in range(30):
            middle = 0.5 * (low + high)
            pushed = np.einsum("pw,tpw->tw", self._stiff, np.maximum(middle[:, None] - self._at, 0.0))
            far = middle + pushed > past
            low, high = np.where(far, low, middle), np.where(far, middle, high)
        return 0.5 * (low + high)


class RoundBar(Law):
    """Round bar: it lies across the way of a part of the body, which gets around it, to whichever side is nearer.

    J. O. Hallquist, G. L. Goudreau, D. J. Benson, Sliding interfaces with contact-impact in large-scale Lagrangian
    computations, Computer Methods in Applied Mechanics and Engineering 51, 1985.
    """

    effect = "contact"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, path, random, radius = self.rig, setting.path, setting.random, body_mm(self.rig)[1]
        assert rig.rest_mm is not None
        away = positions(rig, rig.settled(path.kpa[path.row][::5])) - rig.rest_mm
        far_mm = np.quantile(np.linalg.norm(away, axis=2), 0.7, axis=0)
        met = int(random.choice(np.argsort(far_mm)[-max(2, len(far_mm) // 4) :]))
        often = np.linalg.norm(away[:, met], axis=1) >= np.quantile(np.linalg.norm(away[:, met], axis=1), 0.6)
        way = away[often, met].mean(axis=0)
        length = max(float(np.linalg.norm(way)), 1e-9)
        seen = np.zeros(3)
        seen[sorted({o.axis for o in rig.observables if o.axis >= 0})] = 1.0
        out = (1 - seen) if seen.sum() < 3 else direction(random)
        along = np.cross(way / length, np.cross(out, way / length))  # as square to the way as can be
        self._along = along / max(float(np.linalg.norm(along)), 1e-9)
        self._aside = np.cross(self._along, way / length)
        self._round_mm = radius * random.uniform(0.15, 0.5)
        self._from_mm, self._way = rig.rest_mm[met], way / length
        self._far_mm, self._sooner = float(far_mm[met]), random.uniform(0.3, 0.8)
        # it is as thick as it can be without touching at rest
        self._thick_mm = np.minimum(self._round_mm, self._past(rig.rest_mm[None], 0.0)[2][0])

    def _past(self, points: Floats, far_mm: float) -> tuple[Floats, Floats, Floats]:
        """How far points (T, M, 3) are before the axis (below 0) and aside of it, and from it or the way behind it."""
        ray = points - (self._from_mm + self._way * (far_mm + self._round_mm))
        before, aside = np.minimum(ray @ self._way, 0.0), ray @ self._aside
        return before, aside, np.hypot(before, aside)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        points = positions(self.rig, values)
        before, aside, away_mm = self._past(points, self._far_mm * np.exp(-strength * self._sooner))
        out = np.maximum(self._thick_mm - away_mm, 0.0) / np.maximum(away_mm, 1e-9)
        change = (out * before)[..., None] * self._way + (out * aside)[..., None] * self._aside
        return moved(self.rig, values, points + change)
