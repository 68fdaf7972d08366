"""Marker slip of the twelfth portion, of the few balls beside other sensors: at each record, and screwed on anew."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import columns, direction
from labrig.bench.development.twelfth._sensors import added, loaded, usual


class _OfOneBall(Law):
    """What both share: which ball it is, and how far it goes, as a size in mm."""

    effect = "marker_slip"
    needs = frozenset({"marker"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        where = columns(rig)
        which = int(random.choice(np.flatnonzero((where >= 0).any(axis=1))))
        self._axes = np.flatnonzero(where[which] >= 0)
        self._which = where[which][self._axes]
        self._far_mm = random.uniform(0.1, 0.25) * float(usual(rig, setting.path)[self._which].max())


class SlipsAtEachRecord(_OfOneBall):
    """Kaiser: what has borne a load once bears it again; a ball's clip gives a little only at loads never had before.

    J. Kaiser, Untersuchungen über das Auftreten von Geräuschen beim Zugversuch, Dissertation, TH München, 1950. Most of
    the way is gone early on; whenever all chambers together set a new record, it goes on.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        push = loaded(self.rig, self.rig.deflection(path.kpa))
        self._first = random.uniform(0.3, 0.6) * float(push.max())
        self._range = float(push.max()) - self._first
        self._way_mm = self._far_mm * 2.5 * direction(random)[self._axes]

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        record = np.maximum.accumulate(loaded(self.rig, deflection))
        gone = np.maximum(record - self._first, 0.0) / self._range
        return added(values, self._which, strength * gone[:, None] * self._way_mm)


class ScrewedOnAnew(_OfOneBall):
    """Screwed on anew: a ball is taken off after each session, not to be lost, and never comes back quite alike.

    U. Della Croce et al., Human movement analysis using stereophotogrammetry: Part 4, Gait and Posture 21, 2005, on how
    well markers are put back. In a single session it fell off and was put back once.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        self._fell_s = float(np.quantile(path.time_s[path.row], random.uniform(0.2, 0.75)))
        self._alone = int(path.session.max()) == 0
        count = 64
        self._at_mm = self._far_mm * random.normal(0, 1.3, (count, len(self._axes)))
        self._at_mm[0] = 0.0

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        times = (path.time_s >= self._fell_s).astype(np.int64) if self._alone else path.session
        return added(values, self._which, strength * self._at_mm[np.minimum(times, 63)])
