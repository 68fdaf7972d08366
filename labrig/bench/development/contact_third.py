"""Contact of the third portion: a round cage, springs beyond a limit, a wedge under a wall, a tether around all."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, moved, positions, reached


class RoundCage(Law):
    """Round cage: a tube around the body, of its form when vented and a gap wider, which no marker can leave.

    J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics, Nonsmooth Mechanics and Applications,
    CISM Courses 302, Springer, 1988.
    """

    effect = "contact"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, path, random = self.rig, setting.path, setting.random
        assert rig.rest_mm is not None
        self._axis = direction(random)
        self._centre_mm = body_mm(rig)[0]
        at_rest = np.linalg.norm(self._across(rig.rest_mm), axis=1)
        met = np.linalg.norm(self._across(positions(rig, rig.settled(path.kpa[path.row]))), axis=2)
        self._inside_mm = at_rest
        self._gap_mm = max(float((met - at_rest).max()), 1e-6)
        self._nearer = random.uniform(0.3, 0.8)

    def _across(self, points: Floats) -> Floats:
        """From the axis to the points, square to it."""
        off = points - self._centre_mm
        return off - (off @ self._axis)[..., None] * self._axis

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        points = positions(self.rig, values)
        across = self._across(points)
        far_mm = np.linalg.norm(across, axis=2)
        wall_mm = self._inside_mm + self._gap_mm * np.exp(-strength * self._nearer)
        past = np.maximum(far_mm - wall_mm, 0.0) / np.maximum(far_mm, 1e-9)
        return moved(self.rig, values, points - past[..., None] * across)


class SpringBeyond(Law):
    """Piecewise-linear stop: beyond a limit a spring comes in beside the wall, which goes on by a share of its way.

    S. W. Shaw, P. J. Holmes, A periodically forced piecewise linear oscillator, J. Sound and Vibration 90, 1983.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._which = random.permutation(count)[: int(random.integers(1, min(count, 3) + 1))]
        self._top = reached(self.rig, setting.path)[self._which]
        self._nearer = random.uniform(0.3, 0.7, len(self._which))
        self._goes_on = random.uniform(0.1, 0.5)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        past = np.maximum(deflection[:, self._which] - self._top * np.exp(-strength * self._nearer), 0.0)
        out = deflection.copy()
        out[:, self._which] -= (1 - self._goes_on) * past
        return out


class Wedge(Law):
    """Wedge: something lies under one wall or two, which cannot come back below it when they are vented.

    F. Pfeiffer, C. Glocker, Multibody Dynamics with Unilateral Contacts, Wiley, 1996.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        own = self.rig.deflection(setting.path.kpa[setting.path.row])
        self._which = random.permutation(count)[: int(random.integers(1, 3))]
        self._low, self._high = own.min(axis=0)[self._which], own.max(axis=0)[self._which]
        self._thick = random.uniform(0.12, 0.3, len(self._which))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        out = deflection.copy()
        floor = self._low + (self._high - self._low) * -np.expm1(-strength * self._thick)
        out[:, self._which] = np.maximum(out[:, self._which], floor)
        return out


class Tether(Law):
    """Tether: a cord around the body gets taut at a length, and then all walls together have no more than that.

    W. Prager, On ideal locking materials, Trans. Society of Rheology 1, 1957.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._takes = random.uniform(0.6, 1.4, count) / count
        self._top = max(
            float(self._length(self.rig.deflection(setting.path.kpa[setting.path.row])).max()), 1e-3
        )
        self._nearer = random.uniform(0.2, 0.5)

    def _length(self, deflection: Floats) -> Floats:
        return np.abs(deflection) @ self._takes

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        length = np.maximum(self._length(deflection), 1e-9)
        share = np.minimum(1.0, self._top * np.exp(-strength * self._nearer) / length)
        return deflection * share[:, None]
