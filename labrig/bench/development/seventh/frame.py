"""Frames of the seventh portion: registered by three bad targets, and scanned along a bowed rail."""

import numpy as np
from scipy.spatial.transform import Rotation

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, span


class ThreeBadTargets(Law):
    """Three bad targets: the frame is laid through three or four targets, each a little beside where it is said to be.

    K. S. Arun, T. S. Huang, S. D. Blostein, Least-squares fitting of two 3-D point sets, IEEE Trans. Pattern Analysis
    and Machine Intelligence 9, 1987.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        count = int(random.integers(3, 5))
        around = 2 * np.pi * np.arange(count) / count + random.uniform(0, 0.8, count)
        level = np.column_stack([np.cos(around), np.sin(around), random.uniform(-0.3, 0.3, count)])
        first = np.array([0.0, 0.0, random.uniform(-1.5, 0.5)])
        self._said_mm = centre + radius * (random.uniform(1.0, 2.0, (count, 1)) * level + first)
        self._off_mm = span(self.rig) * random.uniform(0.1, 0.3) * random.normal(size=(count, 3))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        there = self._said_mm + strength * self._off_mm
        middle, other = self._said_mm.mean(axis=0), there.mean(axis=0)
        turn = Rotation.align_vectors(there - other, self._said_mm - middle)[0].as_matrix()
        points = positions(self.rig, values)
        return moved(self.rig, values, other + (points - middle) @ turn.T)


class BowedRail(Law):
    """Abbe: a scanner's carriage leans on its bowed rail, and is wrong by that angle times its distance from it.

    E. Abbe, Messapparate für Physiker, Zeitschrift für Instrumentenkunde 10, 1890. Square to the rail it is wrong by
    the bow itself, a parabola.
    """

    effect = "frame"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        self._along = direction(random)
        bows = np.cross(self._along, direction(random))
        self._bows = bows / np.linalg.norm(bows)
        far, aside = random.uniform(1.0, 3.0), random.uniform(1.5, 3.0)
        self._rail_mm = centre + radius * (aside * self._along - far * self._bows)
        self._bow = span(self.rig) / radius * random.uniform(0.05, 0.2) / (radius * far)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        ray = points - self._rail_mm
        gone, away = (ray @ self._along)[..., None], (ray @ self._bows)[..., None]
        change = gone * away * self._along - 0.5 * gone**2 * self._bows
        return moved(self.rig, values, points + strength * self._bow * change)
