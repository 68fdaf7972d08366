"""Coupling of the third portion: a supply that runs out, frames that turn along, bowed walls, thrust that softens."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import alone, direction, full, moved, overlap, positions


class RunsOut(Law):
    """Supply that runs out: what all together take lowers its ceiling, and only who asks for more than that gets less.

    S. R. Majumdar, Pneumatic Systems: Principles and Maintenance, McGraw-Hill, 1995.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._takes = random.uniform(0.6, 1.4, count) / count
        self._ceiling = random.uniform(1.0, 1.1)
        self._sinks = random.uniform(0.5, 1.1)
        self._round = random.uniform(0.02, 0.06)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        asked = full(self.rig, kpa)
        size = np.abs(asked)
        others = (size @ self._takes)[:, None] - size * self._takes
        ceiling = self._ceiling * np.exp(-strength * self._sinks * others)
        above = self._round * np.logaddexp(0.0, (size - ceiling) / self._round)
        usual = self._round * np.logaddexp(0.0, (size - self._ceiling) / self._round)
        return kpa - np.sign(kpa) * self.rig.high_kpa * np.minimum(above - usual, size)


class TurnedAlong(Law):
    """Product of exponentials: one chamber turns the ground on which some others stand, and so the way that they move.

    R. W. Brockett, Robotic manipulators and the product of exponentials formula, Mathematical Theory of Networks and
    Systems, Springer, 1984.
    """

    effect = "coupling"
    needs = frozenset({"markers", "several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        assert self.rig.rest_mm is not None
        self._each = positions(self.rig, alone(self.rig) + self.rig.at_rest) - self.rig.rest_mm
        self._turns_rad = np.deg2rad(random.uniform(4, 14)) * np.stack(
            [direction(random) for _ in range(count)]
        )
        on = random.random((count, count)) < 0.6  # who stands on whom
        on[int(random.integers(count - 1)), count - 1] = True
        self._on = np.triu(on, 1)[np.ix_(order := random.permutation(count), order)]

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        for c, each in enumerate(self._each):
            turn = deflection @ (self._on[:, c, None] * self._turns_rad)  # (T, 3)
            way = deflection[:, c, None, None] * each
            points = points + strength * np.cross(turn[:, None], way)
        return moved(self.rig, values, points)


class BowedSeptum(Law):
    """Clamped plate between two chambers: it bows from the fuller into the emptier, which gives way the less.

    S. P. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed., McGraw-Hill, 1959.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, near = setting.random, overlap(self.rig)
        touch = np.where(near >= 0.6 * near.max(), random.uniform(0.6, 1.4, near.shape), 0.0)
        touch = 0.5 * (touch + touch.T)
        self._bows = touch / max(touch.sum(axis=1).max(), 1e-9) * random.uniform(0.1, 0.35)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = np.maximum(full(self.rig, kpa), 0.0)
        change = np.zeros_like(deflection)
        for c, bows in enumerate(self._bows):
            own = load[:, c : c + 1]
            change[:, c] = ((own - load) * np.sqrt(own * load)) @ bows
        return deflection + strength * change


class BeamColumn(Law):
    """Beam column: the thrust of all other chambers softens the body against each, up towards the buckling load.

    S. P. Timoshenko, J. M. Gere, Theory of Elastic Stability, 2nd ed., McGraw-Hill, 1961.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._thrust = random.uniform(0.5, 1.5, count) / count * random.uniform(0.15, 0.4)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        thrust = np.maximum(full(self.rig, kpa), 0.0) * self._thrust
        near = strength * (thrust.sum(axis=1, keepdims=True) - thrust)
        near = 0.75 * np.tanh(near / 0.75)  # it never quite buckles
        return deflection / (1 - near)
