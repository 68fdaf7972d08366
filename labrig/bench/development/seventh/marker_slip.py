"""Marker slip of the seventh portion: a crack in the glue, and glue that is soft while it is warm."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Path, Setting
from labrig.bench.development._story import pauses
from labrig.bench.development.marker_slip import Slip


class CrackInTheGlue(Slip):
    """Crack: with each actuation it grows by a power of its length, faster and faster, until the marker hangs askew.

    P. Paris, F. Erdogan, A critical analysis of crack propagation laws, J. Basic Engineering 85, 1963.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        count = max(int(path.event.max()) + 1, 2)
        self._first = int(count * random.uniform(0.0, 0.5))
        self._cycles = max((count - self._first) * random.uniform(0.3, 0.9), 1.0)
        self._power = 2 / (random.uniform(3.0, 6.0) - 2)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        whole = 0.97
        share = np.clip((path.event - self._first) / self._cycles, 0.0, whole)
        gone = ((1 - share) ** -self._power - 1) / ((1 - whole) ** -self._power - 1)
        return values + strength * gone[:, None] * self._way_mm


class WarmGlue(Slip):
    """Warm glue: it thins exponentially as the rig warms up in a session, and the marker sinks while it is warm.

    O. Reynolds, On the theory of lubrication and its application to Mr. Beauchamp Tower's experiments, Phil. Trans.
    Royal Society 177, 1886 (viscosity and temperature).
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        self._tau_s = max(float(path.session_s[path.row].max()), 1.0) * random.uniform(0.2, 0.8)
        self._softer = random.uniform(2.0, 6.0)
        self._since_s = self._begin_s + self._length_s * random.uniform(0.0, 0.4)
        self._all = 1.0
        self._all = max(float(self._sunk(path)[path.row].max()), 1e-9)

    def _sunk(self, path: Path) -> Floats:
        """How far it has sunk at each moment (T,)."""
        warm = -np.expm1(-path.session_s / self._tau_s)
        slides = np.exp(self._softer * (warm - 1)) * (path.time_s > self._since_s)
        return np.cumsum(slides * pauses(path)) / self._all

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._sunk(path)[:, None] * self._way_mm
