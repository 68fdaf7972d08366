"""A planar gripper of two soft fingers, seen by a camera."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig


class Gripper(Rig):
    """Two fingers that curl in a plane, each with constant curvature and three tracked points, in pixels.
    Their palm bows with both.

    The curl grows faster than the pressure, as of pneumatic networks (Mosadegh and others, Advanced Functional
    Materials, 2014). The camera looks a little askew, so that what is nearer looks larger (Hartley and Zisserman,
    Multiple View Geometry, 2003). `rest_mm` is in pixels, too, with z = 0.
    """

    kind: ClassVar[str] = "gripper"

    def __init__(self, random: np.random.Generator) -> None:
        self.chambers = ("left", "right")
        self.high_kpa = random.uniform(45, 90) * random.uniform(0.92, 1.08, 2)
        self.noise = 0.3
        self._length_px = random.uniform(230, 310) * random.uniform(0.95, 1.05, 2)
        self._root_px = np.array([[-1.0, 0.0], [1.0, 0.0]]) * random.uniform(70, 120) + random.normal(
            0, 4, (2, 2)
        )
        self._curl_rad = random.uniform(0.6, 1.0) * random.uniform(0.9, 1.1, 2)
        self._lean_rad = random.uniform(-0.15, 0.25, 2)
        self._palm_rad = random.uniform(0.08, 0.18)
        self._rise = random.uniform(0.5, 1.3, 2)
        self._share = np.array([0.5, 0.75, 1.0]) + random.uniform(-0.05, 0.0, 3)
        self._askew = random.uniform(0.06, 0.16) / 400 * np.array([random.choice([-1.0, 1.0]) * 0.5, 1.0])
        self._roll_rad = random.uniform(-0.08, 0.08)
        self.marker_names = tuple(f"{finger}{number}" for finger in self.chambers for number in (1, 2, 3))
        self.observables = tuple(
            Observable(f"{name}_{'xy'[axis]}", "px", marker, axis)
            for marker, name in enumerate(self.marker_names)
            for axis in range(2)
        )
        rest = self._points(np.zeros((1, 2)))[0]
        self.rest_mm = np.column_stack([rest, np.zeros(len(rest))])

    def deflection(self, kpa: Floats) -> Floats:
        """How far each finger curls, of its full curl: an exponential, also below zero."""
        load = np.clip(np.asarray(kpa, dtype=float) / self.high_kpa, -1.0, 3.0)
        return np.expm1(self._rise * load) / np.expm1(self._rise)

    def shape(self, deflection: Floats) -> Floats:
        """How far each point is from its rest in the image, x, y, in pixels."""
        rest = self._points(np.zeros((1, 2)))
        return (self._points(deflection) - rest).reshape(len(deflection), -1)

    def _points(self, deflection: Floats) -> Floats:
        """Where the six points are in the image, (T, 6, 2)."""
        palm = self._palm_rad * deflection.sum(axis=1, keepdims=True) / 2
        fingers = []
        for finger, inward in enumerate((1.0, -1.0)):
            angle = (deflection[:, finger] * self._curl_rad[finger])[:, None] * self._share
            arc_px = self._length_px[finger] * self._share
            heading = self._lean_rad[finger] - palm + angle / 2
            chord_px = arc_px * np.sinc(angle / 2 / np.pi)
            x = self._root_px[finger, 0] + inward * chord_px * np.sin(heading)
            y = self._root_px[finger, 1] + chord_px * np.cos(heading)
            fingers.append(np.stack([x, y], axis=-1))
        plane = np.concatenate(fingers, axis=1)
        sine, cosine = np.sin(self._roll_rad), np.cos(self._roll_rad)
        plane = plane @ np.array([[cosine, sine], [-sine, cosine]])
        return plane / (1 + plane @ self._askew)[..., None]
