"""Marker slip of the fourth portion: one that hangs loose, one that slips in avalanches, one whose tape bubbles."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Path, Setting
from labrig.bench.development.marker_slip import Slip


class HangsLoose(Slip):
    """Loose marker: from a moment on it sits a little beside its place, and follows what is under it only in part.

    A. Leardini, L. Chiari, U. Della Croce, A. Cappozzo, Human movement analysis using stereophotogrammetry, Part 3:
    soft tissue artifact assessment and compensation, Gait and Posture 21, 2005.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._lags = setting.random.uniform(0.2, 0.6)
        self._at_s = self._begin_s + self._length_s * setting.random.uniform(0.15, 0.6)
        self._way_mm = 0.5 * self._way_mm

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        lost = -np.expm1(-strength * self._lags) * self._own * (values - self.rig.at_rest)
        return values + (path.time_s >= self._at_s)[:, None] * (strength * self._way_mm - lost)


class SlipsInAvalanches(Slip):
    """Avalanches: each actuation lets a marker slip, mostly by next to nothing and seldom far (a power law of sizes).

    R. Burridge, L. Knopoff, Model and theoretical seismicity, Bulletin of the Seismological Society of America 57,
    1967.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        size = np.minimum((1 - random.random(2003)) ** (-1 / random.uniform(0.7, 1.2)), 60.0)
        first = int(random.integers(2, 12))
        self._gone = np.cumsum(np.where(np.arange(len(size)) < first, 0.0, size))
        self._gone /= max(float(self._gone[min(int(setting.path.event.max()), 2002)]), 1e-9)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        gone = np.minimum(self._gone[np.minimum(path.event, len(self._gone) - 1)], 1.5)
        return values + strength * gone[:, None] * self._way_mm


class BubblesUnderTape(Slip):
    """Avrami: bubbles under a tape begin and grow until they meet; what they lift makes the marker slide, in an S.

    M. Avrami, Kinetics of phase change I: general theory, J. Chemical Physics 7, 1939.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._at_s = self._begin_s + self._length_s * random.uniform(0.05, 0.4)
        self._tau_s = self._length_s * random.uniform(0.15, 0.4)
        self._power = random.uniform(2.0, 4.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        lifted = -np.expm1(-((np.maximum(path.time_s - self._at_s, 0.0) / self._tau_s) ** self._power))
        return values + strength * lifted[:, None] * self._way_mm
