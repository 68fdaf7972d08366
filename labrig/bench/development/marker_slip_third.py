"""Marker slip of the third portion: sagging tape, slips at large motions, a turned plate, one pushed aside."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Path, Setting
from labrig.bench.development._places import columns, direction, shift, span, spread
from labrig.bench.development._story import steps
from labrig.bench.development.marker_slip import Slip


class SaggingTape(Slip):
    """Shear creep of a tape: from a moment on a marker slides with a power of the time since then, and never rests.

    D. Satas (ed.), Handbook of Pressure Sensitive Adhesive Technology, 2nd ed., Van Nostrand Reinhold, 1989.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._at_s = self._begin_s + self._length_s * setting.random.uniform(0.1, 0.6)
        self._power = setting.random.uniform(0.35, 0.8)
        self._whole_s = max(self._begin_s + self._length_s - self._at_s, 1.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        gone = (np.maximum(path.time_s - self._at_s, 0.0) / self._whole_s) ** self._power
        return values + strength * gone[:, None] * self._way_mm


class SlipsAtLargeMotions(Slip):
    """Gross slip: the glue holds at small motions, and gives a little at each that passes what its friction can carry.

    R. D. Mindlin, Compliance of elastic bodies in contact, J. Applied Mechanics 16, 1949.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        own = columns(self.rig)[self._marker]
        self._columns = own[own >= 0]
        quick = self._quick(self.rig.settled(path.kpa))
        moves = quick[quick > 1e-9]
        self._carries = float(np.quantile(moves, random.uniform(0.9, 0.975))) if moves.size else 1.0
        self._whole = max(float(self._over(quick)[-1]), 1e-9)

    def _quick(self, values: Floats) -> Floats:
        """How far the marker moves from moment to moment, (T,) in mm."""
        return np.linalg.norm(steps(values[:, self._columns] - self.rig.at_rest[self._columns]), axis=1)

    def _over(self, quick: Floats) -> Floats:
        return np.cumsum(np.maximum(quick - self._carries, 0.0))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        slid = np.minimum(self._over(self._quick(values)) / self._whole, 1.5)
        return values + strength * slid[:, None] * self._way_mm


class TurnedPlate(Slip):
    """Marker plate: three or four markers on one plate turn together about its middle when it is knocked.

    A. Cappozzo, A. Cappello, U. Della Croce, F. Pensalfini, Surface-marker cluster design criteria for 3-D bone
    movement reconstruction, IEEE Trans. Biomedical Engineering 44, 1997.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rest = setting.random, self.rig.rest_mm
        assert rest is not None
        near = np.argsort(np.linalg.norm(rest - rest[self._marker], axis=1))[: int(random.integers(3, 5))]
        arm = np.zeros_like(rest)
        arm[near] = rest[near] - rest[near].mean(axis=0)
        arm /= max(float(np.sqrt(np.mean(arm[near] ** 2))), 1e-9)
        way_mm = span(self.rig) * random.uniform(0.15, 0.4) * np.cross(direction(random), arm)
        way_mm[near] += span(self.rig) * random.uniform(0.0, 0.15) * direction(random)
        self._way_mm = spread(self.rig, way_mm)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * (path.time_s >= self._at_s)[:, None] * self._way_mm


class PushedAside(Slip):
    """Transient change: a hose pushes a marker aside for a while; let go, it comes back most of the way, but not all.

    C. Chen, L.-M. Liu, Joint estimation of model parameters and outlier effects in time series, J. American Statistical
    Association 88, 1993.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._at_s = self._begin_s + self._length_s * random.uniform(0.1, 0.5)
        self._until_s = self._at_s + self._length_s * random.uniform(0.2, 0.4)
        self._way_mm = 1.3 * self._way_mm
        self._stays_mm = random.uniform(0.2, 0.5) * self._way_mm + self._own * shift(
            self.rig, 0.1 * span(self.rig) * direction(random)
        )

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        pushed = ((path.time_s >= self._at_s) & (path.time_s < self._until_s))[:, None] * self._way_mm
        return values + strength * (pushed + (path.time_s >= self._until_s)[:, None] * self._stays_mm)
