"""A gripper of three or four soft fingers around one object, each with a normal and a shear force sensor."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers

_STEPS = 16


class Gripper(Rig):
    """Fingers press on an object that hangs on springs: what one pushes, the others must hold.

    M. R. Cutkosky, I. Kao, Computing and controlling the compliance of a robotic hand, IEEE Trans. Robotics and
    Automation 5, 1989. There are no markers: only forces, which are strongly coupled through the object.
    """

    kind = "gripper"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(3, 5))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(50, 120) * random.uniform(0.93, 1.07, count)
        names = [f"{kind}{i + 1}" for i in range(count) for kind in ("normal", "shear")]
        self.observables = tuple(Observable(name, "N") for name in names)
        self.noise = float(random.uniform(0.015, 0.03))
        around = random.uniform(0, 2 * np.pi) + np.arange(count) * 2 * np.pi / count
        around += random.normal(0, 0.12, count)
        self._inward = -np.stack([np.cos(around), np.sin(around)], axis=1)
        self._aside = np.stack([-np.sin(around), np.cos(around)], axis=1)
        self._stroke_mm = random.uniform(8, 18) * random.uniform(0.85, 1.15, count)
        self._gap_mm = self._stroke_mm * random.uniform(0.0, 0.25, count)
        self._round_mm = random.uniform(0.6, 1.5)
        self._stiff = random.uniform(0.3, 0.6) * random.uniform(0.85, 1.15, count)  # N / mm
        turn = random.uniform(0, np.pi)
        axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        self._held = axes.T @ np.diag(random.uniform(0.15, 0.7, 2)) @ axes
        self._shears = random.uniform(0.15, 0.4, count)
        self._early = random.uniform(0.2, 1.5, count)

    def deflection(self, kpa: Floats) -> Floats:
        load = np.clip(kpa / self.high_kpa, -3.0, 20.0)
        return np.expm1(-self._early * load) / np.expm1(-self._early)

    def shape(self, deflection: Floats) -> Floats:
        reach = deflection * self._stroke_mm - self._gap_mm
        moved = np.zeros((len(deflection), 2))
        for _ in range(_STEPS):  # Newton on a convex energy
            into = (reach - moved @ self._inward.T) / self._round_mm
            force = self._stiff * self._round_mm * np.logaddexp(0.0, into)
            share = self._stiff / (1 + np.exp(-np.clip(into, -50.0, 50.0)))
            rest = force @ self._inward - moved @ self._held
            slope = np.einsum("tc,cx,cy->txy", share, self._inward, self._inward) + self._held
            moved = moved + np.linalg.solve(slope, rest[..., None])[..., 0]
        into = (reach - moved @ self._inward.T) / self._round_mm
        force = self._stiff * self._round_mm * np.logaddexp(0.0, into)
        shear = self._shears * (moved @ self._aside.T) * force / (force + 1.0)
        return np.stack([force, shear], axis=2).reshape(len(deflection), -1)
