"""Stiffening of the third portion: powers of the load, a knee, an effective area that changes with the way."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import either_way, full, some


class RambergOsgood(Law):
    """Ramberg-Osgood: to a proportional part comes one with a high power of the load: walls give way at the end.

    W. Ramberg, W. R. Osgood, Description of stress-strain curves by three parameters, NACA TN 902, 1943.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._power = setting.random.uniform(3.0, 7.0)
        self._softens = some(setting.random, len(self.rig.chambers), 0.08, 0.3, 0.8)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        size = np.minimum(np.abs(deflection), 1.6)
        return deflection + strength * self._softens * np.sign(deflection) * size**self._power


class HollomonPower(Law):
    """Hollomon's power law: the way goes with a power of the pressure, above one or below it; right at full pressure.

    J. H. Hollomon, Tensile deformation, Trans. AIME 162, 1945.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._power = setting.random.choice([-1.0, 1.0]) * some(
            setting.random, len(self.rig.chambers), 0.08, 0.3, 0.85
        )

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        size = np.maximum(np.abs(load), 1e-9)
        return kpa * size ** np.expm1(np.clip(strength * self._power, -1.5, 1.5))


class RichardAbbott(Law):
    """Richard-Abbott: nearly straight up to a knee, and level beyond it; the knee is sharper than any polynomial's.

    R. M. Richard, B. J. Abbott, Versatile elastic-plastic stress-strain formula, J. Engineering Mechanics Division ASCE
    101, 1975.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._sharp = random.uniform(2.5, 6.0)
        self._beyond = random.uniform(0.0, 0.3)  # the slope that stays
        self._level = some(random, count, 0.3, 1.2, 0.8)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        size = np.abs(deflection)
        bent = size / (1 + strength * self._level * size**self._sharp) ** (1 / self._sharp)
        return deflection + np.sign(deflection) * (1 - self._beyond) * (bent - size)


class ChangingArea(Law):
    """Rolling lobe: the effective area of a bellows changes with its way, in one direction and then perhaps back.

    G. Quaglia, M. Sorli, Air suspension dimensionless analysis and design procedure, Vehicle System Dynamics 35, 2001.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._area = either_way(setting, 0.15, 0.4, 0.85)
        self._turns = setting.random.uniform(0.0, 0.8)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        size = np.minimum(np.abs(deflection), 1.5)
        more = strength * self._area * size * (1 - self._turns * size)
        return deflection * np.exp(np.clip(more, -3.0, 1.2))
