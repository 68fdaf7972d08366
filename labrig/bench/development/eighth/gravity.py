"""Gravity of the eighth portion: the body's own weight, what hangs on it, and what its walls must lift."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Rig, Setting
from labrig.bench.development._places import (
    compliance,
    direction,
    down,
    full,
    moved,
    pattern,
    positions,
    span,
)


def _gives(rig: Rig) -> Floats:
    """How easily each observable (K,) is moved, root mean square 1: as its marker, or as all chambers move it."""
    marker = np.array([o.marker for o in rig.observables])
    every = pattern(rig) * np.sqrt(len(marker))
    if not rig.marker_names:
        return every
    soft = compliance(rig)[marker]
    soft /= np.sqrt(np.mean(soft[marker >= 0] ** 2))
    return np.where(marker >= 0, soft, every)


def _pulled(rig: Rig, force: Floats, sense: Floats) -> Floats:
    """The change (T, K) under a force (T, 3); what is no marker's feels its part along `sense` (3,)."""
    parts = np.concatenate([force, (force @ sense)[:, None]], axis=1)
    return parts[:, [o.axis if o.marker >= 0 else 3 for o in rig.observables]] * _gives(rig)


def _sense(random: np.random.Generator) -> Floats:
    """A direction (3,) that gravity at rest and gravity from the side both act along."""
    vector = np.array(
        [0.0, random.choice([-1.0, 1.0]) * random.uniform(0.7, 1.0), random.uniform(-1.0, -0.5)]
    )
    return vector / np.linalg.norm(vector)


def _usual_kg(path: Path) -> float:
    """The payload, in kg, that a campaign takes as its measure."""
    most = float(path.payload_kg.max())
    return most if most > 0 else 1.0


class SagsByOwnWeight(Law):
    """Sags by its own weight: a soft body gives way along gravity, and to the side when its base is turned.

    J. M. Gere and S. P. Timoshenko, Mechanics of Materials, PWS, 1997. The sag is Hooke's: weight over stiffness,
    the most where the body is softest.
    """

    effect = "gravity"
    needs = frozenset({"tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._sag = span(self.rig) * random.uniform(0.08, 0.18)
        self._sense = _sense(random)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._sag * _pulled(self.rig, down(path.tilt_deg), self._sense)


class HangingMass(Law):
    """Hanging mass: what hangs on the body draws it down in proportion to its mass.

    R. Hooke, Lectures de Potentia Restitutiva, or of Spring, 1678. A hook at one place; the body is an elastic spring
    whatever its pressures.
    """

    effect = "gravity"
    needs = frozenset({"payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._sag = span(self.rig) * random.uniform(0.12, 0.3) / _usual_kg(setting.path)
        self._sense = _sense(random)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        force = path.payload_kg[:, None] * down(path.tilt_deg)
        return values + strength * self._sag * _pulled(self.rig, force, self._sense)


class WallsLiftTheBody(Law):
    """Walls lift the body: each wall carries a part of the weight, and needs so much pressure only to hold it.

    A. D. Marchese, R. Tedrake and D. Rus, Dynamics and trajectory optimization for a soft spatial fluidic elastomer
    manipulator, International Journal of Robotics Research 35(8), 2016. Turning the base takes weight off the walls
    that look up and puts it on those at the side; a payload adds to it.
    """

    effect = "gravity"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._weight = random.uniform(0.03, 0.07)  # of the full pressure
        self._faces = np.stack([direction(random) for _ in range(count)])
        self._faces[:, 2] = -0.5 - np.abs(self._faces[:, 2])  # all lift, more or less
        self._heavier = random.uniform(0.5, 1.5) / _usual_kg(setting.path)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        heavy = 1 + self._heavier * path.payload_kg[:, None]
        bears = heavy * (down(path.tilt_deg) @ self._faces.T)
        return kpa - strength * self._weight * bears * self.rig.high_kpa


class DroopsAsItReaches(Law):
    """Droops as it reaches: the further a part of the body is moved out, the longer is the arm of its weight.

    F. Renda, M. Giorelli, M. Calisti, M. Cianchetti and C. Laschi, Dynamic model of a multibending soft robot arm
    driven by cables, IEEE Transactions on Robotics 30(5), 2014. The arm is the motion across gravity. Without load
    the body is in balance where it rests.
    """

    effect = "gravity"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._droop = random.uniform(0.12, 0.3)
        self._heavier = random.uniform(0.5, 1.5) / _usual_kg(setting.path)
        self._soft = compliance(self.rig)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        assert self.rig.rest_mm is not None
        points, way = positions(self.rig, values), down(path.tilt_deg)
        motion = points - positions(self.rig, self.rig.at_rest[None])
        along = np.einsum("tmk,tk->tm", motion, way)
        arm = np.linalg.norm(motion - along[:, :, None] * way[:, None], axis=2) * self._soft
        heavy = (1 + self._heavier * path.payload_kg)[:, None]
        sag = strength * self._droop * heavy * arm
        return moved(self.rig, values, points + sag[:, :, None] * way[:, None])


class InflatedBeamCarries(Law):
    """Inflated beam: air makes a beam stiff, so that weight and payload draw it down the more the less it is filled.

    R. L. Comer and S. Levy, Deflections of an inflated circular-cylindrical cantilever beam, AIAA Journal 1(7), 1963.
    What is left without pressure is the stiffness of the cloth.
    """

    effect = "gravity"
    needs = frozenset({"payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._sag = span(self.rig) * random.uniform(0.15, 0.35)
        self._own = random.uniform(0.2, 0.5)  # its weight, as a share of the payload
        self._usual_kg = _usual_kg(setting.path)
        self._cloth = random.uniform(0.25, 0.5)
        weight = random.uniform(0.5, 1.5, count)
        self._weight = weight / weight.sum()
        self._sense = _sense(random)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        filled = np.abs(full(self.rig, path.kpa)) @ self._weight
        load = (self._own + path.payload_kg / self._usual_kg) * self._cloth / (self._cloth + filled)
        force = load[:, None] * down(path.tilt_deg)
        return values + strength * self._sag * _pulled(self.rig, force, self._sense)
