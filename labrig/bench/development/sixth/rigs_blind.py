"""Rigs of the sixth portion without markers: a sleeve around a heart, a suit, a mirror, and inflated links."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers


class Heart(Rig):
    """A sleeve around a heart: rings squeeze its ventricles, each by a factor, and catheters tell what is left in them.

    E. T. Roche, M. A. Horvath, I. Wamala et al., Soft robotic sleeve supports heart function, Science Translational
    Medicine 9, 2017. Rings level off exponentially.
    """

    kind = "heart"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(2, 7)), int(random.integers(1, 4))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(60, 160) * random.uniform(0.95, 1.05, count)
        self.observables = tuple(Observable(f"volume{k + 1}", "ml") for k in range(seen))
        self.noise = float(random.uniform(0.04, 0.12))
        self._full_ml = random.uniform(70, 140, seen)
        self._squeezes = random.uniform(0.1, 0.3) * random.uniform(0.4, 1.2, (count, seen))
        self._floor = random.uniform(0.1, 0.3)
        self._levels = random.uniform(0.6, 2.5, count)

    def deflection(self, kpa: Floats) -> Floats:
        return np.expm1(-self._levels * kpa / self.high_kpa) / np.expm1(-self._levels)

    def shape(self, deflection: Floats) -> Floats:
        left = np.exp(-np.clip(deflection @ self._squeezes, -2.0, 20.0))
        return self._full_ml * (self._floor + (1 - self._floor) * left)


class Suit(Rig):
    """A suit of cloth: bladders behind the joints press in proportion to pressure, and some span two joints.

    S. Sridar, P. H. Nguyen, M. Zhu, Q. P. Lam, P. Polygerinos, Development of a soft-inflatable exosuit for knee
    rehabilitation, IEEE/RSJ Int. Conference on Intelligent Robots and Systems, 2017. A dummy's joints are held fast,
    and tell torques; all is linear.
    """

    kind = "suit"

    def __init__(self, random: np.random.Generator) -> None:
        joints = int(random.integers(2, 7))
        count = joints + int(random.integers(0, 3))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(50, 200) * random.uniform(0.8, 1.2, count)
        self.observables = tuple(Observable(f"joint{k + 1}", "N m") for k in range(joints))
        self.noise = float(random.uniform(0.03, 0.08))
        arms = np.vstack([np.eye(joints), np.zeros((count - joints, joints))])
        for c in range(joints, count):
            first = int(random.integers(joints - 1))
            arms[c, first : first + 2] = [random.uniform(0.4, 0.9), -random.uniform(0.3, 0.9)]
        spills = 0.1 * random.normal(size=arms.shape)  # straps pull at the other joints a little
        self._torque_nm = random.uniform(8, 25) * random.uniform(0.8, 1.2, (count, 1)) * (arms + spills)
        self._zero_nm = random.normal(0, 0.5, joints)

    def deflection(self, kpa: Floats) -> Floats:
        return np.asarray(kpa / self.high_kpa, dtype=float)

    def shape(self, deflection: Floats) -> Floats:
        return self._zero_nm + deflection @ self._torque_nm


class Mirror(Rig):
    """A deformable mirror: cells behind a thin plate push it out, and an interferometer tells heights about their mean.

    R. K. Tyson, Principles of Adaptive Optics, Academic Press, 1991. What one cell lifts fades as a power of the
    exponential; cells give way ever more, by a parabola.
    """

    kind = "mirror"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(9, 15)), int(random.integers(20, 61))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(5, 20) * random.uniform(0.9, 1.1, count)
        self.observables = tuple(Observable(f"height{k + 1}", "um") for k in range(seen))
        self.noise = float(random.uniform(0.01, 0.03))

        def disc(number: int) -> Floats:
            turn = 2.39996 * np.arange(number)
            far = np.sqrt((np.arange(number) + 0.5) / number)
            return far[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])

        apart = np.linalg.norm(disc(count)[:, None] - 0.95 * disc(seen), axis=2)
        spacing, beside, power = 1.8 / np.sqrt(count), random.uniform(0.1, 0.3), random.uniform(1.5, 2.2)
        lift = np.exp(np.log(beside) * (apart / spacing) ** power)
        self._lift_um = random.uniform(3, 8) * random.uniform(0.85, 1.15, (count, 1)) * lift
        self._figure_um = random.normal(0, 0.2, seen)
        self._opens = random.uniform(0.1, 0.8, count)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * (1 + self._opens * np.abs(load)) / (1 + self._opens)

    def shape(self, deflection: Floats) -> Floats:
        height = self._figure_um + deflection @ self._lift_um
        return height - height.mean(axis=1, keepdims=True)


class Links(Rig):
    """Inflated links: a pair of bladders turns each joint by their difference, the less, the fuller both of them are.

    S. Sanan, J. B. Moidel, C. G. Atkeson, Robots with inflatable links, IEEE/RSJ Int. Conference on Intelligent Robots
    and Systems, 2009. Gyroscopes tell how far each link is turned in space. Cloth gives way fast until it is taut.
    """

    kind = "links"

    def __init__(self, random: np.random.Generator) -> None:
        joints = int(random.integers(2, 6))
        count = 2 * joints
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(10, 50) * random.uniform(0.94, 1.06, count)
        self.observables = tuple(Observable(f"link{k + 1}", "deg") for k in range(joints))
        self.noise = float(random.uniform(0.1, 0.3))
        self._turns_deg = random.uniform(25, 60) * random.uniform(0.85, 1.15, joints)
        self._stiffer = random.uniform(0.1, 0.8)
        self._first_deg = random.normal(0, 8, joints)
        self._taut, self._before = random.uniform(0.25, 0.6, count), random.uniform(1.6, 4.0, count)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        past = np.maximum(load - self._taut, 0.0)
        return (self._before * (load - past) + past) / (self._before * self._taut + 1 - self._taut)

    def shape(self, deflection: Floats) -> Floats:
        one, other = deflection[:, 0::2], deflection[:, 1::2]
        own = self._turns_deg * (one - other) / (1 + self._stiffer * (np.abs(one) + np.abs(other)))
        return np.cumsum(self._first_deg + own, axis=1)
