"""Further marker slip: peeling that gets ever faster, glue sheared by each motion, new glue, patches that come off."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Path, Setting
from labrig.bench.development._places import columns, direction, shift, span
from labrig.bench.development._story import steps
from labrig.bench.development.marker_slip import Slip


class FasterPeel(Slip):
    """Peeling front: the less of a marker still sticks the faster it peels, exponentially, until it hangs by its edge.

    K. Kendall, Thin-film peeling: the elastic term, J. Physics D: Applied Physics 8, 1975.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._at_s = self._begin_s + self._length_s * random.uniform(0.05, 0.4)
        self._takes_s = self._length_s * random.uniform(0.3, 0.55)
        self._speeds_up = random.uniform(1.5, 4.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        gone = np.clip((path.time_s - self._at_s) / self._takes_s, 0.0, 1.0)
        peeled = np.expm1(self._speeds_up * gone) / np.expm1(self._speeds_up)
        return values + strength * peeled[:, None] * self._way_mm


class ShearedGlue(Slip):
    """Ratcheting: under each motion of the skin the edge of a marker's contact slips a little, always the same way.

    R. D. Mindlin, H. Deresiewicz, Elastic spheres in contact under varying oblique forces, J. Applied Mechanics 20,
    1953.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        own = columns(self.rig)[self._marker]
        self._columns = own[own >= 0]
        self._begins = random.uniform(0.0, 0.5)
        travel = self._travel(self.rig.settled(path.kpa))
        self._before = self._begins * float(travel[-1])
        self._whole = max(float(travel[-1]) - self._before, 1e-6)

    def _travel(self, values: Floats) -> Floats:
        """How far the marker has been moved up to each moment, (T,) in mm."""
        way = values[:, self._columns] - self.rig.at_rest[self._columns]
        return np.cumsum(np.linalg.norm(steps(way), axis=1))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        slid = np.clip((self._travel(values) - self._before) / self._whole, 0.0, 1.5)
        return values + strength * slid[:, None] * self._way_mm


class GluedAgain(Slip):
    """Glued again: between two sessions (or, of a single one, in mid-campaign) a lost marker was put back beside.

    U. Della Croce, A. Leardini, L. Chiari, A. Cappozzo, Human movement analysis using stereophotogrammetry, Part 4:
    assessment of anatomical landmark misplacement, Gait and Posture 21, 2005.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        path = setting.path
        sessions = np.unique(path.session[path.row])
        if len(sessions) > 1:
            since = int(setting.random.choice(sessions[1:]))
            self._at_s = float(path.time_s[path.session == since].min())

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * (path.time_s >= self._at_s)[:, None] * self._way_mm


class PatchComesOff(Slip):
    """Debonding patch: two or three markers side by side let go one soon after the other, and shift the same way.

    C. Creton, M. Ciccotti, Fracture and adhesion of soft materials: a review, Reports on Progress in Physics 79, 2016.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, random = self.rig, setting.random
        assert rig.rest_mm is not None
        distance = np.linalg.norm(rig.rest_mm - rig.rest_mm[self._marker], axis=1)
        patch = np.argsort(distance)[: int(random.integers(2, 4))]
        way = span(rig) * random.uniform(0.25, 0.7) * direction(random)
        of = np.array([o.marker for o in rig.observables])
        self._ways_mm, self._times_s = [], []
        for order, marker in enumerate(patch):
            own = way + 0.2 * np.linalg.norm(way) * random.normal(size=3)
            self._ways_mm.append((of == marker) * shift(rig, own))
            self._times_s.append(self._at_s + order * random.uniform(0.0, 0.06) * self._length_s)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        out = values.copy()
        for way_mm, at_s in zip(self._ways_mm, self._times_s, strict=True):
            out += strength * (path.time_s >= at_s)[:, None] * way_mm
        return out
