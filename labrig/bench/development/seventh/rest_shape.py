"""Rest shapes of the seventh portion: mould halves that were shifted, and a core that shows through the skin."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Setting
from labrig.bench.development._places import body_mm, direction
from labrig.bench.development.rest_shape import Offset


class ShiftedHalves(Offset):
    """Shifted halves: what was cast in two halves is sheared at the parting plane, by an arctangent of the distance.

    J. C. Savage, R. O. Burford, Geodetic determination of relative plate motion in central California, J. Geophysical
    Research 78, 1973 (the same shift of two half spaces).
    """

    def _field(self, setting: Setting) -> Floats:
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        across = direction(random)
        slides = np.cross(across, direction(random))
        at = (self.rig.rest_mm - centre) @ across / radius - random.uniform(-0.4, 0.4)
        locked = np.exp(random.uniform(np.log(0.05), np.log(0.5)))
        return 3.0 * np.arctan(at / locked)[:, None] * slides / np.linalg.norm(slides)


class CoreShowsThrough(Offset):
    """Core that shows through: over each cell of a honeycomb the skin has sunk in, as the sum of three waves at 60 deg.

    D. Zenkert (ed.), The Handbook of Sandwich Construction, EMAS Publishing, 1997. It sank more at one side.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        inwards = direction(random)
        first = np.cross(inwards, direction(random))
        first /= np.linalg.norm(first)
        axes = np.stack([first, np.cross(inwards, first)])
        place = (self.rig.rest_mm - centre) @ axes.T / radius
        cell, waves = random.uniform(0.5, 1.5), np.zeros(len(place))
        for turn in np.deg2rad([0.0, 60.0, 120.0]):
            at = place @ np.array([np.cos(turn), np.sin(turn)])
            waves += np.cos(2 * np.pi * at / cell + random.uniform(0, 2 * np.pi))
        uneven = 1 + random.uniform(0.0, 0.5) * place[:, 0]
        return 1.5 * (uneven * waves)[:, None] * inwards
