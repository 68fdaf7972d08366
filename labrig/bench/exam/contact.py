"""Contact: something is in the way of a motion that goes far."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.exam.tools import Body, chosen


class HertzBarrier(Law):
    """Some walls press on a round barrier: a force by the power 3/2 of the indentation pushes them back.

    H. Hertz, Journal fuer die reine und angewandte Mathematik, 1882; K. L. Johnson, Contact Mechanics, 1985.
    """

    effect: ClassVar[str] = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, setting.rig
        self._top = np.maximum(rig.deflection(setting.path.kpa).max(axis=0), 1e-3)
        self._depth = random.uniform(0.3, 0.6) * random.uniform(0.8, 1.2, len(rig.chambers))
        self._touched = chosen(random, len(rig.chambers), random.uniform(0.3, 0.8))
        self._stiffness = random.uniform(4, 20)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """The walls at the balance of the barrier's force and their own."""
        if strength == 0:
            return deflection
        over = np.maximum(deflection - self._top / (1 + self._depth * strength), 0.0) * self._touched
        root = np.sqrt(over)
        for _ in range(6):
            rest = self._stiffness * root**3 + root**2 - over
            root = root - rest / np.maximum(3 * self._stiffness * root**2 + 2 * root, 1e-9)
        return deflection - (over - root**2)


class CylinderWall(Law):
    """A smooth cylindrical wall around the body, one clearance away: markers that reach it are pushed back inwards.

    M. Ciavarella and P. Decuzzi, International Journal of Solids and Structures, 2001 (conforming cylinders).
    """

    effect: ClassVar[str] = "contact"
    needs: ClassVar[frozenset[str]] = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._body = body = Body(setting.rig)
        moved = body.moved(setting.rig.settled(setting.path.kpa[setting.path.row]))
        towards = np.linalg.svd(moved.reshape(-1, 3), full_matrices=False)[2][0]
        towards = towards if (moved @ towards).sum() > 0 else -towards
        axes = body.principal
        self._along = axes[np.argmin(np.abs(axes @ towards))]
        self._seat = body.centre - towards * setting.random.uniform(1.5, 3.0) * body.size
        out = self._out(moved)[0]
        self._top = max(float(out.max()), 1e-6)
        self._depth = setting.random.uniform(0.4, 0.8)
        away = np.linalg.norm(body.rest[:, None] - body.rest[None], axis=2) / body.size
        spread = np.exp(-((away / setting.random.uniform(0.2, 0.5)) ** 2))
        self._spread = spread / spread.sum(axis=1, keepdims=True)

    def _out(self, moved: Floats) -> tuple[Floats, Floats]:
        """How far each marker is outside the rest shape, (T, M), and the way out, (T, M, 3)."""
        flat = np.eye(3) - np.outer(self._along, self._along)
        rest = (self._body.rest - self._seat) @ flat
        arm = rest + moved @ flat
        far = np.linalg.norm(arm, axis=-1)
        return far - np.linalg.norm(rest, axis=-1), arm / np.maximum(far, 1e-9)[..., None]

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """The markers, pushed back by the wall together with what is near them."""
        if strength == 0:
            return values
        out, way = self._out(self._body.moved(values))
        over = np.maximum(out - self._top / (1 + self._depth * strength), 0.0)
        return self._body.shifted(values, -(over @ self._spread.T)[..., None] * way)


class TwoChamberStop(Law):
    """A one-sided stop for two chambers together: their walls share a gap, and push each other back once it is full.

    N. Kikuchi and J. T. Oden, Contact Problems in Elasticity, SIAM, 1988 (unilateral constraint of Signorini).
    """

    effect: ClassVar[str] = "contact"
    needs: ClassVar[frozenset[str]] = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, setting.rig
        order = random.permutation(len(rig.chambers))
        self._pairs = order[: 2 * max(1, len(order) // 4)].reshape(-1, 2)
        reach = rig.deflection(setting.path.kpa)
        self._top = np.maximum(reach[:, self._pairs].sum(axis=2).max(axis=0), 1e-3)
        self._depth = random.uniform(0.4, 0.9)
        self._share = random.uniform(0.35, 0.65, len(self._pairs))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """The walls of each pair, both pushed back by what is too much for the gap."""
        if strength == 0:
            return deflection
        after = deflection.copy()
        for (first, second), top, share in zip(self._pairs, self._top, self._share, strict=True):
            over = np.maximum(
                deflection[:, first] + deflection[:, second] - top / (1 + self._depth * strength), 0.0
            )
            after[:, first] -= share * over
            after[:, second] -= (1 - share) * over
        return after
