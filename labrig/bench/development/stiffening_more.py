"""Further stiffening: rubber laws that soften before they stiffen, chains of finite length, layers that get taut."""

from abc import abstractmethod
from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some

_STRETCH = 1 + np.concatenate([[0.0], np.geomspace(1e-4, 7.0, 1500)])


class _Stretched(Law):
    """What the laws below share: at strength 0 a wall is used where its curve is straight, and ever farther along."""

    effect = "stiffening"
    _range: ClassVar[tuple[float, float]]

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        low, high = self._range
        self._along = some(setting.random, len(self.rig.chambers), low, high, 0.85)
        load = self._load(setting.random)
        apart = np.diff(_STRETCH, prepend=1.0)
        slope = load[1] / apart[1]
        rise = np.maximum(np.diff(load, prepend=0.0), 0.02 * slope * apart)  # it bulges, but does not burst
        self._of = np.cumsum(rise) / slope

    @abstractmethod
    def _load(self, random: np.random.Generator) -> Floats:
        """The load at each of the stretches `_STRETCH`."""

    def _way(self, load: Floats, strength: float) -> Floats:
        """How far loads (T, C) move the walls; in proportion at first."""
        along = np.maximum(strength * self._along, 1e-6)
        way = np.interp(along * np.abs(load), self._of, _STRETCH - 1) / along
        return np.where(strength * self._along > 1e-6, np.sign(load) * way, load)


class MooneyRivlin(_Stretched):
    """Mooney-Rivlin balloon: the wall gets softer as it gets thinner, until its second constant stiffens it again.

    M. Mooney, A theory of large elastic deformation, J. Applied Physics 11, 1940.
    """

    _range = (0.03, 0.1)

    def _load(self, random: np.random.Generator) -> Floats:
        second = random.uniform(0.2, 0.5)
        return (1 / _STRETCH - _STRETCH**-7) * (1 + second * _STRETCH**2)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return self._way(deflection, strength)


class Yeoh(Law):
    """Yeoh's cubic: filled rubber under shear is soft in the middle, where its fillers let go, and stiff at the end.

    O. H. Yeoh, Some forms of the strain energy function for rubber, Rubber Chemistry and Technology 66, 1993.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._softens = random.uniform(0.15, 0.35) * random.uniform(0.85, 1.15, count)
        self._stiffens = random.uniform(4.0, 6.0) * self._softens**2
        self._shear = np.linspace(0.0, 6.0, 3000)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        out = deflection.copy()
        square = self._shear**2
        for c, (softens, stiffens) in enumerate(zip(self._softens, self._stiffens, strict=True)):
            load = self._shear * (1 + strength * (stiffens * square - softens) * square)
            way = np.interp(np.abs(deflection[:, c]), np.maximum.accumulate(load), self._shear)
            out[:, c] = np.sign(deflection[:, c]) * way
        return out


class Ogden(_Stretched):
    """Ogden: powers of the stretch; with a high one the wall is stiffer from the first kPa on.

    R. W. Ogden, Large deformation isotropic elasticity: on the correlation of theory and experiment for incompressible
    rubberlike solids, Proc. Royal Society A 326, 1972.
    """

    _range = (0.06, 0.2)

    def _load(self, random: np.random.Generator) -> Floats:
        power = random.uniform(7.0, 12.0)
        return _STRETCH ** (power - 1) - _STRETCH ** (-0.5 * power - 1)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return self.rig.high_kpa * self._way(full(self.rig, kpa), strength)


class ArrudaBoyce(Law):
    """Arruda-Boyce: eight chains of finite length, which straighten by Langevin's function, in every wall alike.

    E. M. Arruda, M. C. Boyce, A three-dimensional constitutive model for the large stretch behavior of rubber elastic
    materials, J. Mechanics and Physics of Solids 41, 1993.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._straight = setting.random.uniform(0.25, 0.7)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        pull = np.maximum(3 * strength * self._straight * np.abs(full(self.rig, kpa)), 1e-2)
        share = 3 * (1 / np.tanh(pull) - 1 / pull) / pull  # of the way of a chain without end
        return kpa * share


class StrainLimitingLayer(Law):
    """Strain-limiting layer: from some stretch on slack fibres get taut, one after another, and share the load.

    P. Polygerinos et al., Modeling of soft fiber-reinforced bending actuators, IEEE Trans. Robotics 31, 2015.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._taut_at = random.uniform(0.15, 0.45) * random.uniform(0.8, 1.2, count)
        self._spread = random.uniform(0.1, 0.25)
        self._stiffer = random.uniform(0.3, 1.2, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        beyond = self._rounded(deflection) - self._rounded(np.zeros(1))
        stiff = strength * self._stiffer
        return deflection - stiff / (1 + stiff) * beyond

    def _rounded(self, deflection: Floats) -> Floats:
        """How far each wall is beyond the stretch at which its fibres get taut."""
        return self._spread * np.logaddexp(0.0, (deflection - self._taut_at) / self._spread)
