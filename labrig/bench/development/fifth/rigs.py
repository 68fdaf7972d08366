"""Rigs of the fifth portion that are seen by cameras: a snake, a face, a balloon and a walker."""

import numpy as np
from scipy.special import erf

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, markers


class Snake(Rig):
    """A snake on a table: each segment bends to the left with pressure and to the right with vacuum.

    C. D. Onal, D. Rus, Autonomous undulatory serpentine locomotion utilizing body dynamics of a fluidic soft robot,
    Bioinspiration and Biomimetics 8, 2013. A camera above sees two markers at the end of each segment, in x and y.
    """

    kind = "snake"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(4, 13))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(20, 60) * random.uniform(0.93, 1.07, count)
        self._low_kpa = -self.high_kpa * random.uniform(0.6, 1.0)
        self.marker_names, in_space = markers(2 * count)
        self.observables = tuple(o for o in in_space if o.axis < 2)
        self.noise = float(random.uniform(0.08, 0.2))
        self._long_mm = random.uniform(160, 320) / count * random.uniform(0.95, 1.05, count)
        self._wide_mm = random.uniform(6, 12)
        self._bends_rad = min(0.9, random.uniform(1.6, 3.0) / count) * random.uniform(0.85, 1.15, count)
        self._levels = random.uniform(0.6, 2.5, count)
        self._zero_mm, self._first_rad = random.normal(0, 20, 2), random.uniform(-0.3, 0.3)
        flat = self.shape(np.zeros((1, count))).reshape(-1, 2)
        self.rest_mm = np.column_stack([flat, np.zeros(len(flat))])

    @property
    def low_kpa(self) -> Floats:
        return self._low_kpa

    def deflection(self, kpa: Floats) -> Floats:
        return np.arcsinh(self._levels * kpa / self.high_kpa) / np.arcsinh(self._levels)

    def shape(self, deflection: Floats) -> Floats:
        bend = deflection * self._bends_rad
        after = self._first_rad + np.cumsum(bend, axis=1)
        chord = self._long_mm * np.sinc(0.5 * bend / np.pi)
        way = chord[..., None] * _direction(after - 0.5 * bend)
        joint = self._zero_mm + np.cumsum(way, axis=1)
        aside = self._wide_mm * _direction(after + 0.5 * np.pi)
        return np.stack([joint + aside, joint - aside], axis=2).reshape(len(deflection), -1)


def _direction(angle: Floats) -> Floats:
    """Unit vectors (..., 2) at angles (...) in rad."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


class Face(Rig):
    """An animatronic face: pads pull or push its skin about, and one opens the jaw, which takes the chin along.

    D. Hanson, Exploring the aesthetic range for humanoid robots, Proc. ICCS/CogSci Workshop Toward Social Mechanisms of
    Android Science, 2006. What a pad does dies away exponentially through the skin; pads fade with the logarithm.
    """

    kind = "face"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(8, 13)), int(random.integers(38, 51))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(15, 50) * random.uniform(0.7, 1.3, count)
        self.marker_names, self.observables = markers(seen)
        self.noise = float(random.uniform(0.03, 0.07))
        place = np.sqrt((np.arange(seen) + 0.5) / seen)[:, None] * _direction(
            2.39996 * np.arange(seen, dtype=np.float64)
        )
        place = place + random.normal(0, 0.03, place.shape)
        wide_mm, tall_mm = random.uniform(55, 75), random.uniform(75, 100)
        deep_mm = 45 * (1 - 0.6 * np.sum(place**2, axis=1))
        self.rest_mm = np.column_stack([wide_mm * place[:, 0], tall_mm * place[:, 1], deep_mm])
        at = (
            0.85
            * np.sqrt(random.random((count - 1, 1)))
            * _direction(random.uniform(0, 2 * np.pi, count - 1))
        )
        at_mm = np.column_stack([at * [wide_mm, tall_mm], 45 * (1 - 0.6 * np.sum(at**2, axis=1))])
        way = np.column_stack([random.normal(0, 0.6, (count - 1, 2)), random.uniform(0.3, 1.2, count - 1)])
        away = np.linalg.norm(at_mm[:, None] - self.rest_mm, axis=2) / random.uniform(14, 24)
        pull_mm = random.uniform(4, 9) * random.uniform(0.7, 1.3, (count - 1, 1)) * np.exp(-away)
        self._pull_mm = pull_mm[..., None] * way[:, None]  # (C - 1, M, 3)
        self._jaw = 1 / (1 + np.exp((place[:, 1] + random.uniform(0.25, 0.4)) / 0.08))
        self._hinge_mm = np.array([0.1 * tall_mm, -random.uniform(20, 40)])  # y, z
        self._opens_rad = np.deg2rad(random.uniform(10, 20))
        self._fades = random.uniform(0.4, 3.0, count)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return np.sign(load) * np.log1p(self._fades * np.abs(load)) / np.log1p(self._fades)

    def shape(self, deflection: Floats) -> Floats:
        assert self.rest_mm is not None
        points = self.rest_mm + np.einsum("tc,cmx->tmx", deflection[:, 1:], self._pull_mm)
        angle = deflection[:, :1] * self._opens_rad * self._jaw
        y, z = points[..., 1] - self._hinge_mm[0], points[..., 2] - self._hinge_mm[1]
        points[..., 1] = self._hinge_mm[0] + np.cos(angle) * y - np.sin(angle) * z
        points[..., 2] = self._hinge_mm[1] + np.sin(angle) * y + np.cos(angle) * z
        return points.reshape(len(deflection), -1)


class Balloon(Rig):
    """A catheter's balloon, which grows faster halfway than before and after; some have a collar that pinches it.

    I. Müller, P. Strehlow, Rubber and Rubber Balloons, Springer, 2004. Markers are printed all over it.
    """

    kind = "balloon"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(1, 3)), int(random.integers(12, 31))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(3, 15) * random.uniform(0.8, 1.2, count)
        self.marker_names, self.observables = markers(seen)
        self.noise = float(random.uniform(0.02, 0.05))
        height = np.linspace(-0.92, 0.92, seen) + random.normal(0, 0.02, seen)
        height = np.clip(height, -0.97, 0.97)
        round_ = np.sqrt(1 - height**2)[:, None] * _direction(2.39996 * np.arange(seen, dtype=np.float64))
        self._radius_mm, self._slender = random.uniform(8, 18), random.uniform(1.0, 2.2)
        self._unit, self._height = round_, height
        self._grows = np.array([random.uniform(0.5, 1.2), random.uniform(0.1, 0.5)])  # around, along
        self._pinches, self._narrow = random.uniform(0.15, 0.35), random.uniform(0.2, 0.5)
        self._steep, self._middle = random.uniform(2.0, 4.0, count), random.uniform(0.3, 0.6, count)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    def deflection(self, kpa: Floats) -> Floats:
        first = np.arctan(self._steep * self._middle)
        last = np.arctan(self._steep * (1 - self._middle))
        now = np.arctan(self._steep * (kpa / self.high_kpa - self._middle))
        return (now + first) / (last + first)

    def shape(self, deflection: Floats) -> Floats:
        around, along = (1 + by * deflection[:, :1] for by in self._grows)
        if deflection.shape[1] > 1:
            waist = np.exp(-((self._height / self._narrow) ** 2))
            around = around * np.exp(-self._pinches * deflection[:, 1:] * waist)
        else:
            around = around * np.ones_like(self._height)
        flat = self._radius_mm * around[..., None] * self._unit
        up = self._radius_mm * self._slender * along * (1 + self._height)
        return np.concatenate([flat, up[..., None]], axis=2).reshape(len(deflection), -1)


class Walker(Rig):
    """A walker held on a stand: each of three to five legs has a chamber that swings it and one that curls it under.

    D. Drotman, S. Jadhav, M. Karimi, P. deZonia, M. T. Tolley, 3D printed soft actuators for a legged robot capable of
    navigating unstructured terrain, Proc. IEEE Int. Conference on Robotics and Automation, 2017. A leg is an arc of a
    circle with three markers; three more sit on the body.
    """

    kind = "walker"

    def __init__(self, random: np.random.Generator) -> None:
        self._legs = int(random.integers(3, 6))
        count = 2 * self._legs
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(30, 110) * random.uniform(0.92, 1.08, count)
        self.marker_names, self.observables = markers(3 * self._legs + 3)
        self.noise = float(random.uniform(0.06, 0.15))
        self._faces = 2 * np.pi * np.arange(self._legs) / self._legs + random.normal(0, 0.08, self._legs)
        self._body_mm, self._long_mm = random.uniform(25, 45), random.uniform(50, 90)
        self._at = np.array([0.45, 0.75, 1.0]) + random.normal(0, 0.02, (self._legs, 3))
        self._leans_rad = np.deg2rad(random.uniform(15, 50))
        self._swings_rad = np.deg2rad(random.uniform(15, 35)) * random.uniform(0.9, 1.1, self._legs)
        self._curls_rad = np.deg2rad(random.uniform(40, 90)) * random.uniform(0.9, 1.1, self._legs)
        self._deck_mm = np.column_stack(
            [0.6 * self._body_mm * _direction(random.uniform(0, 6, 3)), np.full(3, 8)]
        )
        self._levels = random.uniform(0.5, 1.4, count)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    def deflection(self, kpa: Floats) -> Floats:
        return np.asarray(erf(self._levels * kpa / self.high_kpa) / erf(self._levels), dtype=float)

    def shape(self, deflection: Floats) -> Floats:
        swing = deflection[:, 0::2] * self._swings_rad
        curl = (deflection[:, 1::2] * self._curls_rad)[..., None] * self._at
        chord = self._long_mm * self._at * np.sinc(0.5 * curl / np.pi)
        down = self._leans_rad + 0.5 * curl
        far = (chord * np.cos(down))[..., None] * _direction(self._faces + swing)[:, :, None]
        foot = self._body_mm * _direction(self._faces)[:, None] + far
        legs = np.concatenate([foot, -(chord * np.sin(down))[..., None]], axis=3)
        deck = np.broadcast_to(self._deck_mm.ravel(), (len(deflection), self._deck_mm.size))
        return np.concatenate([legs.reshape(len(deflection), -1), deck], axis=1)
