"""Further rest shapes: a buckled seam, a set from lying, uneven walls, a twist, a dent."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Setting
from labrig.bench.development._places import body_mm, direction, long_axis
from labrig.bench.development.rest_shape import Offset


def _normal(places: Floats) -> Floats:
    """The direction (3,) in which a body is thinnest."""
    return np.linalg.svd(places, full_matrices=False)[2][2]


class BuckledSeam(Offset):
    """Buckled seam: along a line the glued edge is wavy, and the waves die out on either side of it.

    S. P. Timoshenko, J. M. Gere, Theory of Elastic Stability, 2nd ed., McGraw-Hill, 1961.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        place = (self.rig.rest_mm - centre) / radius
        axes = np.linalg.svd(place, full_matrices=False)[2]
        angle = random.uniform(0, np.pi)
        along = np.cos(angle) * axes[0] + np.sin(angle) * axes[1]
        across = np.cos(angle) * axes[1] - np.sin(angle) * axes[0]
        off = place @ across - random.uniform(-0.5, 0.5)
        waves = np.sin(place @ along * random.uniform(3.0, 7.0) + random.uniform(0, 2 * np.pi))
        return 2.5 * (waves * np.exp(-np.abs(off) / random.uniform(0.25, 0.6)))[:, None] * axes[2]


class SetFromLying(Offset):
    """Compression set: after months in its box the body stays sunk between the points that carried it.

    A. N. Gent (ed.), Engineering with Rubber, 3rd ed., Hanser, 2012.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        place = (self.rig.rest_mm - centre) / radius
        carried = place[random.permutation(len(place))[:2]]
        far = np.linalg.norm(place[:, None] - carried, axis=2).min(axis=1)
        down = np.array([0.0, 0.0, -1.0]) + 0.3 * random.normal(size=3)
        return 2.0 * (1 - np.exp(-((far / random.uniform(0.5, 1.0)) ** 2)))[:, None] * down


class UnevenWall(Offset):
    """Uneven wall: a shifted core makes one side of the cast too thick and the other too thin, in a few slow waves.

    D. V. Rosato, D. V. Rosato, M. G. Rosato, Injection Molding Handbook, 3rd ed., Kluwer, 2000.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        place = (self.rig.rest_mm - centre) / radius
        waves = np.sin(place @ random.normal(0, 0.8, (3, 3)) + random.uniform(0, 2 * np.pi, 3))
        thicker = place @ direction(random) + waves @ random.normal(0, 0.5, 3)
        outward = place + np.sign(random.normal()) * _normal(place)
        length = np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-9)
        return 1.5 * thicker[:, None] * outward / length


class Twisted(Offset):
    """Torsion: the body was mounted with a twist about its length, growing from one end to the other.

    A. J. C. Barré de Saint-Venant, Mémoire sur la torsion des prismes, Mémoires des savants étrangers 14, Paris, 1856.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        axis, along = long_axis(self.rig)
        start = random.uniform(0.0, 0.4)
        centre = centre + 0.2 * radius * direction(random)
        arm = np.cross(axis, (self.rig.rest_mm - centre) / radius)
        return 3.0 * float(random.choice([-1.0, 1.0])) * np.maximum(along - start, 0.0)[:, None] * arm


class Dent(Offset):
    """Dent: a blow has left a round hollow in one place, and a low rim around it.

    S. P. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed., McGraw-Hill, 1959.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        at = self.rig.rest_mm[int(random.integers(len(self.rig.rest_mm)))]
        share = np.linalg.norm(self.rig.rest_mm - at, axis=1) / (radius * random.uniform(0.4, 0.8))
        inward = centre - at + 0.5 * radius * _normal(self.rig.rest_mm - centre)
        hollow = (1 - 0.5 * share**2) * np.exp(-0.5 * share**2)
        return 3.0 * hollow[:, None] * inward / max(float(np.linalg.norm(inward)), 1e-9)
