"""Rigs of the twelfth portion, few sensors of several kinds: an elbow, a fingertip, a clasp; others are beside it."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers
from labrig.bench.development.twelfth._sensors import noises


def meets(over: Floats, soft: float) -> Floats:
    """How far something is past the place where it meets an object: none before it, all behind, rounded by `soft`."""
    return soft * np.logaddexp(0.0, np.clip(over / soft, -500.0, 1e6))


class Elbow(Rig):
    """An elbow, or elbow and shoulder: two muscles turn each joint; an encoder tells its angle, load cells the pulls.

    B. Tondu, P. Lopez, Modeling and control of McKibben artificial muscle robot actuators, IEEE Control Systems
    Magazine 20, 2000: a muscle pulls in proportion to a (1 - k e)^2 - b of its shortening e. Both are prestretched by
    the same spring of a joint; its angle is where their torques and that of the spring balance, by Newton's method.
    """

    kind = "elbow"

    def __init__(self, random: np.random.Generator) -> None:
        joints = int(random.choice([1, 2], p=[0.5, 0.5]))
        count = 2 * joints
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(250, 500) * random.uniform(0.95, 1.05, count)
        # of two joints some have load cells at one only
        self._told_pulls = count if joints == 1 or random.random() < 0.7 else 2
        told = [Observable(f"angle{j + 1}", "deg") for j in range(joints)]
        self.observables = (*told, *(Observable(f"pull{c + 1}", "N") for c in range(self._told_pulls)))
        self.noise, self.noisier = noises(random, self.observables, deg=(0.03, 0.12), N=(0.06, 0.2))
        self._full_n = random.uniform(25, 60) * random.uniform(0.92, 1.08, count)
        self._b = random.uniform(0.25, 0.4)  # of a; where it equals the square the muscle is at its shortest
        self._begins = random.uniform(0.85, 0.95)  # 1 - k e of the mounted muscle
        self._turns = random.uniform(0.14, 0.22)  # how much 1 - k e changes by in a radian
        self._spring = random.uniform(0.15, 0.4) * self._full_n.mean()
        self._taut_n = random.uniform(2.0, 6.0, count)
        self._fills_at = random.uniform(0.05, 0.25, count)
        self._zero_deg = random.uniform(-4, 4, joints)

    def deflection(self, kpa: Floats) -> Floats:
        load, slack = kpa / self.high_kpa, self._fills_at
        return load * np.abs(load) * (1 + slack) / (np.abs(load) + slack)

    def shape(self, deflection: Floats) -> Floats:
        pull = self._full_n * 5.0 * np.tanh(deflection / 5.0)
        first, second = pull[:, 0::2], pull[:, 1::2]
        turn = np.zeros_like(first)
        way, c = self._turns, self._begins
        for _ in range(12):
            one, two = c - way * turn, c + way * turn
            torque = first * (one**2 - self._b) - second * (two**2 - self._b) - self._spring * turn
            slope = 2 * way * (np.abs(first) * np.abs(one) + np.abs(second) * np.abs(two)) + self._spring
            turn = np.clip(turn + torque / slope, -1.6, 1.6)
        at = np.empty_like(pull)
        at[:, 0::2], at[:, 1::2] = c - way * turn, c + way * turn
        told_n = self._taut_n + pull * (at**2 - self._b)
        return np.concatenate([self._zero_deg + np.rad2deg(turn), told_n[:, : self._told_pulls]], axis=1)


class Fingertip(Rig):
    """A finger of two joints that presses on an object: two angles, the tip's force, and the travel of what pulls it.

    L. Birglen, T. Laliberté, C. M. Gosselin, Underactuated Robotic Hands, Springer, 2008. One piston pulls both joints
    by a tendon, or each has a bellows of its own; the joints give way to the tip's force by the transposed Jacobian.
    The object, soft or hard, is met at some height; poses are those of least energy, by Newton's method.
    """

    kind = "fingertip"

    def __init__(self, random: np.random.Generator) -> None:
        self._tendon = bool(random.random() < 0.5)
        count = 1 if self._tendon else 2
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(80, 300) * random.uniform(0.95, 1.05, count)
        told = [Observable("near", "deg"), Observable("far", "deg"), Observable("press", "N")]
        self.observables = (*told, *([Observable("travel", "mm")] if self._tendon else []))
        self.noise, self.noisier = noises(
            random, self.observables, deg=(0.05, 0.2), N=(0.03, 0.08), mm=(0.03, 0.1)
        )
        self._long_mm = np.array([random.uniform(40, 55), random.uniform(28, 40)])
        self._free = np.deg2rad(random.uniform(40, 62, 2))  # how far each joint turns with nothing in the way
        self._stiff = random.uniform(400, 900, 2)  # N mm / rad
        self._rest = np.deg2rad(random.uniform(2, 8, 2))
        high_mm = self._height(self._rest + np.ones((1, 2)) * self._free)[0][0]
        self._meets_mm = random.uniform(0.4, 0.65) * high_mm
        self._hard = np.exp(random.uniform(np.log(0.15), np.log(2.5)))  # N / mm
        self._soft_mm = random.uniform(0.8, 1.6)
        self._lever_mm = random.uniform(5, 9, 2)
        self._gives_mm = random.uniform(0.5, 2.5)  # the tendon, under full pull
        self._opens = random.uniform(0.4, 1.5) * random.uniform(0.95, 1.05, count)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * (1 + self._opens) / (1 + self._opens * np.abs(load))

    def _height(self, angle: Floats) -> tuple[Floats, Floats]:
        """The tip's height (T,) in mm at angles (T, 2), and its slopes (T, 2) over them."""
        first, both = angle[:, 0], angle.sum(axis=1)
        a, b = self._long_mm
        slopes = np.stack([a * np.cos(first) + b * np.cos(both), b * np.cos(both)], axis=1)
        return a * np.sin(first) + b * np.sin(both), slopes

    def shape(self, deflection: Floats) -> Floats:
        way = 1.8 * np.tanh(deflection / 1.8) / np.tanh(1 / 1.8) / 1.8
        aim = self._rest + self._free * (way if not self._tendon else np.repeat(way, 2, axis=1))
        at = np.minimum(aim, self._rest + 0.4 * self._free)
        for _ in range(25):
            high, slope = self._height(at)
            over = (high - self._meets_mm) / self._soft_mm
            press = self._hard * meets(over * self._soft_mm, self._soft_mm)
            stiff = self._hard / (1 + np.exp(-np.clip(over, -500, 500)))
            pull = self._stiff * (at - aim) + press[:, None] * slope
            matrix = np.eye(2) * self._stiff + stiff[:, None, None] * slope[:, :, None] * slope[:, None]
            step = np.linalg.solve(matrix, pull[..., None])[..., 0]
            at = at - np.clip(step, -0.12, 0.12)
        press = self._hard * meets(self._height(at)[0] - self._meets_mm, self._soft_mm)
        told = [np.rad2deg(at), press[:, None]]
        if self._tendon:
            told.append((at - self._rest) @ self._lever_mm[:, None] + self._gives_mm * way)
        return np.concatenate(told, axis=1)


class Clasp(Rig):
    """A clasp: two to four soft fingers bend around an object; sensors tell their curvatures, load cells the grip.

    P. Polygerinos et al., Modeling of soft fiber-reinforced bending actuators, IEEE Trans. Robotics 31, 2015: the free
    curvature goes ever faster, as rubber gets thin. The tip that is held is bent back as that of a beam (S. Timoshenko,
    Strength of Materials, Van Nostrand, 1930); what holds it is a spring, the object's.
    """

    kind = "clasp"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(2, 5))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(40, 120) * random.uniform(0.95, 1.05, count)
        self._each = bool(
            count == 2 or random.random() < 0.5
        )  # a load cell under each finger, or one in the wrist
        grips = [f"grip{c + 1}" for c in range(count)] if self._each else ["grip"]
        bends = [Observable(f"bend{c + 1}", "1/m") for c in range(count)]
        self.observables = (*bends, *(Observable(name, "N") for name in grips))
        self.noise, self.noisier = noises(random, self.observables, per_m=(0.04, 0.12), N=(0.02, 0.08))
        long_m = random.uniform(0.07, 0.1)
        self._most = random.uniform(13, 20) * random.uniform(0.93, 1.07, count)  # 1/m
        self._first = random.uniform(0.2, 1.5, count)
        self._reach_mm = 500 * long_m**2  # of the tip, per 1/m
        self._yields = random.uniform(0.6, 1.4)  # 1/m per N at the tip
        far_mm = self._reach_mm * self._most
        self._meets_mm = random.uniform(0.3, 0.55) * far_mm.mean() * random.uniform(0.9, 1.1, count)
        self._hard = np.exp(random.uniform(np.log(0.2), np.log(2.0)))  # N / mm
        self._soft_mm = random.uniform(0.7, 1.5)
        self._shares = random.uniform(
            0.0, 0.25
        )  # of the push of the others that moves the object to a finger
        self._thins = random.uniform(0.4, 1.4) * random.uniform(0.95, 1.05, count)

    def deflection(self, kpa: Floats) -> Floats:
        load = np.minimum(kpa / self.high_kpa, 20.0)
        return np.expm1(self._thins * load) / np.expm1(self._thins)

    def shape(self, deflection: Floats) -> Floats:
        free = self._first + self._most * 2.5 * np.tanh(deflection / 2.5) / (2.5 * np.tanh(0.4))
        back_mm = self._yields * self._reach_mm
        aim_mm = self._reach_mm * free - self._meets_mm
        tip_mm = aim_mm.copy()
        for _ in range(
            40
        ):  # a push grows with the way, and its bending back is a convex function: this comes down
            push = self._hard * meets(tip_mm, self._soft_mm)
            slope = self._hard / (1 + np.exp(-np.clip(tip_mm / self._soft_mm, -500, 500)))
            tip_mm = tip_mm - (tip_mm + back_mm * push - aim_mm) / (1 + back_mm * slope)
        push = self._hard * meets(tip_mm, self._soft_mm)
        bend = (tip_mm + self._meets_mm) / self._reach_mm
        others = (push.sum(axis=1, keepdims=True) - push) / (push.shape[1] - 1)
        grip = push + self._shares * others
        return np.concatenate([bend, grip if self._each else grip.mean(axis=1, keepdims=True)], axis=1)
