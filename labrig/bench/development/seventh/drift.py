"""Drift of the seventh portion: a laser that hops from mode to mode, and a wet body that dries."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, pattern, shift, span, spread


class LaserHopsModes(Law):
    """Laser that hops: as its diode warms, its zero runs away evenly, and jumps back each time it changes its mode.

    C. E. Wieman, L. Hollberg, Using diode lasers for atomic physics, Review of Scientific Instruments 62, 1991.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, seen_s = setting.random, setting.path.time_s[setting.path.row]
        self._begin_s = float(seen_s.min())
        self._every_s = max(float(np.ptp(seen_s)), 1.0) / random.uniform(1.3, 4.5)
        self._first, self._back = random.uniform(0.0, 1.0), random.uniform(0.7, 1.0)
        self._way = shift(self.rig, span(self.rig) * random.uniform(0.3, 0.8) * direction(random))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        phase = (path.time_s - self._begin_s) / self._every_s + self._first
        off = phase - self._first - self._back * (np.floor(phase) - np.floor(self._first))
        return values + strength * off[:, None] * self._way


class DriesOut(Law):
    """Drying: a wet body loses water evenly while its skin is wet, and then ever more slowly, and shrinks by it.

    T. K. Sherwood, The drying of solids, Industrial and Engineering Chemistry 21, 1929. Where there are no markers the
    zero goes the way that pressure would take it, backwards.
    """

    effect = "drift"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, random, seen_s = self.rig, setting.random, setting.path.time_s[setting.path.row]
        self._begin_s, long_s = float(seen_s.min()), max(float(np.ptp(seen_s)), 1.0)
        self._wet_s = long_s * random.uniform(0.15, 0.6)
        self._tau_s = long_s * random.uniform(0.1, 0.5)
        if rig.rest_mm is not None:
            centre, radius = body_mm(rig)
            foot_mm = centre + radius * random.uniform(0.3, 1.0) * direction(random)
            way = spread(rig, (foot_mm - rig.rest_mm) / radius)
        else:
            way = -np.sqrt(len(rig.observables)) * pattern(rig)
        self._way = span(rig) * random.uniform(0.2, 0.5) * way

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        late = np.maximum(path.time_s - self._begin_s, 0.0)
        slow = self._tau_s * -np.expm1(-np.maximum(late - self._wet_s, 0.0) / self._tau_s)
        gone = (np.minimum(late, self._wet_s) + slow) / (self._wet_s + self._tau_s)
        return values + strength * gone[:, None] * self._way
