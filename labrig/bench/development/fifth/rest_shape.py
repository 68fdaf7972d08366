"""Rest shapes of the fifth portion: a bowed cast, a flattened one, a length that was drawn unevenly."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Setting
from labrig.bench.development._places import body_mm, direction, long_axis
from labrig.bench.development.rest_shape import Offset


def _across(setting: Setting, axis: Floats) -> Floats:
    """A direction (3,) square to an axis, with as much as can be along what is measured."""
    axes = sorted({o.axis for o in setting.rig.observables if o.axis >= 0})
    way = np.zeros(3)
    way[axes] = direction(setting.random)[axes]
    way = way - (way @ axis) * axis
    return way / np.linalg.norm(way)


class BowedCast(Offset):
    """Bow: cooled on one side first, a cast is bent like a banana, both ends one way and the middle the other.

    R. A. Malloy, Plastic Part Design for Injection Molding, Hanser, 1994.
    """

    def _field(self, setting: Setting) -> Floats:
        axis, along = long_axis(self.rig)
        way = _across(setting, axis)
        at = 2 * along - 1
        bow = at**2 - 1 / 3
        assert self.rig.rest_mm is not None
        high = (self.rig.rest_mm - self.rig.rest_mm.mean(axis=0)) @ way / body_mm(self.rig)[1]
        return 1.8 * (bow[:, None] * way - 0.5 * (at * high)[:, None] * axis)


class FlattenedTube(Offset):
    """Flattened: what lay under a load in store is an oval across its length, in the middle more than at its ends.

    L. G. Brazier, On the flexure of thin cylindrical shells and other thin sections, Proc. Royal Society A 116, 1927.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        axis, along = long_axis(self.rig)
        flat = _across(setting, axis)
        wide = np.cross(axis, flat)
        place = (self.rig.rest_mm - centre) / radius
        firm = 1 - random.uniform(0.0, 0.8) * (2 * along - 1) ** 2
        out = (place @ wide)[:, None] * wide - (place @ flat)[:, None] * flat
        return 2.0 * firm[:, None] * out


class DrawnUnevenly(Offset):
    """Draw resonance: an extruded body is thick and thin in turn along its length; its places shift to and fro.

    C. J. S. Petrie, M. M. Denn, Instabilities in polymer processing, AIChE J. 22, 1976.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        axis, along = long_axis(self.rig)
        waves, first = random.uniform(1.5, 4.5), random.uniform(0, 2 * np.pi)
        phase = 2 * np.pi * waves * along + first
        place = (self.rig.rest_mm - centre) / radius
        across = place - (place @ axis)[:, None] * axis
        return 1.2 * np.sin(phase)[:, None] * across + 0.8 * np.cos(phase)[:, None] * axis
