"""Coupling of the fifth portion: ground loops, the way of least resistance, bends that together make a twist."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, full, long_axis, overlap, span, spread


class GroundLoop(Law):
    """Ground loop: the pressure sensors share a wire, whose voltage shifts each reading by what the others draw.

    H. W. Ott, Noise Reduction Techniques in Electronic Systems, 2nd ed., Wiley, 1988. Some draw through it one way and
    some the other; the valve of a vented chamber is shut.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        near = np.exp(-np.abs(np.subtract.outer(np.arange(count), np.arange(count))) / random.uniform(1, 4))
        sign = np.where(random.random((count, count)) < 0.25, -1.0, 1.0)
        self._shifts = random.uniform(0.03, 0.1) * near * sign * random.uniform(0.5, 1.5, (count, count))
        np.fill_diagonal(self._shifts, 0.0)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        open_ = np.tanh(np.abs(load) / 0.04)
        return kpa + strength * self.rig.high_kpa * open_ * (load @ self._shifts.T)


class LeastResistance(Law):
    """Way of least resistance: who works at a high load loses flow to those that are open at lower ones.

    J. Watton, Fundamentals of Fluid Power Control, Cambridge University Press, 2009 (parallel circuits without pressure
    compensation).
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._draws = random.uniform(0.5, 1.5, count) / (count - 1)
        self._loses = random.uniform(0.2, 0.6)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        size = np.abs(load)
        open_ = np.tanh(size / 0.05) * self._draws
        above = np.maximum(size[:, :, None] - size[:, None], 0.0)  # (T, C, others)
        loses = np.einsum("tco,to->tc", above, open_)
        return kpa * np.exp(-strength * self._loses * loses)


class BendTwist(Law):
    """Bend-twist coupling: two chambers that bend a body together also twist it, which neither does alone.

    R. M. Jones, Mechanics of Composite Materials, McGraw-Hill, 1975. The twist goes with the product of the two; of a
    body that is seen from above only the sideways sweep of it shows.
    """

    effect = "coupling"
    needs = frozenset({"markers", "several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, near, (centre, radius) = setting.random, overlap(self.rig), body_mm(self.rig)
        assert self.rig.rest_mm is not None
        axis, along = long_axis(self.rig)
        if random.random() < 0.5:
            along = 1 - along
        field = np.cross(axis, self.rig.rest_mm - centre) / radius * along[:, None]
        twist = spread(self.rig, field)
        if float(np.sqrt(np.mean(twist**2))) < 0.05:  # it turns out of what is measured
            aside = np.cross(axis, [0.0, 0.0, 1.0])
            twist = spread(self.rig, along[:, None] ** 2 * aside)
        self._twist = twist / max(float(np.sqrt(np.mean(twist**2))), 1e-9)
        size = np.triu(near * random.uniform(0.5, 1.5, near.shape), 1)
        self._pairs = size / size.max() * random.choice([-1.0, 1.0], near.shape)
        self._pairs *= span(self.rig) * random.uniform(0.1, 0.4)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        both = np.einsum("tc,co,to->t", deflection, self._pairs, deflection)
        return values + strength * both[:, None] * self._twist
