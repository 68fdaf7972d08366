"""Stiffening of the twelfth portion: two laws of rubber, and ligaments at both ends of a joint."""

from abc import abstractmethod

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development.twelfth._sensors import added, sensors, usual


class _Rubber(Law):
    """What both share: the way goes with one over the true secant stiffness, right at one deflection as modelled."""

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._strain = random.uniform(0.35, 0.8) * random.uniform(0.9, 1.1, count)  # at full deflection
        self._right = random.uniform(0.3, 1.0)

    @abstractmethod
    def _stress(self, stretch: Floats) -> Floats:
        """The stress at stretches (..., C)."""

    def _secant(self, deflection: Floats) -> Floats:
        strain = self._strain * np.clip(np.abs(deflection), 1e-3, 6.0)
        return self._stress(1 + strain) / strain

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        right = self._secant(np.full(deflection.shape[1], self._right))
        return deflection * (right / self._secant(deflection)) ** strength


class Carroll(_Rubber):
    """Carroll: to the neo-Hookean term come the fourth power of the first invariant and the root of the second.

    M. M. Carroll, A strain energy function for vulcanized rubbers, J. Elasticity 103, 2011, of one pull. The root makes
    it softer at first, the fourth power stiffer in the end.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._fourth = setting.random.uniform(0.2, 2.5) * 1e-3
        self._root = setting.random.uniform(0.3, 2.5)

    def _stress(self, stretch: Floats) -> Floats:
        pulls = stretch - stretch**-2
        first, second = stretch**2 + 2 / stretch, 2 * stretch + stretch**-2
        return pulls * (2 + 8 * self._fourth * first**3 + self._root / (stretch * np.sqrt(second)))


class LopezPamies(_Rubber):
    """Lopez-Pamies: two powers of the first invariant, one low and one high, over the whole way of a rubber.

    O. Lopez-Pamies, A new I1-based hyperelastic model for rubber elastic materials, Comptes Rendus Mécanique 338, 2010,
    of one pull.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._powers = np.array([random.uniform(0.5, 0.9), random.uniform(2.0, 5.0)])
        self._parts = np.array([1.0, random.uniform(0.02, 0.15)])

    def _stress(self, stretch: Floats) -> Floats:
        first = stretch**2 + 2 / stretch
        terms = [m * (first / 3) ** (a - 1) for m, a in zip(self._parts, self._powers, strict=True)]
        return (stretch - stretch**-2) * np.sum(terms, axis=0)


class Ligaments(Law):
    """Ligaments: a joint's own moment is one exponential towards each end of its range, and hardly any in between.

    R. Riener, T. Edrich, Identification of passive elastic joint moments in the lower extremities, J. Biomechanics 32,
    1999. Each joint has its own; its angle is held back where they act, and nothing else is.
    """

    effect = "stiffening"
    needs = frozenset({"angle"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig, path = setting.random, self.rig, setting.path
        self._angles = sensors(rig, "deg")
        count = len(self._angles)
        shown = rig.settled(path.kpa[path.row])[:, self._angles]
        self._far = usual(rig, path)[self._angles]
        self._ends = np.stack([shown.min(axis=0), shown.max(axis=0)])
        self._steep = random.uniform(1.5, 4.0, (2, count))  # per usual way
        self._size = random.uniform(0.08, 0.25, (2, count))  # of the usual way, at the ends

    def _moment(self, past: Floats, end: int) -> tuple[Floats, Floats]:
        """The moment of one end at angles (T, A) past it, and its slope: a straight line from far beyond it on."""
        x = self._steep[end] * past
        near = np.clip(x, -60.0, 1.5)
        grows = np.exp(near)
        moment = self._size[end] * grows * (1 + np.maximum(x - near, 0.0))
        return moment, self._size[end] * self._steep[end] * grows

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        free = values[:, self._angles]
        at = free.copy()
        low, high = self._ends
        for _ in range(30):  # by Newton's method
            up, up_by = self._moment((at - high) / self._far, 1)
            down, down_by = self._moment((low - at) / self._far, 0)
            slope = 1 + strength * (up_by + down_by)
            off = at + strength * self._far * (up - down) - free
            at = at - np.clip(off / slope, -self._far, self._far)
        return added(values, self._angles, at - free)
