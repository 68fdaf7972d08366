"""Tension of the eleventh portion: one skin whose tension is the same all along, and a seam that runs straight."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import columns, moved, positions, reached


class OneTensionAllAlong(Law):
    """One tension all along: a skin that slides freely has one tension, set by how much longer all of it has become.

    G. F. Carrier, On the non-linear vibration problem of the elastic string, Quarterly of Applied Mathematics 3, 1945,
    after Kirchhoff: the tension is what it was mounted with, and the mean of the squared slopes. The skin was mounted
    tighter than modelled, which holds each chamber back the most while all others are empty too.
    """

    effect = "tension"
    needs = frozenset({"several", "curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tight = random.uniform(0.25, 0.7) * random.uniform(0.85, 1.15, count)
        self._spans = random.dirichlet(np.full(count, 6.0))  # how much of the skin each chamber lifts
        self._longer = random.uniform(1.5, 6.0)  # the tension when all are at their largest deflection
        self._far = reached(self.rig, setting.path)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        stretched = self._longer * ((deflection / self._far) ** 2 @ self._spans)[:, None]
        return deflection * (1 + stretched) / (1 + stretched + strength * self._tight)


class TightSeam(Law):
    """Tight seam: a seam sewn with too tight a thread stays the chord between its ends, and what is near stays too.

    M. Hetényi, Beams on Elastic Foundation, University of Michigan Press, 1946: what a line holds is felt beside it by
    an exponential of the distance, whose width goes with the root of the tension. Only motion across the seam is held;
    as the seam gets longer the thread's own stretch takes over, and what was sewn in counts less.
    """

    effect = "tension"
    needs = frozenset({"markers", "curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        rest = rig.rest_mm
        seen = np.flatnonzero((columns(rig) >= 0).any(axis=1))
        first = int(random.choice(seen))
        apart = np.linalg.norm(rest - rest[first], axis=1)
        far = seen[apart[seen] >= np.quantile(apart[seen], 0.6)]
        last = int(random.choice(far[apart[far] > 0]))
        self._ends = first, last
        way = rest[last] - rest[first]
        long_mm = float(np.linalg.norm(way))
        self._along = way / long_mm
        self._place = np.clip((rest - rest[first]) @ way / long_mm**2, 0.0, 1.0)[:, None]
        self._beside_mm = np.linalg.norm(rest - rest[first] - self._place * way, axis=1)
        self._wide_mm = random.uniform(0.15, 0.4) * long_mm
        self._tight = random.uniform(0.4, 1.0)
        off = self._off(positions(rig, rig.settled(setting.path.kpa[setting.path.row])))
        self._fades_mm = random.uniform(1.0, 2.5) * max(float(np.sqrt(np.mean(off**2))), 1e-6 * long_mm)

    def _off(self, points_mm: Floats) -> Floats:
        """How far (T, M, 3) each place has left the chord of the seam, across it."""
        assert self.rig.rest_mm is not None
        gone = points_mm - self.rig.rest_mm
        one, other = gone[:, self._ends[0], None], gone[:, self._ends[1], None]
        off = gone - (one + self._place * (other - one))
        return off - (off @ self._along)[..., None] * self._along

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points_mm = positions(self.rig, values)
        off = self._off(points_mm)
        tight = strength * self._tight
        felt = np.exp(-self._beside_mm / (self._wide_mm * np.sqrt(1 + tight)))
        far_mm = np.sqrt(np.sum(felt[:, None] * off**2, axis=(1, 2)) / np.sum(felt))[:, None]
        held = felt * tight / (1 + tight + (far_mm / self._fades_mm) ** 2)
        return moved(self.rig, values, points_mm - held[..., None] * off)
