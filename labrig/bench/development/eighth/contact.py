"""Contact of the eighth portion: stops, bumpers, a cradle, a bench and an object that is gripped."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import pattern, reached, some


class StopAtDeflection(Law):
    """Stop at a deflection: some walls meet a rigid stop before their full stroke, and go no further.

    K. L. Johnson, Contact Mechanics, Cambridge University Press, 1985. More pressure only presses harder.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._stroke = reached(self.rig, setting.path)
        self._short = some(setting.random, len(self.rig.chambers), 0.2, 0.5, share=0.6)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength == 0:
            return deflection
        stop = np.where(self._short > 0, self._stroke / (1 + strength * self._short), np.inf)
        return np.minimum(deflection, stop)


class AgainstTheBench(Law):
    """Against the bench: the body as a whole meets something hard on its way, and that way ends there.

    D. E. Stewart, Rigid-body dynamics with friction and impact, SIAM Review 42(1), 2000. The motion along the way that
    all chambers make together is stopped; the body still slides across it.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        way = pattern(self.rig)
        along = (self.rig.settled(setting.path.kpa) - self.rig.at_rest) @ way
        self._way = way if along.max() >= -along.min() else -way
        self._most = float(np.quantile(np.maximum((along * np.sign(way @ self._way)), 0.0), 0.99))
        self._near = setting.random.uniform(0.25, 0.6)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        along = (values - self.rig.at_rest) @ self._way
        stop = self._most / (1 + strength * self._near) if strength > 0 else np.inf
        return values - np.maximum(along - stop, 0.0)[:, None] * self._way


class SoftBumper(Law):
    """Soft bumper: every wall runs onto a pad of rubber, which yields a little and then ever less.

    A. N. Gent (editor), Engineering with Rubber, Hanser, 2012. The pads sit where the assembly put them. What the wall
    would go beyond its pad is pressed into it, and a pad that is thin is soon solid.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._meets = random.uniform(0.45, 0.7) * random.uniform(0.85, 1.15, count)
        self._meets *= reached(self.rig, setting.path)
        self._pad = random.uniform(0.3, 0.7)  # how far it can be pressed, as a share of the stroke

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        over = np.maximum(deflection - self._meets, 0.0)
        return deflection - over + over / (1 + strength * over / (self._pad * self._meets))


class LandsOnCradle(Law):
    """Lands on a cradle: on their way home some walls come to lie on a support, short of where they would rest.

    A. H. Slocum, Precision Machine Design, Prentice Hall, 1992. The support was put a little too high; above it
    nothing is changed.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._high = some(random, count, 0.1, 0.2, share=0.7) * reached(self.rig, setting.path)
        self._low = self.rig.deflection(setting.path.kpa[setting.path.row]).min(axis=0)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        support = np.where(self._high > 0, self._low + strength * self._high, -np.inf)
        return np.where(strength > 0, np.maximum(deflection, support), deflection)


class ClosesOnObject(Law):
    """Closes on an object: all chambers together close a grip, and stop when it is closed, whoever closed it.

    A. Bicchi, Hands for dexterous manipulation and robust grasping, IEEE Transactions on Robotics and Automation 16(6),
    2000. The sum of the deflections is limited; each chamber yields its part of what is too much.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._weight = random.uniform(0.7, 1.3, count)
        total = np.maximum(self.rig.deflection(setting.path.kpa), 0.0) @ self._weight
        self._closed = float(np.quantile(total, 0.97))
        self._thick = random.uniform(0.25, 0.6)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        out = np.maximum(deflection, 0.0)
        total = out @ self._weight
        closed = self._closed / (1 + strength * self._thick) if strength > 0 else np.inf
        share = np.minimum(1.0, closed / np.maximum(total, 1e-9))[:, None]
        return np.where(deflection > 0, share * out, deflection)
