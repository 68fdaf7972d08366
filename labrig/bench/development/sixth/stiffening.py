"""Stiffening of the sixth portion: strained beforehand, power laws of strain, braids that turn, disc springs."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some


def _way(free: Floats, load_of: Callable[[Floats], Floats], top: float = 4.0) -> Floats:
    """The way (T, C) at which a growing `load_of` it is as large as `free`; it keeps the sign."""
    load = np.abs(free)
    low, high = np.zeros_like(load), top * load + 1e-9
    for _ in range(34):
        middle = 0.5 * (low + high)
        far = load_of(middle) > load
        low, high = np.where(far, low, middle), np.where(far, middle, high)
    return np.sign(free) * 0.5 * (low + high)


class StrainedBeforehand(Law):
    """Swift: a wall that was strained before it was mounted is at another place on its power law, steep at first.

    H. W. Swift, Plastic instability under plane stress, J. Mechanics and Physics of Solids 1, 1952. It is right at full
    load, where it was calibrated, or at first.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._before = random.uniform(0.1, 0.6, count)
        self._power = random.uniform(0.3, 0.8)
        self._at_full = random.random() < 0.5
        self._size = some(random, count, 0.3, 0.9, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        size, none = np.abs(deflection), self._before**self._power
        way = (self._before + size) ** self._power - none
        if self._at_full:
            way = way / ((1 + self._before) ** self._power - none)
        else:
            way = way / (self._power * self._before ** (self._power - 1))
        return deflection + strength * self._size * np.sign(deflection) * (way - size)


class PowerOfStrain(Law):
    """Knowles: the stress is the strain times a power of one plus its square: it hardens, or softens, without end.

    J. K. Knowles, The finite anti-plane shear field near the tip of a crack for a class of incompressible elastic
    solids, Int. J. Fracture 13, 1977.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._power = random.uniform(1.5, 2.5) if random.random() < 0.65 else random.uniform(0.6, 0.8)
        self._strain = some(random, count, 0.2, 0.7, 0.85)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        n, by = self._power, strength * self._strain / self._power
        return np.where(by > 0, _way(deflection, lambda d: d * (1 + by * d**2) ** (n - 1)), deflection)


class TurningBraid(Law):
    """Braid: as the sleeve shortens its threads turn, and the same pressure pulls by three squared cosines less one.

    H. F. Schulte, The characteristics of the McKibben artificial muscle, in The Application of External Power in
    Prosthetics and Orthotics, National Academy of Sciences, 1961.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._cos2 = np.cos(np.deg2rad(random.uniform(18, 32))) ** 2
        self._shortens = some(random, count, 0.04, 0.12, 0.9)  # of its length, at full load

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        free = self.rig.deflection(kpa)
        low, high = np.zeros_like(free), np.abs(free)
        for _ in range(24):
            middle = 0.5 * (low + high)
            now = self._cos2 * np.exp(-2 * strength * self._shortens * middle)
            pulls = np.maximum(3 * now - 1, 0.0) / (3 * self._cos2 - 1)
            far = middle > np.abs(self.rig.deflection(kpa * pulls))
            low, high = np.where(far, low, middle), np.where(far, middle, high)
        way = np.where(self._shortens > 0, np.sign(free) * 0.5 * (low + high), free)
        return deflection + way - free


class DiscSprings(Law):
    """Disc springs: corrugations give way the more, the flatter they are, and past flat they resist again.

    J. O. Almen, A. Laszlo, The uniform-section disk spring, Trans. ASME 58, 1936. One or two walls have deep ones.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        few = random.random() < 0.4
        self._high = random.uniform(0.7, 1.25, count)  # of a disc, over its thickness
        self._flat_at = random.uniform(0.5, 1.5, count)  # the way at which it is flat
        on = random.permutation(count) < (int(random.integers(1, 3)) if few else count)
        self._size = np.where(on, random.uniform(0.3, 0.8, count), 0.0)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load, high = full(self.rig, kpa), self._high

        def load_of(way: Floats) -> Floats:
            gone = high * way / self._flat_at
            return way * ((high - gone) * (high - 0.5 * gone) + 1) / (high**2 + 1)

        way = _way(load, load_of)
        return kpa + strength * self._size * self.rig.high_kpa * (way - load)
