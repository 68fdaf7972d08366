"""Coupling of the seventh portion: valves whose coils sit side by side, and a rubber sheet that is pulled both ways."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full


class CoilsSideBySide(Law):
    """Coils side by side: a valve's force goes with the squared flux, in which its neighbours' coils have a share.

    H. C. Roters, Electromagnetic Devices, Wiley, 1941. Each current is the root of what it gives, so that two open
    valves add the root of their product; a neighbour alone does not lift what its spring holds shut.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        place = random.permutation(count)  # on the island of valves
        apart = np.abs(place[:, None] - place) + np.eye(count)
        share = random.uniform(0.015, 0.05) * random.uniform(0.7, 1.3, (count, count)) / apart**2
        self._share = 2 * (1 - np.eye(count)) * (share + share.T) / 2
        self._sign = random.choice([-1.0, 1.0])  # how the coils are wound

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        current = np.sqrt(np.abs(load))
        more = strength * self._sign * current * (current @ self._share)
        return np.sign(load) * np.maximum(np.abs(load) + more, 0.0) * self.rig.high_kpa


def _stretched(one: Floats, other: Floats) -> tuple[Floats, Floats]:
    """The stretches of a neo-Hookean sheet under two pulls that cross, by Newton's method."""
    a, b = np.ones_like(one), np.ones_like(one)
    for _ in range(12):
        off_a, off_b = a - 1 / (a**3 * b**2) - one, b - 1 / (b**3 * a**2) - other
        aa, bb, ab = 1 + 3 / (a**4 * b**2), 1 + 3 / (b**4 * a**2), 2 / (a * b) ** 3
        det = aa * bb - ab**2
        a = np.maximum(a - (bb * off_a - ab * off_b) / det, 0.5 * a)
        b = np.maximum(b - (aa * off_b - ab * off_a) / det, 0.5 * b)
    return a, b


class PulledBothWays(Law):
    """Sheet pulled both ways: rubber that keeps its volume is thinner and narrower for each pull, because of the other.

    R. S. Rivlin, Large elastic deformations of isotropic materials IV, Phil. Trans. Royal Society A 241, 1948. What
    each chamber of a pair does alone is as modelled, and so is their sum.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        order = random.permutation(count)
        pairs = int(random.integers(1, max(2, count // 2) + 1))
        starts = random.permutation(count)[:pairs]
        self._pairs = [(int(order[k]), int(order[(k + 1) % count])) for k in starts]
        self._pull = random.uniform(1.0, 3.0, pairs)
        self._size = random.uniform(2.0, 5.0)  # so much stiffer is the sheet than the walls that pull it

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        out = deflection.copy()
        for (one, other), pull in zip(self._pairs, self._pull, strict=True):
            a, b = (pull * np.minimum(np.abs(deflection[:, c]), 2.0) for c in (one, other))
            none = np.zeros_like(a)
            both, first, second = _stretched(a, b), _stretched(a, none), _stretched(none, b)
            for c, k in ((one, 0), (other, 1)):
                more = (both[k] - first[k] - second[k] + 1) / pull
                out[:, c] += strength * self._size * np.sign(deflection[:, c]) * more
        return out
