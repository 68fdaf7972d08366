"""Gravity of the fifth portion: a rod that bows far, a weight over a pulley, arms that droop as they grow."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import down, full, long_axis, moved, pattern, positions, span


class FarBowedRod(Law):
    """Heavy elastica: a soft rod turns down along its length by ever more, up to where it hangs, and each part with it.

    F. V. Rohde, Large deflections of a cantilever beam with uniformly distributed load, Quarterly of Applied
    Mathematics 11, 1953.
    """

    effect = "gravity"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rest = setting.random, self.rig.rest_mm
        assert rest is not None
        self._axis, along = long_axis(self.rig)
        if random.random() < 0.5:
            self._axis, along = -self._axis, 1 - along
        self._foot_mm = rest[int(np.argmin(along))]
        self._turns = 1 - (1 - along) ** 3  # the slope of a beam under its own weight
        long_mm = float(np.ptp(rest @ self._axis))
        self._soft_rad = span(self.rig) / max(long_mm, 1e-6) * random.uniform(0.3, 1.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        pull = np.cross(self._axis, down(path.tilt_deg))
        sine = np.linalg.norm(pull, axis=1)
        angle = np.arctan(strength * self._soft_rad * sine)[:, None] * self._turns  # (T, M)
        turn = (pull / np.maximum(sine, 1e-9)[:, None])[:, None]
        arm = positions(self.rig, values) - self._foot_mm
        # Rodrigues, about the foot; a chord turns by the mean of the slopes below, three quarters of the own
        angle = 0.75 * angle[..., None]
        across = np.cross(np.broadcast_to(turn, arm.shape), arm)
        along = np.sum(turn * arm, axis=2, keepdims=True) * turn
        there = np.cos(angle) * arm + np.sin(angle) * across + (1 - np.cos(angle)) * along
        return moved(self.rig, values, self._foot_mm + there)


class OverAPulley(Law):
    """Weight over a pulley: a thread pulls the body one way by the weight, however its base is turned.

    G. Atwood, A Treatise on the Rectilinear Motion and Rotation of Bodies, Cambridge, 1784. The body gives way in its
    main mode, less and less, by a Langmuir curve of the weight.
    """

    effect = "gravity"
    needs = frozenset({"payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._most_kg = max(float(setting.path.payload_kg.max()), 0.01)
        self._levels, self._stiffer = random.uniform(0.0, 2.0), random.uniform(0.0, 1.0)
        way = pattern(self.rig) * np.sqrt(len(self.rig.observables))
        self._pull = random.choice([-1.0, 1.0]) * span(self.rig) * random.uniform(0.15, 0.5) * way

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        weight = path.payload_kg / self._most_kg
        gives = weight * (1 + self._levels) / (1 + self._levels * weight)
        soft = strength * gives / (1 + self._stiffer * np.abs(deflection).mean(axis=1))
        return values + soft[:, None] * self._pull


class LongerArm(Law):
    """Weight on an arm that grows: each wall lifts by the cosine of how its base is turned, the cube of its length.

    W. C. Young, Roark's Formulas for Stress and Strain, 6th ed., McGraw-Hill, 1989. What is lost is a share of the
    pressure; a vented wall lies on its stop.
    """

    effect = "gravity"
    needs = frozenset({"tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._looks_rad = random.uniform(-np.pi, np.pi) + random.normal(0, 0.6, count)
        self._grows, self._weighs = random.uniform(0.2, 0.8), random.uniform(0.05, 0.15)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        lifts = np.cos(np.deg2rad(path.tilt_deg)[:, None] + self._looks_rad)
        long = (1 + self._grows * np.minimum(np.abs(load), 2.0)) ** 3
        lies = np.tanh(np.abs(load) / 0.05)
        return kpa - strength * self._weighs * self.rig.high_kpa * lifts * long * lies
