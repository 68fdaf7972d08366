"""Contact of the fifth portion: a loose weight that is lifted, a hose that gets taut, a pocket of air that closes."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, reached


class LiftedWeight(Law):
    """Loose weight: something heavy lies before a wall, which waits until it can carry it, and then takes it along.

    P. Varignon, Nouvelle mécanique ou statique, Jombert, Paris, 1725. A tool left on the rig does this, or a lid. The
    stronger the law, the heavier it is.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._which = random.permutation(count)[: int(random.integers(1, min(count, 2) + 1))]
        top = reached(self.rig, setting.path)[self._which]
        self._meets = top * random.uniform(0.1, 0.6, len(self._which))
        self._weighs = top * random.uniform(0.15, 0.5)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        out = deflection.copy()
        out[:, self._which] -= np.clip(out[:, self._which] - self._meets, 0.0, strength * self._weighs)
        return out


class AirCushion(Law):
    """Pocket of air: the wall closes off a pocket, whose pressure rises by Mariotte's law; it never gets through.

    E. Mariotte, De la nature de l'air, Michallet, Paris, 1679.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._which = random.permutation(count)[: int(random.integers(1, min(count, 2) + 1))]
        self._top = reached(self.rig, setting.path)[self._which]
        self._nearer = random.uniform(0.3, 0.8, len(self._which))
        self._deep = self._top * random.uniform(0.1, 0.5)
        self._presses = random.uniform(0.5, 2.0)  # against the wall's own stiffness

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        out = deflection.copy()
        past = np.maximum(out[:, self._which] - self._top * np.exp(-strength * self._nearer), 0.0)
        # x + presses deep x / (deep - x) = past
        half = 0.5 * (self._deep * (1 + self._presses) + past)
        goes = half - np.sqrt(np.maximum(half**2 - past * self._deep, 0.0))
        out[:, self._which] -= past - goes
        return out


class TautHose(Law):
    """Hose that gets taut: one place hangs on a hose, cannot go farther from its other end, and holds what is around.

    R. Featherstone, Rigid Body Dynamics Algorithms, Springer, 2008 (a constraint of one side on a distance).
    """

    effect = "contact"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, path, random, radius = self.rig, setting.path, setting.random, body_mm(self.rig)[1]
        assert rig.rest_mm is not None
        seen = positions(rig, rig.settled(path.kpa[path.row][::5]))
        away = seen - rig.rest_mm
        away_mm = np.linalg.norm(away, axis=2)
        far = np.median(away_mm, axis=0)
        held = int(random.choice(np.argsort(far)[-max(2, len(far) // 4) :]))
        often = away_mm[:, held] >= np.quantile(away_mm[:, held], 0.6)
        way = away[often, held].mean(axis=0)
        toward = way / max(float(np.linalg.norm(way)), 1e-9) + 0.5 * direction(random)
        toward /= np.linalg.norm(toward)
        self._end_mm = rig.rest_mm[held] - toward * radius * random.uniform(0.8, 2.5)
        reach_mm = np.linalg.norm(seen[:, held] - self._end_mm, axis=1)
        self._slack_mm = float(np.linalg.norm(rig.rest_mm[held] - self._end_mm))
        self._most_mm = max(float(reach_mm.max()), self._slack_mm)
        self._held, self._sooner = held, random.uniform(0.3, 0.9)
        wide_mm = radius * random.uniform(0.3, 0.7)
        self._goes = np.exp(-0.5 * np.sum((rig.rest_mm - rig.rest_mm[held]) ** 2, axis=1) / wide_mm**2)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        points = positions(self.rig, values)
        long_mm = self._slack_mm + (self._most_mm - self._slack_mm) * np.exp(-strength * self._sooner)
        ray = points[:, self._held] - self._end_mm
        away_mm = np.maximum(np.linalg.norm(ray, axis=1, keepdims=True), 1e-9)
        back = np.maximum(away_mm - long_mm, 0.0) * ray / away_mm
        return moved(self.rig, values, points - back[:, None] * self._goes[:, None])
