"""A soft arm of two segments with three chambers each, and ten markers on its surface."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig


class Arm(Rig):
    """Two segments that bend and grow, each with constant curvature (Webster and Jones, Int. J. Robotics Res., 2010).

    The bending is kept as a vector, without an angle that is undefined when the arm is straight (Della Santina,
    Bicchi and Rus, IEEE Robotics and Automation Letters, 2020). Each wall gives way faster as the pressure grows.
    """

    kind: ClassVar[str] = "arm"

    def __init__(self, random: np.random.Generator) -> None:
        self.chambers = tuple(f"{segment}_{side}" for segment in ("base", "tip") for side in "abc")
        self.high_kpa = np.repeat(random.uniform(60, 140, 2), 3)
        self.noise = 0.1
        self._length_mm = random.uniform(55, 85, 2)
        self._seat_mm = random.uniform(13, 19, 2)
        self._seat_rad = np.radians([0, 120, 240]) + random.uniform(-0.06, 0.06, (2, 3))
        self._seat_rad[1] += random.uniform(0, 1)
        self._stretch = random.uniform(0.08, 0.14, (2, 3))
        self._curve = random.uniform(0.15, 0.6, 6)
        self._share = np.tile(np.linspace(0.2, 1.0, 5), 2).reshape(2, 5)
        around = random.uniform(0, 2 * np.pi, (2, 5))
        self._skin_mm = random.uniform(20, 26) * np.stack([np.cos(around), np.sin(around)], axis=-1)
        self.marker_names = tuple(f"m{number:02d}" for number in range(1, 11))
        self.observables = tuple(
            Observable(f"{name}_{'xyz'[axis]}", "mm", marker, axis)
            for marker, name in enumerate(self.marker_names)
            for axis in range(3)
        )
        self._rest_mm = self.rest_mm = self._points(np.zeros((1, 6)))[0]

    def deflection(self, kpa: Floats) -> Floats:
        """How far each bellows grows, of its full growth: a parabola, rising, that goes on below zero."""
        load = np.maximum(np.asarray(kpa, dtype=float) / self.high_kpa, -0.5)
        return load * (1 + self._curve * load) / (1 + self._curve)

    def shape(self, deflection: Floats) -> Floats:
        """How far each marker is from its rest, x, y, z, in mm."""
        return (self._points(deflection) - self._rest_mm).reshape(len(deflection), -1)

    def _points(self, deflection: Floats) -> Floats:
        """Where the ten markers are, (T, 10, 3)."""
        strain = deflection.reshape(-1, 2, 3) * self._stretch
        base = self._bent(
            strain[:, 0], 0, np.append(self._share[0], 1.0), np.vstack([self._skin_mm[0], np.zeros(2)])
        )
        tip = self._bent(strain[:, 1], 1, self._share[1], self._skin_mm[1])
        top = self._turned(strain[:, 0], 0, tip)
        return np.concatenate([base[:, :-1], base[:, -1:] + top], axis=1)

    def _bow(self, strain: Floats, segment: int) -> tuple[Floats, Floats]:
        """The angle (T, 1) by which a segment bends and the direction (T, 1, 2) towards which."""
        angle = self._seat_rad[segment]
        push = strain @ np.column_stack([np.cos(angle), np.sin(angle)])
        bow = -2 / 3 * self._length_mm[segment] / self._seat_mm[segment] * push
        size = np.hypot(bow[:, 0], bow[:, 1])[:, None]
        return size, bow[:, None, :] / np.maximum(size, 1e-12)[:, :, None]

    def _turned(self, strain: Floats, segment: int, points: Floats, share: Floats | float = 1.0) -> Floats:
        """Points (T, n, 3) turned as the segment's cross-section is, at a share of its length."""
        size, towards = self._bow(strain, segment)
        sine, less = np.sin(size * share), 1 - np.cos(size * share)
        along = (points[..., :2] * towards).sum(axis=-1)
        flat = (along * -less + points[..., 2] * sine)[..., None] * towards
        rise = -along * sine - points[..., 2] * less
        return points + np.concatenate([flat, rise[..., None]], axis=-1)

    def _bent(self, strain: Floats, segment: int, share: Floats, offset_mm: Floats) -> Floats:
        """Points at shares of the length, each off the middle line, (T, n, 3)."""
        size, towards = self._bow(strain, segment)
        arc_mm = self._length_mm[segment] * (1 + strain.mean(axis=1))[:, None] * share
        angle = size * share
        aside = arc_mm * angle / 2 * np.sinc(angle / 2 / np.pi) ** 2
        middle = np.concatenate(
            [aside[..., None] * towards, (arc_mm * np.sinc(angle / np.pi))[..., None]], axis=-1
        )
        ring = np.broadcast_to(np.column_stack([offset_mm, np.zeros(len(share))]), middle.shape)
        return middle + self._turned(strain, segment, ring, share)
