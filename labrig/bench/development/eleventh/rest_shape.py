"""Rest shapes of the eleventh portion: a body that is thick in the middle, and one that ties have drawn in."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Rig, Setting
from labrig.bench.development._places import body_mm, direction, long_axis, span, spread

_MARKERS = frozenset({"markers"})


def _outwards(rig: Rig, random: np.random.Generator) -> Floats:
    """Where outwards is at each marker (M, 3), the longer the further from the long axis; of length 1 on average.

    Markers on one line are all on the same side of the body.
    """
    assert rig.rest_mm is not None
    axis, _ = long_axis(rig)
    centre, radius_mm = body_mm(rig)
    arm = rig.rest_mm - centre
    out = arm - (arm @ axis)[:, None] * axis
    side = direction(random)
    side -= (side @ axis) * axis
    size = np.sqrt(np.mean(np.sum(out**2, axis=1)))
    if size < 0.03 * radius_mm:
        return np.broadcast_to(side / np.linalg.norm(side), out.shape)
    return out / size


class Barrelled(Law):
    """Barrelled: the mould gave way between its ends, or the rubber shrank there: thick, or thin, in the middle.

    ISO 12180-1, Geometrical product specifications: Cylindricity, 2011, where barrel and hourglass are among the forms
    that a cylinder may wrongly have. Its radius is a parabola along the body, and right where the ends were held.
    """

    effect = "rest_shape"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        _, along = long_axis(self.rig)
        skewed = along ** np.exp(random.normal(0, 0.3))  # the thickest place is seldom just in the middle
        thicker = 4 * skewed * (1 - skewed) - random.uniform(0.0, 0.15)
        off = spread(self.rig, thicker[:, None] * _outwards(self.rig, random))
        size = max(float(np.sqrt(np.mean(off**2))), 1e-12)
        self._off = random.choice([1.0, -1.0]) * random.uniform(0.2, 0.4) * span(self.rig) * off / size

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._off


class CinchedByTies(Law):
    """Cinched by ties: cable ties that hold hoses or a sleeve draw the body in, and beside each it bulges a little.

    S. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells, McGraw-Hill, 1959, on a ring of load on a
    cylinder: exp(-x) (cos x + sin x) on both sides. Each tie is as tight as somebody happened to pull it, and tighter
    beside its lock.
    """

    effect = "rest_shape"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        _, along = long_axis(self.rig)
        out = _outwards(self.rig, random)
        field = np.zeros_like(out)
        for at in random.uniform(0.05, 0.95, int(random.integers(1, 4))):
            x = random.uniform(5.0, 12.0) * np.abs(along - at)
            lock = 1 + 0.4 * out @ direction(random)
            tight = random.uniform(0.5, 1.5) * np.exp(-x) * (np.cos(x) + np.sin(x))
            field -= (tight * lock)[:, None] * out
        off = spread(self.rig, field)
        size = max(float(np.sqrt(np.mean(off**2))), 1e-12)
        self._off = random.uniform(0.2, 0.4) * span(self.rig) * off / size

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._off
