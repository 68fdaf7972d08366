"""Coupling of the sixth portion: a hose that a bulge kinks, pulls at an angle, places that only three together move."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import overlap, span


class KinkedHoses(Law):
    """Kinked hose: a chamber that is far out kinks the hose of another one, which then lets through less.

    P. Rothemund, A. Ainla, L. Belding et al., A soft, bistable valve for autonomous control of soft actuators, Science
    Robotics 3, 2018. What it still lets through goes out by a bleed; it kinks within a part of the way.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        pairs = int(random.integers(1, max(2, count // 2) + 1))
        self._who = random.integers(count, size=pairs)
        self._whom = (self._who + random.integers(1, count, size=pairs)) % count
        self._at, self._wide = random.uniform(0.15, 0.6, pairs), random.uniform(0.1, 0.4, pairs)
        self._shuts = random.uniform(0.1, 0.35, pairs)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        out, way = kpa.copy(), np.abs(self.rig.deflection(kpa))
        for who, whom, at, wide, shuts in zip(
            self._who, self._whom, self._at, self._wide, self._shuts, strict=True
        ):
            part = np.clip((way[:, who] - at) / wide, 0.0, 1.0)
            out[:, whom] *= np.exp(-strength * shuts * part**2 * (3 - 2 * part))
        return out


class PullsAtAnAngle(Law):
    """Parallelogram of forces: chambers that pull aslant of each other lose by the diagonal, however hard they pull.

    P. Varignon, Projet d'une nouvelle mechanique, Paris, 1687.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, near = setting.random, overlap(self.rig)
        count = len(near)
        other = random.uniform(0.2, 1.0, near.shape)
        self._aslant = np.triu(other, 1) + np.triu(other, 1).T + np.eye(count)
        self._loses = random.uniform(0.3, 0.8) * random.uniform(0.7, 1.3, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        size = np.abs(deflection)
        both = size @ self._aslant  # own, and what the others have along it
        least = np.sqrt(size**2 @ self._aslant**2)
        lacks = 1 - (least + 1e-3) / (both + 1e-3)
        return deflection * np.exp(-strength * self._loses * lacks)


class OnlyThreeTogether(Law):
    """Interaction of the second order: a place between three bulges is closed, and lifted, only by all three at once.

    R. A. Fisher, The Design of Experiments, Oliver and Boyd, 1935. Where there are but two, by those two.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        number = int(random.integers(1, max(2, count - 1)))
        self._groups = [random.permutation(count)[: min(3, count)] for _ in range(number)]
        unit = np.eye(count)
        ways = []
        for group in self._groups:
            own = self.rig.shape(0.7 * unit[group]) - self.rig.at_rest
            way = random.normal(size=len(group)) @ own
            ways.append(way / max(float(np.sqrt(np.mean(way**2))), 1e-9))
        size = span(self.rig) * random.uniform(0.3, 0.8, number) / np.sqrt(number)
        self._ways = np.array(ways) * size[:, None]

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        closed = [np.prod(deflection[:, group], axis=1) for group in self._groups]
        return values + strength * np.stack(closed, axis=1) @ self._ways
