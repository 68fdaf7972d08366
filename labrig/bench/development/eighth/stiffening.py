"""Stiffening of the eighth portion: walls whose compliance falls, or grows, as the pressure does."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some


class ComplianceFallsOff(Law):
    """Falling compliance: each wall is stiffer in proportion to the pressure that it bears.

    F. Daerden and D. Lefeber, Pneumatic artificial muscles: actuators for robotics and automation, European Journal of
    Mechanical and Environmental Engineering 47(1), 2002. The stiffness is the model's, times one and a share of the
    pressure; the share differs a little from wall to wall.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._rise = random.uniform(0.12, 0.3) * random.uniform(0.8, 1.2, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return deflection / (1 + strength * self._rise * np.abs(full(self.rig, kpa)))


class DuffingWall(Law):
    """Cubic wall: the restoring force of a wall has a term with the third power of its deflection.

    G. Duffing, Erzwungene Schwingungen bei veraenderlicher Eigenfrequenz, Vieweg, 1918. The walls are cast of one
    rubber, but are not equally thick.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._cubic = random.uniform(0.12, 0.3) * random.uniform(0.6, 1.4, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        root = np.sqrt(3 * np.maximum(strength * self._cubic, 1e-12))
        return 2 / root * np.sinh(np.arcsinh(1.5 * root * deflection) / 3)


class WavyFibresStraighten(Law):
    """Wavy fibres straighten: some walls hold crimped fibres that bear load, one after the other, beyond a stretch.

    Y. Lanir, Constitutive equations for fibrous connective tissues, Journal of Biomechanics 16(1), 1983. The fibres'
    lengths are spread, so that the knee of the curve is round.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._stiffer = some(random, count, 0.4, 1.0, share=0.6)
        self._straight = random.uniform(0.25, 0.55) * random.uniform(0.85, 1.15, count)
        self._spread = random.uniform(0.04, 0.1)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        past = (np.abs(deflection) - self._straight) / self._spread
        over = self._spread * (np.logaddexp(0.0, past) - np.logaddexp(0.0, -self._straight / self._spread))
        more = strength * self._stiffer
        return deflection - np.sign(deflection) * more / (1 + more) * over


class ThinsAsItStretches(Law):
    """Thinning wall: rubber that is stretched both ways keeps its volume, grows thin and yields the more.

    L. R. G. Treloar, The Physics of Rubber Elasticity, Oxford University Press, 1975. The model has the wall's first
    thickness. Thin spots differ from chamber to chamber; a wall that is pressed in does not thin.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._strain = random.uniform(0.15, 0.3, count)  # at full pressure
        self._size = random.uniform(0.3, 0.6)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        stretch = 1 + self._strain * np.clip(deflection, 0.0, 2.0)
        return deflection * (1 + strength * self._size * (stretch**2 - 1))


class FillerNetwork(Law):
    """Network of filler: particles in the rubber cling together and make it stiff, until strain takes them apart.

    G. Kraus, Mechanical losses in carbon-black-filled rubbers, Journal of Applied Polymer Science, Applied Polymer
    Symposia 39, 1984. So small motions are too small and large ones right. One batch of rubber is in all walls, and
    the network is there again at once.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._more = random.uniform(0.3, 0.7) * random.uniform(0.9, 1.1, count)
        self._apart = random.uniform(0.2, 0.4)
        self._power = random.uniform(1.0, 1.4)  # Kraus's 2 m

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        together = 1 / (1 + (np.abs(deflection) / self._apart) ** self._power)
        return deflection / (1 + strength * self._more * together)
