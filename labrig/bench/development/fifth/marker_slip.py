"""Marker slip of the fifth portion: one swings about a corner, one slides to an edge, one has two seats, a hand."""

import numpy as np
from scipy.spatial.transform import Rotation

from labrig.arrays import Floats
from labrig.bench._nature import Path, Setting
from labrig.bench.development._places import direction, shift, span
from labrig.bench.development.marker_slip import Slip


class SwingsAboutCorner(Slip):
    """Swings about a corner: one corner of a marker still holds, and it sinks about it along an arc until it hangs.

    C. Huygens, Horologium Oscillatorium, Muguet, Paris, 1673 (a heavy pendulum in a thick medium: its half angle's
    tangent fades exponentially).
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._at_s = self._begin_s + self._length_s * random.uniform(0.1, 0.6)
        self._tau_s = self._length_s * random.uniform(0.04, 0.25)
        self._first_rad = random.uniform(0.7, 2.6)
        self._arm = direction(random)
        about = np.cross(self._arm, direction(random))
        self._about = about / np.linalg.norm(about)
        self._long_mm = span(self.rig) * random.uniform(0.3, 0.8)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        late = np.maximum(path.time_s - self._at_s, 0.0) / self._tau_s
        left_rad = 2 * np.arctan(np.tan(0.5 * self._first_rad) * np.exp(-late))
        turned = Rotation.from_rotvec((self._first_rad - left_rad)[:, None] * self._about).apply(self._arm)
        return values + strength * self._long_mm * self._own * shift(self.rig, turned - self._arm)


class SlidesToEdge(Slip):
    """Slide at an even pace: from a moment on wet glue lets a marker slide evenly, until it meets an edge and stays.

    M. M. Couette, Études sur le frottement des liquides, Annales de chimie et de physique 21, 1890.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._at_s = self._begin_s + self._length_s * setting.random.uniform(0.1, 0.6)
        self._takes_s = self._length_s * setting.random.uniform(0.05, 0.35)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        gone = np.clip((path.time_s - self._at_s) / self._takes_s, 0.0, 1.0)
        return values + strength * gone[:, None] * self._way_mm


class TwoSeats(Slip):
    """Two seats: a loose pin sits in one of two places, and some actuations knock it over into the other one.

    H. A. Kramers, Brownian motion in a field of force and the diffusion model of chemical reactions, Physica 7, 1940.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        first = int(random.integers(3, max(4, int(setting.path.event.max()) // 2)))
        goes = random.random(2003) < random.uniform(0.04, 0.2)
        goes[: first + 1] = np.arange(first + 1) == first
        self._over = np.cumsum(goes) % 2

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        over = self._over[path.event % len(self._over)]
        return values + strength * over[:, None] * self._way_mm


class KnockedByHand(Slip):
    """Knocked by a hand: at one moment two or three markers anywhere on the body are shifted, each its own way.

    From laboratory experience; the estimate of such steps is that of R. H. Jones, D. H. Crowell, L. E. Kapuniai, Change
    detection model for serially correlated multivariate data, Biometrics 26, 1970.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        which = random.permutation(len(self.rig.marker_names))[: int(random.integers(2, 4))]
        for marker in which.tolist():
            self._own = np.array([o.marker == marker for o in self.rig.observables], dtype=float)
            self._way_mm = self._way_mm + self._way()

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * (path.time_s >= self._at_s)[:, None] * self._way_mm
