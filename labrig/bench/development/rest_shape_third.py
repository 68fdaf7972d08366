"""Rest shapes of the third portion: a saddle, a tapered cast, a kinked seam, a figure of Zernike polynomials."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Setting
from labrig.bench.development._places import body_mm, direction, long_axis
from labrig.bench.development.rest_shape import Offset


class Saddle(Offset):
    """Saddle: a laminate of unlike layers comes out of its mould curved otherwise in two directions, often oppositely.

    M. W. Hyer, Some observations on the cured shape of thin unsymmetric laminates, J. Composite Materials 15, 1981.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (u, v, normal) = setting.random, _flat(self, setting)
        bend = np.array([1.0, random.uniform(-1.2, 0.3), random.normal(0, 0.3)])
        height = bend[0] * u**2 + bend[1] * v**2 + bend[2] * u * v
        return 1.2 * (height - height.mean())[:, None] * normal


class TaperedCast(Offset):
    """Uneven shrinkage: from the gate to the far end a cast shrinks ever more across its length, and along it.

    R. A. Malloy, Plastic Part Design for Injection Molding, Hanser, 1994.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        axis, along = long_axis(self.rig)
        along = along if random.random() < 0.5 else 1 - along
        off = (self.rig.rest_mm - centre) / radius
        across = off - (off @ axis)[:, None] * axis
        less = along ** random.uniform(0.7, 2.0)
        shrinks = -less[:, None] * (across + random.uniform(0.2, 0.8) * off)
        return 2.0 * float(random.choice([-1.0, 1.0], p=[0.3, 0.7])) * shrinks


class KinkedSeam(Offset):
    """Kinked seam: two straight halves were joined at an angle, so that beyond the seam all is turned about it.

    G. Boothroyd, P. Dewhurst, W. A. Knight, Product Design for Manufacture and Assembly, 3rd ed., CRC Press, 2011.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (u, _, normal) = setting.random, _flat(self, setting)
        at = np.quantile(u, random.uniform(0.25, 0.6))
        beyond = np.maximum(u - at, 0.0)
        shifted = 0.15 * (u > at)[:, None] * direction(random)
        return 1.5 * beyond[:, None] * normal + shifted


class ZernikeFigure(Offset):
    """Figure error: astigmatism, coma, trefoil and spherical error of the cast surface, each with its own size.

    F. Zernike, Beugungstheorie des Schneidenverfahrens und seiner verbesserten Form, der Phasenkontrastmethode, Physica
    1, 1934.
    """

    def _field(self, setting: Setting) -> Floats:
        random, (u, v, normal) = setting.random, _flat(self, setting)
        far = max(float(np.hypot(u, v).max()), 1e-9)
        r, angle = np.hypot(u, v) / far, np.arctan2(v, u)
        figures = [
            r**2 * np.cos(2 * angle), r**2 * np.sin(2 * angle),
            (3 * r**3 - 2 * r) * np.cos(angle), (3 * r**3 - 2 * r) * np.sin(angle),
            r**3 * np.cos(3 * angle), 6 * r**4 - 6 * r**2 + 1,
        ]  # fmt: skip
        height = np.stack(figures, axis=1) @ random.normal(0, 1, 6)
        return 1.2 * height[:, None] * normal


def _flat(law: Offset, setting: Setting) -> tuple[Floats, Floats, Floats]:
    """Places (M,), (M,) along two directions of the body, drawn by chance in its plane, in radii; and its normal (3,).

    A body seen by one camera has its second direction across the picture, where all is at zero.
    """
    centre, radius = body_mm(law.rig)
    assert law.rig.rest_mm is not None
    place = (law.rig.rest_mm - centre) / radius
    axes = np.linalg.svd(place, full_matrices=False)[2]
    if np.ptp(place[:, 1]) < 1e-9 and {o.axis for o in law.rig.observables} == {0, 2}:
        return place @ axes[0], 0.0 * place[:, 0], np.cross(axes[0], [0.0, 1.0, 0.0])
    angle = setting.random.uniform(0, 2 * np.pi)
    one = np.cos(angle) * axes[0] + np.sin(angle) * axes[1]
    other = np.cos(angle) * axes[1] - np.sin(angle) * axes[0]
    return place @ one, place @ other, axes[2]
