"""Rigs of the twelfth portion, few sensors of several kinds: a thruster, a neck and a hoist."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers, turns
from labrig.bench.development.twelfth._sensors import noises


class Thruster(Rig):
    """A thruster: one to three bellows push a crosshead against a spring, felt by a rule, an inclinometer, load cells.

    J. F. Wilson, Mechanics of bellows: a critical survey, Int. J. Mechanical Sciences 26, 1984: a bellows' effective
    area shrinks as it opens, and its folds are a spring. The crosshead rises and tips to where all of them balance.
    """

    kind = "thruster"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(1, 4))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(60, 180) * random.uniform(0.95, 1.05, count)
        told = [Observable("travel", "mm"), Observable("spring", "N")]
        if count > 1:
            told += [Observable("tip", "deg"), *(Observable(f"foot{c + 1}", "N") for c in range(count - 1))]
        self.observables = tuple(told)
        self.noise, self.noisier = noises(
            random, self.observables, mm=(0.02, 0.08), N=(0.08, 0.25), deg=(0.04, 0.12)
        )
        self._push_n = random.uniform(35, 80) / count**0.5 * random.uniform(0.93, 1.07, count)
        self._folds = random.uniform(0.3, 0.8) * random.uniform(0.9, 1.1, count)  # N / mm
        self._shrinks = random.uniform(0.003, 0.012)  # of the area, per mm
        self._spring = random.uniform(0.5, 1.5)  # N / mm
        self._preload_n = random.uniform(1, 6)
        wide_mm = random.uniform(25, 45)
        self._place_mm = np.linspace(-wide_mm, wide_mm, count) if count > 1 else np.zeros(1)
        self._upright = random.uniform(0.2, 0.6) * wide_mm**2  # N mm / rad, what holds the crosshead level
        self._stiffens = random.uniform(0.15, 0.6) * random.uniform(0.95, 1.05, count)

    def deflection(self, kpa: Floats) -> Floats:
        load, c = kpa / self.high_kpa, self._stiffens
        return load * (1 + c) / (1 + c * np.abs(load))

    def shape(self, deflection: Floats) -> Floats:
        push, u = self._push_n * 6 * np.tanh(deflection / 6), self._place_mm
        stiff = self._folds + np.abs(push) * self._shrinks
        high = self._spring + stiff.sum(axis=1)
        tilts = self._upright + stiff @ u**2
        mixed = stiff @ u
        level = high * tilts - mixed**2
        right, turn = push.sum(axis=1), push @ u
        rise = (tilts * right - mixed * turn) / level
        slope = (high * turn - mixed * right) / level
        told = [rise, self._preload_n + self._spring * rise]
        if len(u) > 1:
            feet = push - stiff * (rise[:, None] + slope[:, None] * u)
            told += [np.rad2deg(np.arctan(slope)), *feet.T[:-1]]
        return np.stack(told, axis=1)


class Neck(Rig):
    """A neck: three chambers around its axis bend and lengthen it, told by an inclinometer's two angles and a cord.

    M. W. Hannan, I. D. Walker, Kinematics and the implementation of an elephant's trunk manipulator, J. Robotic Systems
    20, 2003: it bends evenly. The cord runs straight from foot to head. Some have a ball on the head that is tracked,
    some two that one camera sees from the side.
    """

    kind = "neck"

    def __init__(self, random: np.random.Generator) -> None:
        count = 3 if random.random() < 0.7 else 4
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(40, 120) * random.uniform(0.95, 1.05, count)
        balls = int(random.choice([0, 1, 2], p=[0.4, 0.35, 0.25]))
        self._axes = [0, 1, 2] if balls == 1 else [0, 2]
        self.marker_names = tuple(f"m{k + 1}" for k in range(balls))
        seen = [Observable(f"m{k + 1}.{'xyz'[a]}", "mm", k, a) for k in range(balls) for a in self._axes]
        told = [Observable("pitch", "deg"), Observable("roll", "deg"), Observable("cord", "mm")]
        self.observables = (*told, *seen)
        self.noise, self.noisier = noises(random, self.observables, deg=(0.04, 0.15), mm=(0.06, 0.2))
        self._long_mm = random.uniform(70, 130)
        self._radius_mm = random.uniform(18, 30)
        self._around = random.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(count) / count
        self._longer = random.uniform(0.16, 0.3) * random.uniform(0.92, 1.08, count)
        self._held = random.uniform(0.55, 0.8)  # of its own way, as the others hold it back
        off_mm = random.uniform(15, 35, (balls, 1))
        way = random.uniform(0, 2 * np.pi) + np.pi * np.arange(balls) + random.normal(0, 0.3, balls)
        up_mm = random.uniform(5, 30, balls)
        self._ball_mm = np.concatenate([off_mm * np.stack([np.cos(way), np.sin(way)], 1), up_mm[:, None]], 1)
        self._stiffens = random.uniform(0.3, 0.9)
        self._opens = random.uniform(0.02, 0.2, count)
        if balls:
            straight = np.array([0.0, 0.0, self._long_mm])
            self.rest_mm = straight + self._ball_mm

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        opens = np.abs(load) / (np.abs(load) + self._opens) * (1 + self._opens)
        return opens * load * (1 + self._stiffens) / (1 + self._stiffens * np.abs(load))

    def shape(self, deflection: Floats) -> Floats:
        far = self._longer * 4 * np.tanh(deflection / 4)
        mean = far.mean(axis=1)
        bend = self._held * self._long_mm * far * 2 / (far.shape[1] * self._radius_mm)
        # a chamber that grows longer bends the head away from it
        x, y = -bend @ np.cos(self._around), -bend @ np.sin(self._around)
        size = np.hypot(x, y)
        less = 2.2 * np.tanh(size / 2.2) / np.maximum(size, 1e-12)
        turn = np.stack([-y * less, x * less, np.zeros_like(x)], axis=1)
        matrix, along = turns(turn)
        long_mm = self._long_mm * (1 + self._held * mean)
        tip = along[..., 2] * long_mm[:, None]
        normal = matrix[..., 2]
        pitch = np.rad2deg(np.arcsin(np.clip(normal[:, 0], -1, 1)))
        roll = np.rad2deg(np.arctan2(normal[:, 1], np.hypot(normal[:, 0], normal[:, 2])))
        told = [np.stack([pitch, roll, np.linalg.norm(tip, axis=1)], axis=1)]
        if self.marker_names:
            balls = tip[:, None] + np.einsum("tij,mj->tmi", matrix, self._ball_mm)
            told.append(balls[..., self._axes].reshape(len(tip), -1))
        return np.concatenate(told, axis=1)


class Hoist(Rig):
    """A hoist: folded muscles that vacuum draws together lift a bar against rubber bands: height, slope, and pulls.

    S. Li, D. M. Vogt, D. Rus, R. J. Wood, Fluid-driven origami-inspired artificial muscles, PNAS 114, 2017. Pressures
    are counted as they lie below the room's, so a full chamber is an empty one; some are blown up a little, too. Folds
    that close lose their lever: the way goes with the vacuum at first, and ends where they are flat.
    """

    kind = "hoist"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(1, 4))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(35, 80) * random.uniform(0.95, 1.05, count)
        self._low_kpa = -(random.uniform(0.1, 0.25) if random.random() < 0.4 else 0.0) * self.high_kpa
        told = [Observable("height", "mm"), *(Observable(f"pull{c + 1}", "N") for c in range(count))]
        self.observables = (*told, *([Observable("slope", "deg")] if count > 1 else []))
        self.noise, self.noisier = noises(
            random, self.observables, mm=(0.05, 0.2), N=(0.05, 0.15), deg=(0.03, 0.1)
        )
        self._way_mm = random.uniform(30, 60) * random.uniform(0.93, 1.07, count)
        self._stiff = random.uniform(0.4, 1.2) * random.uniform(0.9, 1.1, count)  # N / mm of a muscle
        self._band = random.uniform(0.2, 0.5) * count  # N / mm
        self._carries_n = random.uniform(4, 14) / count
        wide_mm = random.uniform(60, 120)
        self._place_mm = np.linspace(-wide_mm, wide_mm, count) if count > 1 else np.zeros(1)
        self._upright = random.uniform(0.05, 0.25) * wide_mm**2
        self._folds = random.uniform(
            0.35, 1.1
        )  # the half angle at which they are flat, less that at rest, in rad
        self._lever = random.uniform(0.3, 0.8)

    @property
    def low_kpa(self) -> Floats:
        return self._low_kpa

    def _needs(self, way: Floats) -> Floats:
        """The load at a way: a spring of the folds over their lever, which shrinks as they close."""
        return way / (1 - self._lever * np.tanh(self._folds * np.abs(way)))

    def deflection(self, kpa: Floats) -> Floats:
        load = np.abs(kpa / self.high_kpa) * self._needs(np.ones(1))
        low, high = np.zeros_like(load), load + 1e-12
        for _ in range(60):
            way = 0.5 * (low + high)
            less = self._needs(way) < load
            low, high = np.where(less, way, low), np.where(less, high, way)
        return np.sign(kpa) * 0.5 * (low + high)

    def shape(self, deflection: Floats) -> Floats:
        far = self._way_mm * 3 * np.tanh(deflection / 3) / (3 * np.tanh(1 / 3))
        k, u = self._stiff, self._place_mm
        high, tilts, mixed = self._band + k.sum(), self._upright + k @ u**2, k @ u
        right, turn = far @ k, far @ (k * u)
        level = high * tilts - mixed**2
        rise = (tilts * right - mixed * turn) / level
        slope = (high * turn - mixed * right) / level
        pulls = self._carries_n + k * (far - rise[:, None] - slope[:, None] * u)
        told = [rise[:, None], pulls]
        if len(u) > 1:
            told.append(np.rad2deg(np.arctan(slope))[:, None])
        return np.concatenate(told, axis=1)
