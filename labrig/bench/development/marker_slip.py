"""Marker slip: one marker moves on the surface, at a moment of the campaign."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import direction, shift, span


class Slip(Law):
    """What the laws below share: which marker slips, when, and where to at first."""

    effect = "marker_slip"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, path, self._random = setting.rig, setting.path, setting.random
        self._marker = int(self._random.integers(len(rig.marker_names)))
        self._own = np.array([o.marker == self._marker for o in rig.observables], dtype=float)
        seen_s = path.time_s[path.row]
        self._begin_s, self._length_s = float(seen_s.min()), float(np.ptp(seen_s))
        self._at_s = self._begin_s + self._length_s * self._random.uniform(0.2, 0.8)
        self._way_mm = self._way()

    def _way(self) -> Floats:
        """Where the marker goes to, (K,) in mm."""
        length_mm = span(self.rig) * self._random.uniform(0.3, 1.0)
        return self._own * shift(self.rig, length_mm * direction(self._random))


class Jump(Slip):
    """Level shift: a marker is knocked off at one moment and sits elsewhere ever after.

    R. S. Tsay, Outliers, level shifts, and variance changes in time series, J. Forecasting 7, 1988.
    """

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * (path.time_s >= self._at_s)[:, None] * self._way_mm


class SlidingGlue(Slip):
    """Yielding glue: from a moment on a marker slides away, fast at first, until it sticks again.

    C. Creton, Pressure-sensitive adhesives: an introductory course, MRS Bulletin 28, 2003.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._tau_s = self._length_s * setting.random.uniform(0.03, 0.2)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        gone = -np.expm1(-np.maximum(path.time_s - self._at_s, 0.0) / self._tau_s)
        return values + strength * gone[:, None] * self._way_mm


class StickSlip(Slip):
    """Stick-slip peeling: the same marker comes off in two steps, the second one otherwise directed.

    A. N. Gent, R. P. Petrich, Adhesion of viscoelastic materials to rigid substrates, Proc. Royal Society A 310, 1969.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._at_s = self._begin_s + self._length_s * setting.random.uniform(0.1, 0.45)
        self._again_s = self._at_s + self._length_s * setting.random.uniform(0.2, 0.45)
        self._further_mm = self._way()

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        first = (path.time_s >= self._at_s)[:, None] * self._way_mm
        return values + strength * (first + (path.time_s >= self._again_s)[:, None] * self._further_mm)
