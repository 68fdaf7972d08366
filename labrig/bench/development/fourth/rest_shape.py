"""Rest shapes of the fourth portion: a rippled edge, a helix, modules that were set beside their places."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig, Setting
from labrig.bench.development._places import alone, body_mm, columns, direction, long_axis
from labrig.bench.development.rest_shape import Offset


class RippledEdge(Offset):
    """Rippled edge: the rim has grown more than the middle, and stands in waves, with smaller ones on them.

    E. Sharon, B. Roman, M. Marder, G.-S. Shin, H. L. Swinney, Buckling cascades in free sheets, Nature 419, 2002.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        place = (self.rig.rest_mm - centre) / radius
        axes = np.linalg.svd(place, full_matrices=False)[2]
        u, v = place @ axes[0], place @ axes[1]
        far, angle = np.hypot(u, v), np.arctan2(v, u)
        far = far / max(float(far.max()), 1e-9)
        waves, power = int(random.integers(2, 5)), random.uniform(1.5, 3.0)
        height = far**power * np.cos(waves * angle + random.uniform(0, 2 * np.pi))
        height += 0.35 * far ** (2 * power) * np.cos(3 * waves * angle + random.uniform(0, 2 * np.pi))
        if _measured(self.rig, axes[2]) > 0.5:
            return 1.5 * height[:, None] * axes[2]
        out = u[:, None] * axes[0] + v[:, None] * axes[1]
        return 1.5 * height[:, None] * out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-9)


class Helix(Offset):
    """Set of a coil: what was kept on a spool is no longer straight, but winds about its own axis as a helix.

    A. E. H. Love, A Treatise on the Mathematical Theory of Elasticity, 4th ed., Cambridge University Press, 1927.
    """

    def _field(self, setting: Setting) -> Floats:
        random = setting.random
        axis, along = long_axis(self.rig)
        one = np.cross(axis, direction(random))
        one /= np.linalg.norm(one)
        other = np.cross(axis, one) * random.choice([-1.0, 1.0])
        turn = 2 * np.pi * random.uniform(0.4, 1.3) * along
        return 0.7 * ((np.cos(turn) - 1)[:, None] * one + np.sin(turn)[:, None] * other)


class MisplacedModules(Offset):
    """Tolerances of an assembly: each module sits a little beside its place, with all the markers that it carries.

    D. E. Whitney, Mechanical Assemblies: Their Design, Manufacture, and Role in Product Development, Oxford University
    Press, 2004.
    """

    def _field(self, setting: Setting) -> Floats:
        random, where = setting.random, columns(self.rig)
        size = np.linalg.norm(np.where(where >= 0, alone(self.rig)[:, where], 0.0), axis=2)  # (C, M)
        carried = size / np.maximum(size.max(axis=1, keepdims=True), 1e-9)
        sits = random.normal(size=(len(size), 3))
        return 1.2 * sits[np.argmax(carried, axis=0)]


def _measured(rig: Rig, way: Floats) -> float:
    """How much of a direction (3,) lies along axes that are measured, from 0 to 1."""
    axes = sorted({o.axis for o in rig.observables if o.axis >= 0})
    return float(np.linalg.norm(way[axes]))
