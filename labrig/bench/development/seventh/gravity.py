"""Gravity of the seventh portion: a short body that shears under its weight, and a ring that its load flattens."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, compliance, down, long_axis, moved, positions, span


class ShearsUnderItsWeight(Law):
    """Short beam: clamped at one end it sags by shear, 2x - x^2 of its length, and not by bending.

    S. P. Timoshenko, On the correction for shear of the differential equation for transverse vibrations of prismatic
    bars, Philosophical Magazine 41, 1921. Pressure makes it a little stiffer.
    """

    effect = "gravity"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, gives = setting.random, compliance(self.rig)
        self._axis, along = long_axis(self.rig)
        x = along if gives[along > 0.5].mean() >= gives[along <= 0.5].mean() else 1 - along
        self._sags = 2 * x - x**2
        self._mm = span(self.rig) * random.uniform(0.2, 0.6)
        self._stiffer, self._lengthways = random.uniform(0.0, 1.0), random.uniform(0.05, 0.3)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        pull = down(path.tilt_deg)
        pull = pull - (1 - self._lengthways) * (pull @ self._axis)[:, None] * self._axis
        soft = strength * self._mm / (1 + self._stiffer * np.abs(deflection).mean(axis=1))
        change = soft[:, None, None] * self._sags[:, None] * pull[:, None]
        return moved(self.rig, values, positions(self.rig, values) + change)


class FlattensLikeARing(Law):
    """Ring under a load: it gets lower by 0.149 and wider by 0.137 of one and the same, and stands on its lowest place.

    S. Timoshenko, Strength of Materials II, Van Nostrand, 1930 (thin rings). The load is what hangs on the body.
    """

    effect = "gravity"
    needs = frozenset({"markers", "payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (self._centre_mm, self._radius_mm) = setting.random, body_mm(self.rig)
        self._axis = long_axis(self.rig)[0]
        self._most_kg = max(float(setting.path.payload_kg.max()), 0.01)
        self._always, self._stiffer = random.uniform(0.0, 0.4), random.uniform(0.0, 0.8)
        self._mm = span(self.rig) * random.uniform(0.15, 0.5)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        pull = down(path.tilt_deg)
        pull = pull - 0.9 * (pull @ self._axis)[:, None] * self._axis
        way = pull / np.linalg.norm(pull, axis=1, keepdims=True)
        weight = (self._always + path.payload_kg / self._most_kg) * np.linalg.norm(pull, axis=1)
        size = strength * self._mm * weight / (1 + self._stiffer * np.abs(deflection).mean(axis=1))
        points = positions(self.rig, values)
        arm = (points - self._centre_mm) / self._radius_mm
        low = np.einsum("tmx,tx->tm", arm, way)[..., None]
        aside = arm - low * way[:, None] - (arm @ self._axis)[..., None] * self._axis
        change = size[:, None, None] * ((1 - low) * way[:, None] + 0.137 / 0.149 * aside)
        return moved(self.rig, values, points + change)
