"""Further coupling: a line in series, a common housing, bulges that hide each other, a body stiff as a whole."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import alone, full, overlap

_AIR_KPA = 101.3


class LineInSeries(Law):
    """Line in series: each chamber hangs on the line behind the one before, and loses what the others draw through it.

    D. S. Miller, Internal Flow Systems, 2nd ed., BHRA, 1990.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        place = setting.random.permutation(count) + 1.0
        shared = np.minimum(place[:, None], place) / count  # of the line, by two chambers
        np.fill_diagonal(shared, 0.0)
        self._shared = shared * setting.random.uniform(0.3, 0.9) / np.maximum(shared.sum(axis=0).max(), 1e-9)
        self._square = bool(setting.random.random() < 0.5)  # turbulent

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        draws = np.maximum(full(self.rig, kpa), 0.0)
        drop = (draws**2 if self._square else draws) @ self._shared
        return kpa * np.exp(-0.4 * strength * drop)


class CommonHousing(Law):
    """Common housing: bulges squeeze the air of one closed space (Boyle), which presses back on all the others.

    R. Boyle, A Defence of the Doctrine Touching the Spring and Weight of the Air, London, 1662.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._takes = random.uniform(0.6, 1.4, count) / count
        stiff = random.uniform(0.15, 0.4) * float(np.mean(self.rig.high_kpa))
        self._share = stiff / (_AIR_KPA + stiff)  # of the space that all bulges would take at strength 1

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        out = np.maximum(self.rig.deflection(kpa), 0.0) * self._takes
        taken = np.minimum(strength * self._share * (out.sum(axis=1, keepdims=True) - out), 0.9)
        back_kpa = _AIR_KPA * taken / (1 - taken)
        own = np.maximum(kpa, 0.0)
        return kpa - own * -np.expm1(-back_kpa / np.maximum(own, 1e-9))  # never pushed below its seat


class CoveredBulge(Law):
    """Union of bodies: where two bulges lift the same place the higher one counts, and the lower one adds little.

    A. Ricci, A constructive geometry for computer graphics, The Computer Journal 16, 1973.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._each = alone(self.rig)
        self._hides = setting.random.uniform(0.15, 0.5) / max(1.0, 0.5 * len(self._each) - 1)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        twice = np.zeros_like(values)
        for i in range(len(self._each)):
            mine = deflection[:, i : i + 1] * self._each[i]
            for j in range(i):
                other = deflection[:, j : j + 1] * self._each[j]
                both = mine * other
                twice += np.where(both > 0, both / np.maximum(np.abs(mine + other), 1e-12), 0.0) * np.sign(
                    mine
                )
        return values - strength * self._hides * twice


class CoContraction(Law):
    """Co-contraction: what all the others carry makes the whole body stiffer against each one.

    N. Hogan, Adaptive control of mechanical impedance by coactivation of antagonist muscles, IEEE Trans. Automatic
    Control 29, 1984.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._stiffer = random.uniform(0.15, 0.5) * random.uniform(0.8, 1.2, count) / (count - 1)
        self._power = random.uniform(0.7, 1.6)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        carries = self._stiffer * np.maximum(full(self.rig, kpa), 0.0) ** self._power
        others = carries.sum(axis=1, keepdims=True) - carries
        return deflection / (1 + strength * others)


class PairTouches(Law):
    """Two bodies with a gap: one pair of neighbours press each other back, but only once their bulges meet.

    P. Alart, A. Curnier, A mixed formulation for frictional contact problems prone to Newton like solution methods,
    Computer Methods in Applied Mechanics and Engineering 92, 1991.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        near = overlap(self.rig) + 1e-6 * random.random((len(self.rig.chambers),) * 2)
        np.fill_diagonal(near, -1.0)
        self._one = int(random.integers(len(near)))
        self._other = int(np.argmax(near[self._one]))
        self._gap = random.uniform(0.3, 0.8)
        yields = random.uniform(0.2, 0.8)
        self._yields = np.array([yields, 1 - yields])
        self._press = random.uniform(0.8, 2.0)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        pair = deflection[:, [self._one, self._other]]
        meets = np.maximum(np.maximum(pair, 0.0).sum(axis=1) - self._gap, 0.0)
        meets = meets * np.clip(pair.min(axis=1) / 0.1, 0.0, 1.0)  # one that is in is not touched
        back = -np.expm1(-strength * self._press * meets)[:, None] * self._yields
        out = deflection.copy()
        out[:, [self._one, self._other]] = pair * (1 - 0.7 * back)
        return out
