"""Rest shape of the eighth portion: off all over, bent beforehand, shrunk, with a kink, and with a puckered seam."""

import numpy as np
from scipy.spatial.transform import Rotation

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import (
    direction,
    either_way,
    long_axis,
    moved,
    positions,
    smooth_field,
    span,
    spread,
)


class RestGeometryOff(Law):
    """Rest geometry off: the vented body is not the one of the drawing, by a little everywhere, and moves as modelled.

    ISO 2768-1, General tolerances, International Organization for Standardization, 1989.
    """

    effect = "rest_shape"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        numbers = random.normal(size=len(rig.observables))
        off = numbers if rig.rest_mm is None else spread(rig, smooth_field(setting))
        self._off = random.uniform(0.08, 0.18) * span(rig) * off / np.sqrt(np.mean(off**2))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._off


class PreBentBody(Law):
    """Bent beforehand: with no air in it the body is already bent a little, as though its chambers were not empty.

    P. Polygerinos et al., Soft robotics: review of fluid-driven intrinsically soft devices, Advanced Engineering
    Materials 19, 2017, on how such bodies are cast. Either way, and not at all chambers.
    """

    effect = "rest_shape"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._bent = either_way(setting, 0.06, 0.14, 0.8)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return deflection + strength * self._bent


class ShrunkInMould(Law):
    """Shrunk in the mould: silicone that was cured hot is smaller than its mould, along one way more than across.

    J. E. Mark, B. Erman, F. R. Eirich (editors), The Science and Technology of Rubber, Elsevier, 2005. It is fixed at
    its base.
    """

    effect = "rest_shape"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        shares = random.uniform(0.6, 1.0, 3)
        foot = np.array([*rig.rest_mm.mean(axis=0)[:2], rig.rest_mm[:, 2].min()])
        less = -shares * (rig.rest_mm - foot)
        size = np.sqrt(np.mean(spread(rig, less) ** 2))
        usual = random.uniform(0.015, 0.03)
        self._less_mm = less * max(usual, random.uniform(0.04, 0.08) * span(rig) / size)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * spread(self.rig, self._less_mm)


class KinkFromStorage(Law):
    """Kink from storage: the body lay folded in its box, and keeps a kink, beyond which all of it points elsewhere.

    ISO 815-1, Rubber, vulcanized or thermoplastic: determination of compression set, International Organization for
    Standardization, 2008.
    """

    effect = "rest_shape"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        axis, along = long_axis(rig)
        if random.random() < 0.5:
            along = 1 - along
        at = float(np.quantile(along, random.uniform(0.2, 0.6)))
        beyond = np.maximum(along - at, 0.0)
        self._beyond = beyond > 0
        if not self._beyond.any():
            self._beyond = along >= along.max()
        nearest = int(np.argmin(np.abs(along - at)))
        self._hinge_mm = (
            rig.rest_mm.mean(axis=0) + axis * (rig.rest_mm[nearest] - rig.rest_mm.mean(axis=0)) @ axis
        )
        hinge = np.cross(axis, direction(random))
        arm_mm = np.sqrt(np.mean(np.sum((rig.rest_mm[self._beyond] - self._hinge_mm) ** 2, axis=1)))
        angle = np.clip(random.uniform(0.2, 0.4) * span(rig) / arm_mm, np.deg2rad(1.5), np.deg2rad(8.0))
        self._turn_rad = angle * hinge / np.linalg.norm(hinge)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        matrix = np.asarray(Rotation.from_rotvec(strength * self._turn_rad).as_matrix())
        points = positions(self.rig, values)
        turned = (points - self._hinge_mm) @ matrix.T + self._hinge_mm
        return moved(self.rig, values, np.where(self._beyond[:, None], turned, points))


class SeamPuckers(Law):
    """Seam that puckers: thread sewn too tight gathers the fabric into waves along it, which fade to the sides.

    J. Fan, W. Yu, L. Hunter, Clothing Appearance and Fit, Woodhead, 2004, on seam pucker.
    """

    effect = "rest_shape"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        axis, along = long_axis(rig)
        out = np.cross(axis, direction(random))
        out /= np.linalg.norm(out)
        apart = (rig.rest_mm - rig.rest_mm[random.integers(len(along))]) @ np.cross(axis, out)
        fades = np.exp(-np.abs(apart) / (random.uniform(0.4, 1.0) * max(float(np.ptp(apart)), 1e-6)))
        wave = np.sin(2 * np.pi * random.uniform(1.2, 3.5) * along + random.uniform(0, 2 * np.pi)) * fades
        gathered = -random.uniform(0.3, 0.8) * (along - 0.5) * fades  # the seam is shorter too
        field = wave[:, None] * out + gathered[:, None] * axis
        size = np.sqrt(np.mean(spread(rig, field) ** 2))
        self._field_mm = random.uniform(0.08, 0.15) * span(rig) * field / max(float(size), 1e-9)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * spread(self.rig, self._field_mm)
