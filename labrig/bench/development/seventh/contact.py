"""Contact of the seventh portion: a rubber buffer that is flattened, and a prop under a body that is clamped elsewhere.

The stronger the law, the sooner the body meets what is in its way.
"""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import compliance, long_axis, moved, positions, reached


class RubberBuffer(Law):
    """Rubber buffer: it resists by one over the square of what is left of its height, less that, and is never flat.

    L. R. G. Treloar, The Physics of Rubber Elasticity, Clarendon Press, 1949. Some walls have one before them.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._which = random.permutation(count)[: int(random.integers(1, min(count, 4) + 1))]
        self._top = reached(self.rig, setting.path)[self._which]
        self._sooner = random.uniform(0.25, 0.8, len(self._which))
        self._high = random.uniform(0.15, 0.6, len(self._which))
        self._stiff = random.uniform(0.6, 4.0, len(self._which))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        out = deflection.copy()
        past = np.maximum(out[:, self._which] - self._top * np.exp(-strength * self._sooner), 0.0)
        low, high = np.zeros_like(past), np.minimum(past, 0.99 * self._high)
        for _ in range(32):
            middle = 0.5 * (low + high)
            left = 1 - middle / self._high
            far = middle + self._stiff * self._high / 3 * (left**-2 - left) > past
            low, high = np.where(far, low, middle), np.where(far, middle, high)
        out[:, self._which] -= past - 0.5 * (low + high)
        return out


class PropUnderIt(Law):
    """Propped cantilever: one place meets a prop, which bends the clamped body back, by a cubic up to there.

    S. Timoshenko, Strength of Materials, Van Nostrand, 1930. Beyond the prop the body goes on straight.
    """

    effect = "contact"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, path, random = self.rig, setting.path, setting.random
        assert rig.rest_mm is not None
        along, gives = long_axis(rig)[1], compliance(rig)
        x = along if gives[along > 0.5].mean() >= gives[along <= 0.5].mean() else 1 - along
        moves = positions(rig, rig.settled(path.kpa[path.row][::3])) - rig.rest_mm
        far_mm = np.linalg.norm(moves, axis=2).max(axis=0)
        self._met = int(random.choice(np.argsort(far_mm * (x > 0.3))[-max(2, len(x) // 3) :]))
        own = moves[:, self._met]
        way = own[np.linalg.norm(own, axis=1) >= 0.7 * far_mm[self._met]].mean(axis=0)
        self._way = way / max(float(np.linalg.norm(way)), 1e-9)
        self._far_mm = max(float((own @ self._way).max()), 1e-9)
        self._from_mm = positions(rig, rig.at_rest[None])[0, self._met]
        at = max(float(x[self._met]), 0.2)
        self._bends = np.where(x < at, x**2 * (3 * at - x) / (2 * at**3), (3 * x - at) / (2 * at))
        self._stiff, self._sooner = random.uniform(0.6, 1.0), random.uniform(0.3, 0.8)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        points = positions(self.rig, values)
        over = (points[:, self._met] - self._from_mm) @ self._way - self._far_mm * np.exp(
            -strength * self._sooner
        )
        back = self._stiff * np.maximum(over, 0.0)
        return moved(self.rig, values, points - back[:, None, None] * self._bends[:, None] * self._way)
