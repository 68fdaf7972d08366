"""Stiffening of the ninth portion: walls like rubber, plate, tissue and sleeves."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting


def _alike(setting: Setting, low: float, high: float) -> Floats:
    """One size for the batch of rubber, a little different in each chamber's wall, (C,)."""
    count = len(setting.rig.chambers)
    return setting.random.uniform(low, high) * setting.random.uniform(0.85, 1.15, count)


class LimitedChains(Law):
    """Limited chains: rubber hardens as its molecules near their full length, with J / (J - I1 + 3).

    A. N. Gent, A new constitutive relation for rubber, Rubber Chemistry and Technology 69(1), 1996. I1 - 3
    grows with the square of the stretch, so d / (1 - d^2 / J) is what a wall without limit would do.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._inverse = _alike(setting, 0.15, 0.4)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return 2 * deflection / (1 + np.sqrt(1 + 4 * strength * self._inverse * deflection**2))


class NeoHookean(Law):
    """Neo-Hookean wall: ideal rubber softens, by the stretch less its inverse square.

    L. R. G. Treloar, The Physics of Rubber Elasticity, Clarendon Press, 1949. A base that takes the first
    slope for good moves too little: each further kPa moves such a wall more than the one before.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._stretch = _alike(setting, 0.15, 0.35)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength == 0:
            return deflection
        strain = strength * self._stretch
        stress = 3 * strain * np.abs(deflection)
        ratio = 1 + stress
        for _ in range(40):  # Newton from above, for ratio - ratio^-2 = stress
            ratio = ratio - (ratio**3 - stress * ratio**2 - 1) / (3 * ratio**2 - 2 * stress * ratio)
        return np.sign(deflection) * (ratio - 1) / strain


class LargeDeflection(Law):
    """Large deflection: a plate that moves by more than its thickness stretches, and is held.

    S. Timoshenko and S. Woinowsky-Krieger, Theory of Plates and Shells, McGraw-Hill, 1959: w + a w^3 = q,
    where q is what the bending alone would let it do.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._cubic = _alike(setting, 0.2, 0.5)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength == 0:
            return deflection
        scale = 2 / np.sqrt(3 * strength * self._cubic)
        return scale * np.sinh(np.arcsinh(3 * deflection / scale) / 3)


class Exponential(Law):
    """Exponential wall: its stiffness grows in proportion to its stress, as in tissue and in knitted cloth.

    Y. C. Fung, Elasticity of soft tissues in simple elongation, American Journal of Physiology 213, 1967:
    stress goes with exp(b strain) - 1, so the strain goes with the logarithm of one and b times the load.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._b = _alike(setting, 0.4, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength == 0:
            return deflection
        b = strength * self._b
        return np.sign(deflection) * np.log1p(b * np.abs(deflection)) / b


class SleeveLocks(Law):
    """Sleeve locks: from some stretch on a sleeve's threads lie straight, and carry with the wall.

    K. C. Galloway et al., Mechanically programmable bend radius for fiber-reinforced soft actuators,
    International Conference on Advanced Robotics, 2013. Two slopes with a knee; the sleeves are cut alike,
    not quite equal.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._knee = random.uniform(0.3, 0.55) + random.normal(0, 0.03, count)
        self._sleeve = _alike(setting, 0.5, 1.2)  # as stiff as so many walls

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        size = np.abs(deflection)
        over = np.maximum(size - self._knee, 0.0)
        more = strength * self._sleeve
        return np.sign(deflection) * (size - over * more / (1 + more))
