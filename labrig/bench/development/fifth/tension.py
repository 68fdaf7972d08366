"""Tension of the fifth portion: bands that slope, sleeves that were knitted tight, covers that are laced."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Setting
from labrig.bench.development._places import some
from labrig.bench.development.tension import HeldBack


class SlopingBands(HeldBack):
    """Sloping bands: tight bands along the skin hold back by the angle to which they have been lifted.

    C. R. Calladine, Theory of Shell Structures, Cambridge University Press, 1983.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._steep_at = random.uniform(0.15, 0.5) * random.uniform(0.9, 1.1, count)
        self._pull = random.uniform(0.05, 0.14) * some(random, count, 0.75, 1.25, random.uniform(0.7, 1.0))

    def _held(self, deflection: Floats) -> Floats:
        return self._pull * np.arctan(deflection / self._steep_at)


class KnittedSleeve(HeldBack):
    """Knitted sleeve: its loops, tight at first, straighten and let go; what they hold fades as a bell of the way.

    D. L. Munden, The geometry and dimensional properties of plain-knit fabrics, J. Textile Institute 50, 1959.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._lets_go_at = random.uniform(0.35, 0.8) * random.uniform(0.9, 1.1, count)
        self._tight = some(random, count, 0.15, 0.4, 0.9)

    def _held(self, deflection: Floats) -> Floats:
        return self._tight * deflection * np.exp(-((deflection / self._lets_go_at) ** 2))


class LacedCover(HeldBack):
    """Laced cover: a cover drawn tight holds back by the logarithm of how far it is stretched, most at the beginning.

    H. Hencky, Über die Form des Elastizitätsgesetzes bei ideal elastischen Stoffen, Zeitschrift für technische Physik
    9, 1928.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._short = random.uniform(0.05, 0.25)
        self._pull = random.uniform(0.03, 0.08) * random.uniform(0.7, 1.3, count)

    def _held(self, deflection: Floats) -> Floats:
        return self._pull * np.sign(deflection) * np.log1p(np.abs(deflection) / self._short)
